/* SPDX-License-Identifier: Apache-2.0 */
/* The guide's network in C against PyTorch's outputs for stored inputs (guide/train/export.py
 * --reference). */

#include "tests/unit/check.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "denoise/nn/nn.h"
#include "guide/odis/network.h"

#define INPUTS (GATHER_PLANES + 3)

static void read_whole(FILE *file, void *data, size_t bytes) {
    assert_int_equal(fread(data, 1, bytes, file), bytes);
}

/* A layer's stored output, (channels, height, width). */
struct reference {
    char name[17];
    int32_t channels, height, width;
    float *values;
};

static void read_layer(FILE *file, struct reference *layer) {
    memset(layer, 0, sizeof(*layer));
    read_whole(file, layer->name, 16);
    read_whole(file, &layer->channels, 3 * sizeof(int32_t));
    size_t count = (size_t)layer->channels * (size_t)layer->height * (size_t)layer->width;
    assert_true(count > 0 && count < 1 << 20);
    layer->values = malloc(count * sizeof(float));
    assert_non_null(layer->values);
    read_whole(file, layer->values, count * sizeof(float));
}

static const struct reference *find(const struct reference *layers, const char *name) {
    while (strcmp(layers->name, name))
        layers++;
    return layers;
}

static float value_at(const struct reference *layer, int channel, int y, int x) {
    return layer->values[(channel * layer->height + y) * layer->width + x];
}

/* Compares what a layer left; added: the layer whose upsampled output was added to it, or NULL. */
static void compare_layer(const struct odis_network *network, const struct reference *layer,
                          const struct reference *added) {
    const struct nn_tensor *t = odis_network_layer(network, layer->name);
    assert_non_null(t);
    assert_int_equal(t->height, layer->height);
    assert_int_equal(t->width, layer->width);
    for (int y = 0; y < layer->height; y++)
        for (int x = 0; x < layer->width; x++)
            for (int c = 0; c < layer->channels; c++) {
                float expected = value_at(layer, c, y, x);
                if (added)
                    expected += value_at(added, c, y / 2, x / 2);
                assert_near(nn_at(t, y, x)[c], expected, 1e-4);
            }
}

static void read_input(FILE *file, struct gathered *g) {
    static uint16_t input[INPUTS][SPHERE_BINS];
    read_whole(file, input, sizeof(input));
    for (int b = 0; b < SPHERE_BINS; b++) {
        for (int p = 0; p < GATHER_PLANES; p++)
            g->planes[p][b] = fewray_half_value(input[p][b]);
        g->mask[b] = fewray_half_value(input[GATHER_PLANES][b]);
        g->cosine[b] = fewray_half_value(input[GATHER_PLANES + 1][b]);
        g->fill[b] = fewray_half_value(input[GATHER_PLANES + 2][b]);
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
    assert_int_equal(head[0], 2);
    assert_true(head[1] > 0);
    assert_true(head[2] > 0 && head[2] <= 16);
    for (uint32_t i = 0; i < head[1]; i++) {
        static struct gathered g;
        struct reference layers[16];
        float wanted[SPHERE_BINS], radiance[SPHERE_BINS], expected[2][SPHERE_BINS];
        float fraction, expected_fraction;
        read_input(file, &g);
        for (uint32_t layer = 0; layer < head[2]; layer++)
            read_layer(file, &layers[layer]);
        read_whole(file, expected, sizeof(expected));
        read_whole(file, &expected_fraction, sizeof(expected_fraction));
        odis_network_run(network, &g, wanted, radiance, &fraction);
        for (uint32_t layer = 0; layer < head[2]; layer++) {
            const char *name = layers[layer].name;
            const char *skip = !strcmp(name, "stem") ? "up0" : !strcmp(name, "enc1") ? "up1" : NULL;
            compare_layer(network, &layers[layer], skip ? find(layers, skip) : NULL);
        }
        assert_near(fraction, expected_fraction, 1e-5);
        for (int b = 0; b < SPHERE_BINS; b++) {
            if (!(g.cosine[b] > 0)) {
                assert_true(wanted[b] == 0 && radiance[b] == 0);
                continue;
            }
            assert_near(logf(wanted[b]), expected[0][b], 1e-4);
            assert_near(range_compress(radiance[b]), fminf(fmaxf(expected[1][b], 0), 4), 1e-4);
        }
        for (uint32_t layer = 0; layer < head[2]; layer++)
            free(layers[layer].values);
    }
    fclose(file);
    odis_network_destroy(&network);
    odis_weights_destroy(&weights);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_c_equals_pytorch)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
