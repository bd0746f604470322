/* SPDX-License-Identifier: Apache-2.0 */
/* The kernel-predicting network as a list of named layers (the names of train/model.py), and how
 * each kind is run.
 *
 * Level l has 1 / 2^l of the picture's resolution. Kernels after Bako et al. 2017
 * (kernel-predicting convolutional networks) over a pyramid after Vogels et al. 2018 (denoising
 * with kernel prediction and asymmetric loss functions), with the blend between scales predicted in
 * the same softmax as the kernels. */

#include "denoise/kpn.h"

#include <stdlib.h>
#include <string.h>

#include "denoise/kpn_rows.h"

/* clang-format off */
static const struct {
    int level, channels; /* channels 0: an image of kernel_apply.h */
} buffers[BUFFER_COUNT] = {
    [FEATURES] = {1, 4 * KPN_FEATURES},
    [ENC0A] = {1, 32}, [ENC0] = {1, 32}, [POOL0] = {2, 32},
    [ENC1A] = {2, 48}, [ENC1] = {2, 48}, [POOL1] = {3, 48},
    [ENC2A] = {3, 64}, [ENC2] = {3, 64}, [POOL2] = {4, 64},
    [ENC3A] = {4, 64}, [ENC3] = {4, 64},
    [UP2] = {4, 64}, [DEC2A] = {3, 64}, [DEC2] = {3, 64},
    [UP1] = {3, 48}, [DEC1A] = {2, 48}, [DEC1] = {2, 48},
    [UP0] = {2, 32}, [DEC0A] = {1, 32}, [DEC0] = {1, 32},
    [LIGHT0] = {0, 0}, [LIGHT1] = {1, 0}, [LIGHT2] = {2, 0}, [LIGHT3] = {3, 0}, [LIGHT4] = {4, 0},
    [OUT1] = {1, 0}, [OUT2] = {2, 0}, [OUT3] = {3, 0}, [OUT4] = {4, 0},
};
/* clang-format on */

static const struct kpn_layer layers[] = {
    {OP_FEATURES, "features", 0, 0, 0, NONE, FEATURES, LIGHT0, NONE},
    {OP_CONV, "enc0a", 3, 64, 32, FEATURES, ENC0A, NONE, NONE},
    {OP_CONV, "enc0b", 3, 32, 32, ENC0A, ENC0, NONE, NONE},
    {OP_POOL, "pool0", 0, 0, 0, ENC0, POOL0, NONE, NONE},
    {OP_CONV, "enc1a", 3, 32, 48, POOL0, ENC1A, NONE, NONE},
    {OP_CONV, "enc1b", 3, 48, 48, ENC1A, ENC1, NONE, NONE},
    {OP_POOL, "pool1", 0, 0, 0, ENC1, POOL1, NONE, NONE},
    {OP_CONV, "enc2a", 3, 48, 64, POOL1, ENC2A, NONE, NONE},
    {OP_CONV, "enc2b", 3, 64, 64, ENC2A, ENC2, NONE, NONE},
    {OP_POOL, "pool2", 0, 0, 0, ENC2, POOL2, NONE, NONE},
    {OP_CONV, "enc3a", 3, 64, 64, POOL2, ENC3A, NONE, NONE},
    {OP_CONV, "enc3b", 3, 64, 64, ENC3A, ENC3, NONE, NONE},
    {OP_CONV, "up2", 1, 64, 64, ENC3, UP2, NONE, NONE},
    {OP_UPSAMPLE_ADD, "skip2", 0, 0, 0, UP2, ENC2, NONE, NONE},
    {OP_CONV, "dec2a", 3, 64, 64, ENC2, DEC2A, NONE, NONE},
    {OP_CONV, "dec2b", 3, 64, 64, DEC2A, DEC2, NONE, NONE},
    {OP_CONV, "up1", 1, 64, 48, DEC2, UP1, NONE, NONE},
    {OP_UPSAMPLE_ADD, "skip1", 0, 0, 0, UP1, ENC1, NONE, NONE},
    {OP_CONV, "dec1a", 3, 48, 48, ENC1, DEC1A, NONE, NONE},
    {OP_CONV, "dec1b", 3, 48, 48, DEC1A, DEC1, NONE, NONE},
    {OP_CONV, "up0", 1, 48, 32, DEC1, UP0, NONE, NONE},
    {OP_UPSAMPLE_ADD, "skip0", 0, 0, 0, UP0, ENC0, NONE, NONE},
    {OP_CONV, "dec0a", 3, 32, 32, ENC0, DEC0A, NONE, NONE},
    {OP_CONV, "dec0b", 3, 32, 32, DEC0A, DEC0, NONE, NONE},
    {OP_DOWN, "down0", 1, 32, 4, DEC0, LIGHT1, LIGHT0, NONE},
    {OP_DOWN, "down1", 1, 32, 1, DEC0, LIGHT2, LIGHT1, NONE},
    {OP_DOWN, "down2", 1, 48, 1, DEC1, LIGHT3, LIGHT2, NONE},
    {OP_DOWN, "down3", 1, 64, 1, DEC2, LIGHT4, LIGHT3, NONE},
    {OP_KERNEL, "kernel4", 1, 64, KPN_TAPS_FINE, ENC3, OUT4, LIGHT4, NONE},
    {OP_KERNEL, "kernel3", 1, 64, KPN_TAPS, DEC2, OUT3, LIGHT3, OUT4},
    {OP_KERNEL, "kernel2", 1, 48, KPN_TAPS, DEC1, OUT2, LIGHT2, OUT3},
    {OP_KERNEL, "kernel1", 1, 32, KPN_TAPS, DEC0, OUT1, LIGHT1, OUT2},
    {OP_KERNEL, "kernel0", 1, 32, 4 * KPN_TAPS, DEC0, NONE, LIGHT0, OUT1},
};
enum { LAYER_COUNT = sizeof layers / sizeof layers[0] };

