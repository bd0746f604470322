/* SPDX-License-Identifier: Apache-2.0 */
/* The ODIS network: a U-Net of masked convolutions over the sphere's bins. Layer names are those of
 * train/model.py. */

#include "guide/odis/network.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "denoise/nn/embed.h"
#include "denoise/nn/nn.h"
#include "guide/odis/float4.h"

extern const unsigned char odis_weights[], odis_paper_weights[];
size_t odis_weights_size(void);
size_t odis_paper_weights_size(void);
NN_EMBED(odis_weights, ODIS_WEIGHTS_FILE)
NN_EMBED(odis_paper_weights, ODIS_PAPER_WEIGHTS_FILE)

enum layer { STEM, ENC1, ENC2A, ENC2B, UP1, DEC1, UP0, DEC0, HEAD, MIX, LAYER_COUNT };

#define FEATURES       (GATHER_PLANES + 3) /* a bin: the gathered planes, mask, cosine, fill */
#define CHANNELS       16      /* of a bin in the stem's input: the features and a zero */
#define FILL_SCALE     0.25f   /* brings the natural logarithm to the size of the others */
#define FRACTION_LEAST 0.05f   /* of samples from the BSDF: keeps their weights bounded */
#define RANGE_MU       5000.0f /* range_expand()'s */
#define MEAN_LEAST     1e-3f   /* of mean maps: MEAN_LEAST of train/losses.py */

static const struct {
    const char *name;
    int kernel, in, out;
    int size; /* cells a side */
    enum nn_activation activation;
} layers[LAYER_COUNT] = {
    [STEM] = {"stem", 1, 4 * FEATURES, 16, 16, NN_LEAKY_RELU}, /* 2x2 bins at once */
    [ENC1] = {"enc1", 3, 16, 32, 8, NN_LEAKY_RELU},
    [ENC2A] = {"enc2a", 3, 32, 48, 4, NN_LEAKY_RELU},
    [ENC2B] = {"enc2b", 3, 48, 48, 4, NN_LEAKY_RELU},
    [UP1] = {"up1", 1, 48, 32, 4, NN_LINEAR},
    [DEC1] = {"dec1", 3, 32, 32, 8, NN_LEAKY_RELU},
    [UP0] = {"up0", 1, 32, 16, 8, NN_LINEAR},
    [DEC0] = {"dec0", 3, 16, 16, 16, NN_LEAKY_RELU},
    [HEAD] = {"head", 1, 16, 8, 16, NN_LINEAR}, /* 2 values for each of 2x2 bins */
    [MIX] = {"mix", 1, 48, 1, 1, NN_LINEAR},
};

/* The planes' names in the weights' info, and how many each has. */
static const struct {
    const char *name;
    enum gather_plane first;
    int count;
} plane_names[] = {
    {"radiance", GATHER_RADIANCE, 1}, {"pooled", GATHER_POOLED_MOMENT, 1},
    {"moment", GATHER_MOMENT, 1},     {"count", GATHER_COUNT, 1},
    {"depth", GATHER_DEPTH, 1},       {"normal", GATHER_NORMAL, 3},
    {"distance", GATHER_DISTANCE, 1}, {"second_normal", GATHER_SECOND_NORMAL, 3},
};

struct odis_weights {
    bool mean_maps; /* trained on mean radiance, the paper's way: output 0 is meaningless */
    float fraction; /* of the BSDF; 0: the network's own */
    float keep[GATHER_PLANES]; /* 0: the network was trained without this plane; else 1 */
    struct nn_conv convs[LAYER_COUNT];
};

/* Tensors that aren't a layer's output. */
enum between { INPUT, STEM_POOLED, ENC1_POOLED, BOTTOM_HALVED, BOTTOM_MEAN, BETWEEN_COUNT };

static const struct {
    int size, channels;
} between[BETWEEN_COUNT] = {
    [INPUT] = {16, 4 * CHANNELS}, [STEM_POOLED] = {8, 16}, [ENC1_POOLED] = {4, 32},
    [BOTTOM_HALVED] = {2, 48},    [BOTTOM_MEAN] = {1, 48},
};

struct odis_network {
    const struct odis_weights *weights;
    const struct nn_kernels *kernels;
    struct nn_tensor between[BETWEEN_COUNT];
    struct nn_tensor outputs[LAYER_COUNT];
    void *storage;
};

