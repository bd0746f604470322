/* SPDX-License-Identifier: Apache-2.0 */
/* The kernel-predicting network as a list of named layers (the names of train/model.py), and its
 * weights.
 *
 * Level l has 1 / 2^l of the picture's resolution. Kernels after Bako et al. 2017
 * (kernel-predicting convolutional networks) over a pyramid after Vogels et al. 2018 (denoising
 * with kernel prediction and asymmetric loss functions), with the blend between scales predicted in
 * the same softmax as the kernels, and with the affinity of keys (nn_affinity) that a pixel's own
 * features and the trunk make at full resolution. */

#include "denoise/kpn_network.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* clang-format off */
/* Channels of levels 1 to 4, which the weights file decides: places in kpn->widths. */
enum { A = -1, B = -2, C = -3, D = -4 };

static const struct {
    int level, channels; /* channels 0: an image of kernel_apply.h */
} buffers[BUFFER_COUNT] = {
    [FEATURES] = {1, 4 * KPN_FEATURES},
    [ENC0A] = {1, A}, [ENC0] = {1, A}, [POOL0] = {2, A},
    [ENC1A] = {2, B}, [ENC1] = {2, B}, [POOL1] = {3, B},
    [ENC2A] = {3, C}, [ENC2] = {3, C}, [POOL2] = {4, C},
    [ENC3A] = {4, D}, [ENC3] = {4, D},
    [UP2] = {4, C}, [DEC2A] = {3, C}, [DEC2] = {3, C},
    [UP1] = {3, B}, [DEC1A] = {2, B}, [DEC1] = {2, B},
    [UP0] = {2, A}, [DEC0A] = {1, A}, [DEC0] = {1, A},
    [LIGHT0] = {0, 0}, [LIGHT1] = {1, 0}, [LIGHT2] = {2, 0}, [LIGHT3] = {3, 0}, [LIGHT4] = {4, 0},
    [RAW_KEY] = {1, 4 * NN_KEY},
    [KEY0] = {0, 0}, [KEY1] = {1, 0}, [KEY2] = {2, 0}, [KEY3] = {3, 0}, [KEY4] = {4, 0},
    [OUT1] = {1, 0}, [OUT2] = {2, 0}, [OUT3] = {3, 0}, [OUT4] = {4, 0},
};
/* clang-format on */

static const struct kpn_layer layers[] = {
    {OP_FEATURES, "features", 0, 0, 0, NONE, FEATURES, LIGHT0, NONE},
    {OP_RAW_KEY, "key_raw", 1, 4 * KPN_FEATURES, 4 * NN_KEY, FEATURES, RAW_KEY, NONE, NONE},
    {OP_CONV, "enc0a", 3, 4 * KPN_FEATURES, A, FEATURES, ENC0A, NONE, NONE},
    {OP_CONV, "enc0b", 3, A, A, ENC0A, ENC0, NONE, NONE},
    {OP_POOL, "pool0", 0, 0, 0, ENC0, POOL0, NONE, NONE},
    {OP_CONV, "enc1a", 3, A, B, POOL0, ENC1A, NONE, NONE},
    {OP_CONV, "enc1b", 3, B, B, ENC1A, ENC1, NONE, NONE},
    {OP_POOL, "pool1", 0, 0, 0, ENC1, POOL1, NONE, NONE},
    {OP_CONV, "enc2a", 3, B, C, POOL1, ENC2A, NONE, NONE},
    {OP_CONV, "enc2b", 3, C, C, ENC2A, ENC2, NONE, NONE},
    {OP_POOL, "pool2", 0, 0, 0, ENC2, POOL2, NONE, NONE},
    {OP_CONV, "enc3a", 3, C, D, POOL2, ENC3A, NONE, NONE},
    {OP_CONV, "enc3b", 3, D, D, ENC3A, ENC3, NONE, NONE},
    {OP_CONV, "up2", 1, D, C, ENC3, UP2, NONE, NONE},
    {OP_UPSAMPLE_ADD, "skip2", 0, 0, 0, UP2, ENC2, NONE, NONE},
    {OP_CONV, "dec2a", 3, C, C, ENC2, DEC2A, NONE, NONE},
    {OP_CONV, "dec2b", 3, C, C, DEC2A, DEC2, NONE, NONE},
    {OP_CONV, "up1", 1, C, B, DEC2, UP1, NONE, NONE},
    {OP_UPSAMPLE_ADD, "skip1", 0, 0, 0, UP1, ENC1, NONE, NONE},
    {OP_CONV, "dec1a", 3, B, B, ENC1, DEC1A, NONE, NONE},
    {OP_CONV, "dec1b", 3, B, B, DEC1A, DEC1, NONE, NONE},
    {OP_CONV, "up0", 1, B, A, DEC1, UP0, NONE, NONE},
    {OP_UPSAMPLE_ADD, "skip0", 0, 0, 0, UP0, ENC0, NONE, NONE},
    {OP_CONV, "dec0a", 3, A, A, ENC0, DEC0A, NONE, NONE},
    {OP_CONV, "dec0b", 3, A, A, DEC0A, DEC0, NONE, NONE},
    {OP_KEY, "key", 1, A, 4 * NN_KEY, DEC0, KEY0, RAW_KEY, NONE},
    {OP_DOWN, "down0", 1, A, 4, DEC0, LIGHT1, LIGHT0, NONE},
    {OP_DOWN, "down1", 1, A, 1, DEC0, LIGHT2, LIGHT1, NONE},
    {OP_DOWN, "down2", 1, B, 1, DEC1, LIGHT3, LIGHT2, NONE},
    {OP_DOWN, "down3", 1, C, 1, DEC2, LIGHT4, LIGHT3, NONE},
    {OP_KERNEL, "kernel4", 1, D, KPN_TAPS_FINE, ENC3, OUT4, LIGHT4, NONE},
    {OP_KERNEL, "kernel3", 1, C, KPN_TAPS, DEC2, OUT3, LIGHT3, OUT4},
    {OP_KERNEL, "kernel2", 1, B, KPN_TAPS, DEC1, OUT2, LIGHT2, OUT3},
    {OP_KERNEL, "kernel1", 1, A, KPN_TAPS, DEC0, OUT1, LIGHT1, OUT2},
    {OP_KERNEL, "kernel0", 1, A, 4 * KPN_TAPS, DEC0, NONE, LIGHT0, OUT1},
};
_Static_assert(sizeof layers / sizeof layers[0] == KPN_LAYER_COUNT, "");

