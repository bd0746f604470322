/* SPDX-License-Identifier: Apache-2.0 */
/* The ODIS network: a U-Net of masked convolutions over the sphere's bins. Layer names are those of
 * train/model.py. */

#include "guide/odis/network.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "denoise/nn/embed.h"
#include "denoise/nn/nn.h"

extern const unsigned char odis_weights[];
size_t odis_weights_size(void);
NN_EMBED(odis_weights, ODIS_WEIGHTS_FILE)

enum layer { STEM, ENC0, ENC1A, ENC1B, ENC2A, ENC2B, UP1, DEC1, UP0, DEC0, HEAD, LAYER_COUNT };

#define FEATURES   (GATHER_PLANES + 3) /* a bin: the gathered planes, mask, cosine, fill */
#define FILL_SCALE 0.25f /* brings the fill's natural logarithm to the size of the other inputs */

static const struct {
    const char *name;
    int kernel, in, out;
} layers[LAYER_COUNT] = {
    [STEM] = {"stem", 1, 4 * FEATURES, 16}, /* 2x2 bins at once: 32x32 -> 16x16 */
    [ENC0] = {"enc0", 3, 16, 16},           /* 16x16 */
    [ENC1A] = {"enc1a", 3, 16, 32},         /* 8x8 */
    [ENC1B] = {"enc1b", 3, 32, 32},
    [ENC2A] = {"enc2a", 3, 32, 32}, /* 4x4 */
    [ENC2B] = {"enc2b", 3, 32, 32},
    [UP1] = {"up1", 1, 32, 32},
    [DEC1] = {"dec1", 3, 32, 32}, /* 8x8 */
    [UP0] = {"up0", 1, 32, 16},
    [DEC0] = {"dec0", 3, 16, 16}, /* 16x16 */
    [HEAD] = {"head", 1, 16, 8},  /* 2 values for each of 2x2 bins */
};

struct odis_weights {
    bool mean_maps; /* trained on mean radiance, the paper's way: output 0 is meaningless */
    struct nn_conv convs[LAYER_COUNT];
};

/* Two buffers a level, so that a convolution never writes what it reads. */
enum buffer { INPUT, FULL_A, FULL_B, HALF_A, HALF_B, QUARTER_A, QUARTER_B, BUFFER_COUNT };

static const struct {
    int size, channels;
} buffers[BUFFER_COUNT] = {
    [INPUT] = {16, 64}, [FULL_A] = {16, 16},   [FULL_B] = {16, 16},   [HALF_A] = {8, 32},
    [HALF_B] = {8, 32}, [QUARTER_A] = {4, 32}, [QUARTER_B] = {4, 32},
};

struct odis_network {
    const struct odis_weights *weights;
    const struct nn_kernels *kernels;
    struct nn_tensor tensors[BUFFER_COUNT];
    struct nn_tensor pooled; /* enc0's channels at half size */
    void *storage;
};

/* "map": "mean" in the text that the training left with the weights. */
static bool wants_mean_maps(const char *info) {
    json_t *object = json_loads(info, 0, NULL);
    const char *map = json_string_value(json_object_get(object, "map"));
    bool mean = map && !strcmp(map, "mean");
    json_decref(object);
    return mean;
}

int odis_weights_load(const char *path, struct odis_weights **out, struct fewray_error *error) {
    *out = NULL;
    struct nn_weights *file = NULL;
    int status = path ? nn_weights_read(path, &file, error)
                      : nn_weights_parse(odis_weights, odis_weights_size(),
                                         "built-in guide weights", &file, error);
    if (status)
        return status;
    struct odis_weights *weights = calloc(1, sizeof(*weights));
    if (!weights)
        status =
            fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for the guide's weights");
    else
        weights->mean_maps = wants_mean_maps(file->info);
    for (int i = 0; i < LAYER_COUNT && !status; i++)
        status = nn_conv_pack(&weights->convs[i], file, layers[i].name, layers[i].kernel,
                              layers[i].in, layers[i].out, error);
    nn_weights_destroy(&file);
    if (status)
        odis_weights_destroy(&weights);
    *out = weights;
    return status;
}

void odis_weights_destroy(struct odis_weights **weights) {
    if (!*weights)
        return;
    for (int i = 0; i < LAYER_COUNT; i++)
        nn_conv_clear(&(*weights)->convs[i]);
    free(*weights);
    *weights = NULL;
}

struct odis_network *odis_network_create(const struct odis_weights *weights) {
    struct odis_network *n = calloc(1, sizeof(*n));
    if (!n)
        return NULL;
    size_t bytes = nn_tensor_bytes(8, 8, 16);
    for (int i = 0; i < BUFFER_COUNT; i++)
        bytes += nn_tensor_bytes(buffers[i].size, buffers[i].size, buffers[i].channels);
    n->storage = aligned_alloc(64, bytes);
    if (!n->storage) {
        free(n);
        return NULL;
    }
    memset(n->storage, 0, bytes);
    char *at = n->storage;
    for (int i = 0; i < BUFFER_COUNT; i++) {
        n->tensors[i] = (struct nn_tensor){buffers[i].size, buffers[i].size, buffers[i].channels,
                                           (float *)(void *)at};
        at += nn_tensor_bytes(buffers[i].size, buffers[i].size, buffers[i].channels);
    }
    n->pooled = (struct nn_tensor){8, 8, 16, (float *)(void *)at};
    n->weights = weights;
    n->kernels = nn_kernels_get(NN_ISA_AUTO);
    return n;
}