struct kpn {
    const struct nn_kernels *kernels;
    struct nn_conv convs[LAYER_COUNT];
    /* Added to the coarse logits of levels 1 to 3: by level and place in a 2x2 block. */
    float parity[4][4][KPN_TAPS_COARSE];
};

/* --- weights */

int kpn_create(const struct nn_weights *weights, const struct nn_kernels *kernels, struct kpn **out,
               struct fewray_error *error) {
    *out = NULL;
    struct kpn *kpn = calloc(1, sizeof *kpn);
    if (!kpn)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the network");
    kpn->kernels = kernels;
    int status = FEWRAY_OK;
    for (int i = 0; i < LAYER_COUNT && status == FEWRAY_OK; i++)
        if (layers[i].kernel)
            status = nn_conv_pack(&kpn->convs[i], weights, layers[i].name, layers[i].kernel,
                                  layers[i].in, layers[i].out, error);
    static const char *const parity_names[4] = {NULL, "parity1", "parity2", "parity3"};
    for (int s = 1; s < 4 && status == FEWRAY_OK; s++) {
        const int shape[4] = {4, KPN_TAPS_COARSE, 1, 1};
        const struct nn_weight *parity = nn_weights_find(weights, parity_names[s], shape, error);
        if (parity)
            memcpy(kpn->parity[s], parity->data, sizeof kpn->parity[s]);
        else
            status = FEWRAY_ERROR_FORMAT;
    }
    if (status == FEWRAY_OK)
        *out = kpn;
    else
        kpn_destroy(&kpn);
    return status;
}

void kpn_destroy(struct kpn **kpn) {
    if (!*kpn)
        return;
    for (int i = 0; i < LAYER_COUNT; i++)
        if ((*kpn)->convs[i].weights)
            nn_conv_clear(&(*kpn)->convs[i]);
    free(*kpn);
    *kpn = NULL;
}

/* --- memory */

static size_t align64(size_t bytes) {
    return (bytes + 63) & ~(size_t)63;
}

static bool uses(const struct kpn_layer *layer, int b) {
    return (int)layer->input == b || (int)layer->output == b || (int)layer->light == b ||
           (int)layer->coarse == b;
}

/* Where each buffer lies; the result is the bytes of all. */
static size_t plan(int height, int width, size_t offsets[BUFFER_COUNT]) {
    struct nn_buffer list[BUFFER_COUNT] = {0};
    for (int b = 1; b < BUFFER_COUNT; b++) {
        int h = height >> buffers[b].level, w = width >> buffers[b].level;
        list[b].bytes =
            b >= FIRST_IMAGE ? kpn_image_bytes(h, w) : nn_tensor_bytes(h, w, buffers[b].channels);
        list[b].first = LAYER_COUNT;
        for (int i = 0; i < LAYER_COUNT; i++)
            if (uses(&layers[i], b)) {
                list[b].first = i < list[b].first ? i : list[b].first;
                list[b].last = i;
            }
    }
    size_t local[BUFFER_COUNT];
    offsets = offsets ? offsets : local;
    offsets[NONE] = 0;
    return nn_arena_plan(list + 1, BUFFER_COUNT - 1, offsets + 1);
}

size_t kpn_memory(int height, int width, int threads) {
    return align64(plan(height, width, NULL)) + (size_t)threads * kpn_scratch_bytes(width);
}

/* --- running */

