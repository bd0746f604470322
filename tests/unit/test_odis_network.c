/* SPDX-License-Identifier: Apache-2.0 */
/* The guide's network in C against PyTorch's outputs for stored inputs (guide/train/export.py --test). */

#include "tests/unit/check.h"

#include <stdio.h>
#include <string.h>

#include "guide/odis/network.h"

#define INPUTS (GATHER_PLANES + 3)
#define RECORD ((INPUTS + 2) * SPHERE_BINS)

static void test_c_equals_pytorch(void **state) {
    (void)state;
    FILE *file = fopen(TEST_DATA "/odis_reference.bin", "rb");
    assert_non_null(file);
    struct odis_weights *weights = NULL;
    struct fewray_error error;
    assert_int_equal(odis_weights_load(NULL, &weights, &error), 0);
    struct odis_network *network = odis_network_create(weights);
    static float record[RECORD];
    static struct gathered g;
    int records = 0;
    while (fread(record, sizeof(record), 1, file) == 1) {
        memcpy(g.planes, record, sizeof(g.planes));
        memcpy(g.mask, record + 10 * SPHERE_BINS, sizeof(g.mask));
        memcpy(g.cosine, record + 11 * SPHERE_BINS, sizeof(g.cosine));
        memcpy(g.fill, record + 12 * SPHERE_BINS, sizeof(g.fill));
        float log_moment[SPHERE_BINS], radiance[SPHERE_BINS];
        odis_network_run(network, &g, log_moment, radiance);
        for (int b = 0; b < SPHERE_BINS; b++) {
            assert_near(log_moment[b], record[INPUTS * SPHERE_BINS + b], 1e-4);
            float compressed = fminf(fmaxf(record[(INPUTS + 1) * SPHERE_BINS + b], 0), 4);
            assert_near(range_compress(radiance[b]), compressed, 1e-4);
        }
        records++;
    }
    assert_true(records > 0);
    fclose(file);
    odis_network_destroy(&network);
    odis_weights_destroy(&weights);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_c_equals_pytorch)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