/* --- weights */

static int channels(const struct kpn *kpn, int written) {
    return written < 0 ? kpn->widths[-1 - written] : written;
}

/* Each level's channels are those that its encoder ends with; nn_conv_pack() then compares all
 * layers' shapes with the table's. */
static int find_widths(struct kpn *kpn, const struct nn_weights *weights,
                       struct fewray_error *error) {
    static const char *const ends[KPN_WIDTHS] = {"enc0b.bias", "enc1b.bias", "enc2b.bias",
                                                 "enc3b.bias"};
    for (int w = 0; w < KPN_WIDTHS; w++) {
        for (int i = 0; i < weights->count; i++)
            if (!strcmp(weights->tensors[i].name, ends[w]))
                kpn->widths[w] = weights->tensors[i].shape[0];
        if (kpn->widths[w] < 1 || kpn->widths[w] > KPN_MAX_WIDTH)
            return fewray_fail(error, FEWRAY_ERROR_FORMAT, weights->name, 0,
                               "weights of another network: %s has %d channels, not 1 to %d",
                               ends[w], kpn->widths[w], KPN_MAX_WIDTH);
    }
    for (int b = 0; b < BUFFER_COUNT; b++) {
        kpn->levels[b] = buffers[b].level;
        kpn->channels[b] =
            (channels(kpn, buffers[b].channels) + NN_LANES - 1) / NN_LANES * NN_LANES;
    }
    for (int i = 0; i < KPN_LAYER_COUNT; i++) {
        kpn->layers[i] = layers[i];
        kpn->layers[i].in = channels(kpn, layers[i].in);
        kpn->layers[i].out = channels(kpn, layers[i].out);
    }
    return FEWRAY_OK;
}

/* The file has them as logarithms, so that no training makes one negative. */
static int find_scales(struct kpn *kpn, const struct nn_weights *weights,
                       struct fewray_error *error) {
    static const char *const names[KPN_LEVELS] = {"scale0", "scale1", "scale2", "scale3", "scale4"};
    const int shape[4] = {2, NN_KEY - 1, 1, 1};
    for (int s = 0; s < KPN_LEVELS; s++) {
        const struct nn_weight *scale = nn_weights_find(weights, names[s], shape, error);
        if (!scale)
            return FEWRAY_ERROR_FORMAT;
        for (int i = 0; i < 2; i++)
            for (int c = 0; c < NN_KEY - 1; c++) {
                kpn->scale[s][i][c] = expf(scale->data[i * (NN_KEY - 1) + c]);
                if (!isfinite(kpn->scale[s][i][c]))
                    return fewray_fail(error, FEWRAY_ERROR_FORMAT, weights->name, 0,
                                       "weights file is damaged (%s is beyond any number); export "
                                       "or download it again",
                                       names[s]);
            }
    }
    return FEWRAY_OK;
}

int kpn_create(const struct nn_weights *weights, const struct nn_kernels *kernels, struct kpn **out,
               struct fewray_error *error) {
    *out = NULL;
    struct kpn *kpn = calloc(1, sizeof *kpn);
    if (!kpn)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the network");
    kpn->kernels = kernels;
    int status = find_widths(kpn, weights, error);
    for (int i = 0; i < KPN_LAYER_COUNT && status == FEWRAY_OK; i++) {
        const struct kpn_layer *layer = &kpn->layers[i];
        if (layer->kernel)
            status = nn_conv_pack(&kpn->convs[i], weights, layer->name, layer->kernel, layer->in,
                                  layer->out, error);
    }
    if (status == FEWRAY_OK)
        status = find_scales(kpn, weights, error);
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
    for (int i = 0; i < KPN_LAYER_COUNT; i++)
        if ((*kpn)->convs[i].weights)
            nn_conv_clear(&(*kpn)->convs[i]);
    free(*kpn);
    *kpn = NULL;
}