void odis_network_destroy(struct odis_network **network) {
    if (!*network)
        return;
    free((*network)->storage);
    free(*network);
    *network = NULL;
}

/* Space to depth: the 2x2 bins of a cell side by side. The stem is a masked convolution (Liu et al.
 * 2018): what it takes from the filled bins is scaled up by the share of bins that are empty. */
static void fill_input(const struct gathered *in, const struct nn_tensor *input) {
    for (int y = 0; y < 16; y++)
        for (int x = 0; x < 16; x++) {
            float *cell = nn_at(input, y, x), filled = 0;
            for (int k = 0; k < 4; k++)
                filled += in->mask[(2 * y + k / 2) * SPHERE_COLUMNS + 2 * x + k % 2];
            float gain = filled > 0 ? 4 / filled : 0;
            for (int k = 0; k < 4; k++) {
                int b = (2 * y + k / 2) * SPHERE_COLUMNS + 2 * x + k % 2;
                float *feature = cell + k * FEATURES;
                for (int p = 0; p < GATHER_PLANES; p++)
                    feature[p] = in->planes[p][b] * gain;
                feature[GATHER_PLANES] = in->mask[b];
                feature[GATHER_PLANES + 1] = in->cosine[b];
                feature[GATHER_PLANES + 2] = in->fill[b] * FILL_SCALE;
            }
        }
}

static void run(struct odis_network *n, enum layer layer, const struct nn_tensor *in,
                const struct nn_tensor *out, enum nn_activation activation) {
    if (layers[layer].kernel == 3)
        nn_fill_border(in, NN_BORDER_WRAP_X);
    n->kernels->conv(&n->weights->convs[layer], in, out, activation, 0, out->height);
}

static void split_output(const struct gathered *in, const struct nn_tensor *head, bool mean_maps,
                         float wanted[SPHERE_BINS], float radiance[SPHERE_BINS]) {
    for (int b = 0; b < SPHERE_BINS; b++) {
        int row = b / SPHERE_COLUMNS, column = b % SPHERE_COLUMNS;
        const float *o = nn_at(head, row / 2, column / 2) + row % 2 * 2 + column % 2;
        wanted[b] = radiance[b] = 0;
        if (!(in->cosine[b] > 0))
            continue;
        radiance[b] = range_expand(fminf(fmaxf(o[4], 0), 4));
        wanted[b] = mean_maps ? radiance[b] : expf(in->fill[b] + o[0]);
    }
}

void odis_network_run(struct odis_network *n, const struct gathered *in, float wanted[SPHERE_BINS],
                      float radiance[SPHERE_BINS]) {
    struct nn_tensor *t = n->tensors;
    fill_input(in, &t[INPUT]);
    run(n, STEM, &t[INPUT], &t[FULL_A], NN_LEAKY_RELU);
    run(n, ENC0, &t[FULL_A], &t[FULL_B], NN_LEAKY_RELU);
    n->kernels->average_pool(&t[FULL_B], &n->pooled, 0, 8);
    run(n, ENC1A, &n->pooled, &t[HALF_A], NN_LEAKY_RELU);
    run(n, ENC1B, &t[HALF_A], &t[HALF_B], NN_LEAKY_RELU);
    n->kernels->average_pool(&t[HALF_B], &t[QUARTER_A], 0, 4);
    run(n, ENC2A, &t[QUARTER_A], &t[QUARTER_B], NN_LEAKY_RELU);
    run(n, ENC2B, &t[QUARTER_B], &t[QUARTER_A], NN_LEAKY_RELU);
    run(n, UP1, &t[QUARTER_A], &t[QUARTER_B], NN_LINEAR);
    n->kernels->upsample_add(&t[QUARTER_B], &t[HALF_B], 0, 8);
    run(n, DEC1, &t[HALF_B], &t[HALF_A], NN_LEAKY_RELU);
    /* up0 has 16 channels: it shares the pooled buffer, whose content is spent. */
    run(n, UP0, &t[HALF_A], &n->pooled, NN_LINEAR);
    n->kernels->upsample_add(&n->pooled, &t[FULL_B], 0, 16);
    run(n, DEC0, &t[FULL_B], &t[FULL_A], NN_LEAKY_RELU);
    run(n, HEAD, &t[FULL_A], &t[FULL_B], NN_LINEAR);
    split_output(in, &t[FULL_B], n->weights->mean_maps, wanted, radiance);
}
