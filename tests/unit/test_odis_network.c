/* SPDX-License-Identifier: Apache-2.0 */
/* The guide's network in C against PyTorch's outputs for stored inputs (guide/train/export.py
 * --reference). */

#include "tests/unit/check.h"

#include <stdio.h>
#include <string.h>

#include "guide/odis/network.h"

#define INPUTS (GATHER_PLANES + 3)

static void read_whole(FILE *file, void *data, size_t bytes) {
    assert_int_equal(fread(data, 1, bytes, file), bytes);
}

static void skip_layer(FILE *file) {
    char name[16];
    int32_t shape[3];
    read_whole(file, name, sizeof(name));
    read_whole(file, shape, sizeof(shape));
    assert_int_equal(fseek(file, (long)shape[0] * shape[1] * shape[2] * 4, SEEK_CUR), 0);
}

static void read_input(FILE *file, struct gathered *g) {
    static _Float16 input[INPUTS][SPHERE_BINS];
    read_whole(file, input, sizeof(input));
    for (int b = 0; b < SPHERE_BINS; b++) {
        for (int p = 0; p < GATHER_PLANES; p++)
            g->planes[p][b] = (float)input[p][b];
        g->mask[b] = (float)input[GATHER_PLANES][b];
        g->cosine[b] = (float)input[GATHER_PLANES + 1][b];
        g->fill[b] = (float)input[GATHER_PLANES + 2][b];
    }
}

static void test_c_equals_pytorch(void **state) {
    (void)state;
    FILE *file = fopen(TEST_DATA "/odis_reference.bin", "rb");
    assert_non_null(file);
    struct odis_weights *weights = NULL;
    struct fewray_error error;
    assert_int_equal(odis_weights_load(NULL, &weights, &error), 0);
    struct odis_network *network = odis_network_create(weights);
    assert_non_null(network);
    char magic[8];
    uint32_t head[3]; /* version, maps, layers */
    read_whole(file, magic, sizeof(magic));
    assert_memory_equal(magic, "ODISREFS", 8);
    read_whole(file, head, sizeof(head));
    assert_true(head[1] > 0);
    for (uint32_t i = 0; i < head[1]; i++) {
        static struct gathered g;
        float wanted[SPHERE_BINS], radiance[SPHERE_BINS], expected[2][SPHERE_BINS];
        read_input(file, &g);
        for (uint32_t layer = 0; layer < head[2]; layer++)
            skip_layer(file);
        read_whole(file, expected, sizeof(expected));
        odis_network_run(network, &g, wanted, radiance);
        for (int b = 0; b < SPHERE_BINS; b++) {
            if (!(g.cosine[b] > 0)) {
                assert_true(wanted[b] == 0 && radiance[b] == 0);
                continue;
            }
            assert_near(logf(wanted[b]), expected[0][b], 1e-4);
            assert_near(range_compress(radiance[b]), fminf(fmaxf(expected[1][b], 0), 4), 1e-4);
        }
    }
    fclose(file);
    odis_network_destroy(&network);
    odis_weights_destroy(&weights);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_c_equals_pytorch)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