/* What the training says of its weights, in the file's info text: "map": "mean", the paper's aim;
 * "bsdf_fraction": a number, where the network didn't learn its own; "drop": names of planes. False
 * where it isn't JSON. */
static bool read_info(const char *info, struct odis_weights *weights) {
    json_t *object = json_loads(info, 0, NULL), *name;
    if (!object)
        return false;
    const char *map = json_string_value(json_object_get(object, "map"));
    weights->mean_maps = map && !strcmp(map, "mean");
    float fraction = (float)json_number_value(json_object_get(object, "bsdf_fraction"));
    weights->fraction = fraction > 0 && fraction <= 1 ? fraction : 0;
    for (int p = 0; p < GATHER_PLANES; p++)
        weights->keep[p] = 1;
    size_t i;
    json_array_foreach(json_object_get(object, "drop"), i, name) {
        for (size_t k = 0; k < sizeof(plane_names) / sizeof(plane_names[0]); k++)
            if (json_is_string(name) && !strcmp(json_string_value(name), plane_names[k].name))
                for (int p = 0; p < plane_names[k].count; p++)
                    weights->keep[(int)plane_names[k].first + p] = 0;
    }
    json_decref(object);
    return true;
}

/* Gives each bin CHANNELS instead of FEATURES input channels, so that fill_input() moves whole
 * vectors; the channel between has zero weights. */
static void spread_stem(struct nn_conv *stem) {
    const size_t row = NN_LANES * sizeof(float);
    for (int k = 3; k >= 0; k--)
        for (int f = FEATURES - 1; f >= 0; f--)
            memcpy(stem->weights + (k * CHANNELS + f) * NN_LANES,
                   stem->weights + (k * FEATURES + f) * NN_LANES, row);
    for (int k = 0; k < 4; k++)
        memset(stem->weights + (k * CHANNELS + FEATURES) * NN_LANES, 0, row);
    stem->in_used = 4 * CHANNELS;
}

/* Takes the file over. */
static int pack_weights(const char *path, struct nn_weights *file, struct odis_weights **out,
                        struct fewray_error *error) {
    int status = FEWRAY_OK;
    struct odis_weights *weights = calloc(1, sizeof(*weights));
    if (!weights)
        status =
            fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for the guide's weights");
    else if (!read_info(file->info, weights))
        status = fewray_fail(error, FEWRAY_ERROR_FORMAT, file->name, 0,
                             "weights file is damaged (its info isn't JSON); export or download it "
                             "again");
    for (int i = 0; i < LAYER_COUNT && !status; i++)
        status = nn_conv_pack(&weights->convs[i], file, layers[i].name, layers[i].kernel,
                              layers[i].in, layers[i].out, error);
    nn_weights_destroy(&file);
    if (status)
        odis_weights_destroy(&weights);
    else
        spread_stem(&weights->convs[STEM]);
    *out = weights;
    return status;
}

int odis_weights_load(const char *path, struct odis_weights **out, struct fewray_error *error) {
    *out = NULL;
    struct nn_weights *file = NULL;
    int status = path ? nn_weights_read(path, &file, error)
                      : nn_weights_parse(odis_weights, odis_weights_size(),
                                         "built-in guide weights", &file, error);
    return status ? status : pack_weights(path, file, out, error);
}

int odis_weights_load_paper(struct odis_weights **out, struct fewray_error *error) {
    *out = NULL;
    struct nn_weights *file = NULL;
    int status = nn_weights_parse(odis_paper_weights, odis_paper_weights_size(),
                                  "built-in weights of the paper's guide", &file, error);
    return status ? status : pack_weights(NULL, file, out, error);
}

void odis_weights_destroy(struct odis_weights **weights) {
    if (!*weights)
        return;
    for (int i = 0; i < LAYER_COUNT; i++)
        nn_conv_clear(&(*weights)->convs[i]);
    free(*weights);
    *weights = NULL;
}

/* Sets a tensor's shape and its place in the storage, NULL while sizes are counted; returns the
 * bytes that it takes. */
static size_t place(struct nn_tensor *tensor, int size, int channels, void *storage, size_t at) {
    float *data = storage ? (float *)(void *)((char *)storage + at) : NULL;
    *tensor = (struct nn_tensor){size, size, channels, data};
    return nn_tensor_bytes(size, size, channels);
}

