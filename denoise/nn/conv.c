/* SPDX-License-Identifier: Apache-2.0 */
/* Packs PyTorch's convolution weights for the kernels. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "denoise/nn/nn.h"

static int round_up(int n, int to) {
    return (n + to - 1) / to * to;
}

/* (out, in, k, k) -> (out / NN_LANES, k, k, in, NN_LANES); what padding adds is zero already. */
static void pack_weights(const struct nn_conv *conv, const float *weights, int in, int out) {
    int taps = conv->kernel * conv->kernel;
    for (int o = 0; o < out; ++o)
        for (int i = 0; i < in; ++i)
            for (int tap = 0; tap < taps; ++tap) {
                size_t row = ((size_t)(o / NN_LANES) * taps + tap) * conv->in + i;
                conv->weights[row * NN_LANES + o % NN_LANES] =
                    weights[((size_t)o * in + i) * taps + tap];
            }
}

static float *zeroed(size_t floats) {
    size_t bytes = floats * sizeof(float); /* a multiple of 64: the lanes see to that */
    float *data = aligned_alloc(64, bytes);
    if (data)
        memset(data, 0, bytes);
    return data;
}

int nn_conv_pack(struct nn_conv *conv, const struct nn_weights *weights, const char *layer,
                 int kernel, int in, int out, struct fewray_error *error) {
    *conv = (struct nn_conv){0};
    if ((kernel != 1 && kernel != 3) || in < 1 || out < 1 || in > 4096 || out > 4096)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "layer %s: no convolution of kernel %d, %d -> %d channels", layer,
                           kernel, in, out);
    char name[64];
    snprintf(name, sizeof name, "%.40s.weight", layer);
    const struct nn_weight *weight =
        nn_weights_find(weights, name, (int[4]){out, in, kernel, kernel}, error);
    if (!weight)
        return FEWRAY_ERROR_FORMAT;
    snprintf(name, sizeof name, "%.40s.bias", layer);
    const struct nn_weight *bias = nn_weights_find(weights, name, (int[4]){out, 1, 1, 1}, error);
    if (!bias)
        return FEWRAY_ERROR_FORMAT;

    conv->kernel = kernel;
    conv->in = round_up(in, NN_LANES);
    conv->in_used = round_up(in, 4);
    conv->out = round_up(out, NN_LANES);
    conv->out_used = round_up(out, NN_LANES / 2);
    conv->weights = zeroed((size_t)conv->out * kernel * kernel * conv->in);
    conv->bias = zeroed((size_t)conv->out);
    if (!conv->weights || !conv->bias) {
        nn_conv_clear(conv);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for layer %s", layer);
    }
    pack_weights(conv, weight->data, in, out);
    memcpy(conv->bias, bias->data, (size_t)out * sizeof(float));
    return FEWRAY_OK;
}

void nn_conv_clear(struct nn_conv *conv) {
    free(conv->weights);
    free(conv->bias);
    *conv = (struct nn_conv){0};
}