static void lay_out(struct kpn_work *work) {
    const struct kpn_region *region = &work->job->region;
    size_t offsets[BUFFER_COUNT];
    size_t bytes = plan(region->height, region->width, offsets);
    char *memory = work->job->memory;
    work->scratch = memory + align64(bytes);
    for (int b = 1; b < BUFFER_COUNT; b++) {
        int h = region->height >> buffers[b].level, w = region->width >> buffers[b].level;
        float *data = (float *)(void *)(memory + offsets[b]);
        if (b >= FIRST_IMAGE)
            work->images[b] = (struct kpn_image){h, w, data};
        else
            work->tensors[b] = (struct nn_tensor){h, w, buffers[b].channels, data};
    }
}

/* Rows y0 <= y < y1 of the layer's own resolution. True but where OP_FEATURES met no light. */
static bool run_rows(struct kpn_work *work, const struct kpn_layer *layer,
                     const struct nn_conv *conv, int y0, int y1) {
    const struct nn_tensor *input = &work->tensors[layer->input],
                           *output = &work->tensors[layer->output];
    bool lit = layer->op != OP_FEATURES;
    if (layer->op == OP_CONV)
        work->kernels->conv(conv, input, output, NN_LEAKY_RELU, y0, y1);
    else if (layer->op == OP_POOL)
        work->kernels->average_pool(input, output, y0, y1);
    else if (layer->op == OP_UPSAMPLE_ADD)
        work->kernels->upsample_add(input, output, y0, y1);
    else
        for (int y = y0; y < y1; y++)
            if (layer->op == OP_FEATURES)
                lit |= kpn_features_row(work, y);
            else if (layer->op == OP_DOWN)
                kpn_down_row(work, layer, conv, y);
            else if (layer->output)
                kpn_kernel_row(work, layer, conv, y);
            else
                kpn_picture_rows(work, layer, conv, y);
    return lit;
}

/* False where the region turned out to hold no light. */
static bool run_layer(struct kpn_work *work, const struct kpn_layer *layer,
                      const struct nn_conv *conv) {
    if (layer->op == OP_CONV && layer->kernel == 3)
        nn_fill_border(&work->tensors[layer->input], NN_BORDER_ZERO);
    int level = layer->output ? buffers[layer->output].level : 1,
        rows = work->job->region.height >> level, chunk = 4;
    bool lit = false;
#pragma omp parallel for schedule(dynamic) num_threads(work->job->threads) reduction(| : lit)
    for (int y = 0; y < rows; y += chunk)
        lit |= run_rows(work, layer, conv, y, y + chunk < rows ? y + chunk : rows);
    if (layer->op == OP_FEATURES)
        kpn_fill_border(&work->images[layer->light]);
    else if (layer->output >= FIRST_IMAGE)
        kpn_fill_border(&work->images[layer->output]);
    return lit;
}

static void show(const struct kpn_work *work, const struct kpn_layer *layer) {
    const struct kpn_job *job = work->job;
    enum buffer b = layer->output;
    if (b == NONE || !job->trace)
        return;
    if (b >= FIRST_IMAGE) {
        const struct kpn_image *image = &work->images[b];
        job->trace(job->trace_user, layer->name, kpn_pixel(image, 0, 0), image->height,
                   image->width, 3, (size_t)(image->width + 2 * KPN_BORDER) * 4, 4);
    } else {
        const struct nn_tensor *t = &work->tensors[b];
        size_t stride = (size_t)t->channels;
        job->trace(job->trace_user, layer->name, nn_at(t, 0, 0), t->height, t->width, t->channels,
                   (size_t)(t->width + 2) * stride, stride);
    }
}

/* About in proportion to the time of a layer. */
static double cost(const struct kpn_layer *layer) {
    int level = layer->output ? buffers[layer->output].level : 1;
    double work =
        layer->kernel ? (double)layer->kernel * layer->kernel * layer->in * layer->out : 2000.0;
    return work / (double)(1 << (2 * level));
}

int kpn_run(const struct kpn *kpn, const struct kpn_job *job, bool *filtered,
            struct fewray_error *error) {
    struct kpn_work work = {.kernels = kpn->kernels, .job = job, .parity = kpn->parity};
    lay_out(&work);
    double total = 0, done = 0;
    for (int i = 0; i < LAYER_COUNT; i++)
        total += cost(&layers[i]);
    *filtered = true;
    for (int i = 0; i < LAYER_COUNT && *filtered; i++) {
        if (job->cancel && *job->cancel)
            return fewray_fail(error, FEWRAY_ERROR_CANCELLED, NULL, 0, "cancelled");
        *filtered = run_layer(&work, &layers[i], &kpn->convs[i]);
        show(&work, &layers[i]);
        done += cost(&layers[i]);
        if (job->progress)
            job->progress(job->progress_user, done / total);
    }
    for (int y = 0; y < job->region.height && !*filtered; y++)
        kpn_put_row(job, y, 0, job->region.width, NULL);
    return FEWRAY_OK;
}