static size_t place_all(struct odis_network *n) {
    size_t bytes = 0;
    for (int i = 0; i < BETWEEN_COUNT; i++)
        bytes += place(&n->between[i], between[i].size, between[i].channels, n->storage, bytes);
    for (int i = 0; i < LAYER_COUNT; i++) {
        int channels = (layers[i].out + NN_LANES - 1) / NN_LANES * NN_LANES;
        bytes += place(&n->outputs[i], layers[i].size, channels, n->storage, bytes);
    }
    return bytes;
}

struct odis_network *odis_network_create(const struct odis_weights *weights) {
    struct odis_network *n = calloc(1, sizeof(*n));
    if (!n)
        return NULL;
    size_t bytes = place_all(n);
    n->storage = aligned_alloc(64, bytes);
    if (!n->storage) {
        free(n);
        return NULL;
    }
    memset(n->storage, 0, bytes);
    place_all(n);
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

const struct nn_tensor *odis_network_layer(const struct odis_network *n, const char *name) {
    for (int i = 0; i < LAYER_COUNT; i++)
        if (!strcmp(layers[i].name, name))
            return &n->outputs[i];
    return NULL;
}

/* Of a row of cells: 4 / filled bins, 0 where none is. */
static void cell_gains(const float *mask, float gain[SPHERE_COLUMNS / 2]) {
    static const float of_filled[5] = {0, 4, 2, 4.0f / 3, 1};
    const float *lower = mask + SPHERE_COLUMNS;
    for (int x = 0; x < SPHERE_COLUMNS / 2; x++)
        gain[x] = of_filled[(int)(mask[2 * x] + mask[2 * x + 1] + lower[2 * x] + lower[2 * x + 1])];
}

/* A row of bins of four planes to the same four channels of their cells; cells is the first one's.
 * gain may be NULL. */
static void fill_channels(const float *const planes[4], const float factors[4], const float *gain,
                          float *cells) {
    for (int c = 0; c < SPHERE_COLUMNS; c += 4) {
        float4 q[4];
        for (int i = 0; i < 4; i++)
            q[i] = load(planes[i] + c) * factors[i];
        transpose(q);
        for (int i = 0; i < 4; i++) {
            int cell = (c + i) / 2;
            store(cells + (cell * 4 + i % 2) * CHANNELS, gain ? q[i] * gain[cell] : q[i]);
        }
    }
}

/* Space to depth: the 2x2 bins of a cell side by side. The stem is a masked convolution (Liu et al.
 * 2018): what it takes from the filled bins is scaled up by the share of bins that are empty.
 * Planes lie 4096 bytes apart, where they compete for the same lines of a cache: at most four are
 * read at a time. */
static void fill_input(const struct gathered *in, const float keep[GATHER_PLANES],
                       const struct nn_tensor *input) {
    static const float zero[SPHERE_COLUMNS] = {0}, others[4] = {1, 1, FILL_SCALE, 0};
    for (int row = 0; row < SPHERE_ROWS; row++) {
        float gain[SPHERE_COLUMNS / 2];
        cell_gains(in->mask + row / 2 * 2 * SPHERE_COLUMNS, gain);
        const int b = row * SPHERE_COLUMNS;
        float *cells = nn_at(input, row / 2, 0) + row % 2 * 2 * CHANNELS;
        for (int p = 0; p < GATHER_PLANES; p += 4) {
            const float *const planes[4] = {in->planes[p] + b, in->planes[p + 1] + b,
                                            in->planes[p + 2] + b, in->planes[p + 3] + b};
            fill_channels(planes, keep + p, gain, cells + p);
        }
        const float *const planes[4] = {in->mask + b, in->cosine + b, in->fill + b, zero};
        fill_channels(planes, others, NULL, cells + GATHER_PLANES);
    }
}

static void run(struct odis_network *n, enum layer layer, const struct nn_tensor *in) {
    if (layers[layer].kernel == 3)
        nn_fill_border(in, NN_BORDER_WRAP_X);
    n->kernels->conv(&n->weights->convs[layer], in, &n->outputs[layer], layers[layer].activation, 0,
                     layers[layer].size);
}

static inline float4 clamp(float4 x, float low, float high) {
    const float4 zero = {0};
    x = pick(x > low, x, zero + low); /* not a number: low */
    return pick(x < high, x, zero + high);
}

/* e^x, x clamped to -80..80; relative error below 1e-7. e^x = 2^n e^r with |r| <= ln(2) / 2 (Cody
 * and Waite's reduction), e^r by its Taylor series to r^7. */
static inline float4 exponential(float4 x) {
    x = clamp(x, -80, 80);
    const float to_integer = 0x1.8p23f; /* adding it leaves the rounded integer in the low bits */
    float4 shifted = x * 0x1.715476p0f + to_integer, n = shifted - to_integer;
    float4 r = x - n * 0x1.62e4p-1f; /* ln 2 in two parts; products with the first are exact */
    r = r - n * 0x1.7f7d1cp-20f;
    float4 e = r * (1.0f / 5040) + (1.0f / 720);
    e = e * r + (1.0f / 120);
    e = e * r + (1.0f / 24);
    e = e * r + (1.0f / 6);
    e = e * r + 0.5f;
    e = e * r + 1;
    e = e * r + 1;
    return (float4)((int4)e + ((int4)shifted << 23));
}

/* The values of the head's channels first..first + 3, bin after bin. */
static void depth_to_space(const struct nn_tensor *head, int first, float bins[SPHERE_BINS]) {
    for (int y = 0; y < head->height; y++)
        for (int x = 0; x < head->width; x++) {
            const float *o = nn_at(head, y, x) + first;
            float *upper = bins + 2 * y * SPHERE_COLUMNS + 2 * x, *lower = upper + SPHERE_COLUMNS;
            memcpy(upper, o, 2 * sizeof(*o));
            memcpy(lower, o + 2, 2 * sizeof(*o));
        }
}

/* From the head's outputs to radiance; 0 below the horizon. */
static void split_output(const struct gathered *in, const struct nn_tensor *head, bool mean_maps,
                         float wanted[SPHERE_BINS], float radiance[SPHERE_BINS]) {
    depth_to_space(head, 0, wanted);
    depth_to_space(head, 4, radiance);
    const float log_mu = log1pf(RANGE_MU), inverse_mu = 1 / RANGE_MU;
    for (int b = 0; b < SPHERE_BINS; b += 4) {
        int4 above = load(in->cosine + b) > 0.0f;
        float4 mean = exponential(clamp(load(radiance + b), 0, 4) * log_mu);
        mean = pick(above, (mean - 1.0f) * inverse_mu, (float4){0});
        float4 moment =
            pick(above, exponential(load(in->fill + b) + load(wanted + b)), (float4){0});
        store(radiance + b, mean);
        float4 floored = pick(mean > MEAN_LEAST, mean, (float4){0} + MEAN_LEAST);
        store(wanted + b, mean_maps ? pick(above, floored, mean) : moment);
    }
}

void odis_network_run(struct odis_network *n, const struct gathered *in, float wanted[SPHERE_BINS],
                      float radiance[SPHERE_BINS], float *bsdf_fraction) {
    const struct odis_weights *weights = n->weights;
    const struct nn_kernels *kernels = n->kernels;
    const struct nn_tensor *t = n->between, *out = n->outputs;
    fill_input(in, weights->keep, &t[INPUT]);
    run(n, STEM, &t[INPUT]);
    kernels->average_pool(&out[STEM], &t[STEM_POOLED], 0, 8);
    run(n, ENC1, &t[STEM_POOLED]);
    kernels->average_pool(&out[ENC1], &t[ENC1_POOLED], 0, 4);
    run(n, ENC2A, &t[ENC1_POOLED]);
    run(n, ENC2B, &out[ENC2A]);
    run(n, UP1, &out[ENC2B]);
    kernels->upsample_add(&out[UP1], &out[ENC1], 0, 8);
    run(n, DEC1, &out[ENC1]);
    run(n, UP0, &out[DEC1]);
    kernels->upsample_add(&out[UP0], &out[STEM], 0, 16);
    run(n, DEC0, &out[STEM]);
    run(n, HEAD, &out[DEC0]);
    split_output(in, &out[HEAD], weights->mean_maps, wanted, radiance);

    kernels->average_pool(&out[ENC2B], &t[BOTTOM_HALVED], 0, 2);
    kernels->average_pool(&t[BOTTOM_HALVED], &t[BOTTOM_MEAN], 0, 1);
    run(n, MIX, &t[BOTTOM_MEAN]);
    float own = FRACTION_LEAST + (1 - FRACTION_LEAST) / (1 + expf(-*nn_at(&out[MIX], 0, 0)));
    *bsdf_fraction = weights->fraction > 0 ? weights->fraction : own;
}
