/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_KPN_ROWS_H
#define FEWRAY_DENOISE_KPN_ROWS_H

/* The network's layers that aren't plain convolutions, row by row; kpn.c runs them. */

#include "denoise/kernel_apply.h"
#include "denoise/kpn.h"

#define KPN_LEVELS 5 /* of the irradiance pyramid */

/* clang-format off */
enum buffer {
    NONE,
    FEATURES, ENC0A, ENC0, POOL0, ENC1A, ENC1, POOL1, ENC2A, ENC2, POOL2, ENC3A, ENC3,
    UP2, DEC2A, DEC2, UP1, DEC1A, DEC1, UP0, DEC0A, DEC0,
    RAW_KEY, /* what a pixel's own features add to its key, at half resolution for all four */
    LIGHT0, LIGHT1, LIGHT2, LIGHT3, LIGHT4, /* irradiance pyramid */
    OUT1, OUT2, OUT3, OUT4,                 /* filtered irradiance */
    KEY0, KEY1, KEY2, KEY3, KEY4,           /* keys of the pyramid's pixels, nn_affinity */
    BUFFER_COUNT,
    FIRST_IMAGE = LIGHT0
};
/* clang-format on */

/* The keys of a level of light. */
static inline int kpn_keys_of(enum buffer light) {
    return KEY0 + ((int)light - LIGHT0);
}

enum op {
    OP_FEATURES,     /* makes FEATURES and LIGHT0 of the picture */
    OP_CONV,         /* convolution and leaky ReLU */
    OP_RAW_KEY,      /* linear convolution */
    OP_KEY,          /* adds RAW_KEY to what it predicts and makes KEY0 of it */
    OP_POOL,         /* mean of 2x2 */
    OP_UPSAMPLE_ADD, /* adds the input, enlarged, to the output */
    OP_DOWN,         /* next level of LIGHT and KEY: 2x2 means with predicted weights */
    OP_KERNEL,       /* filters LIGHT with predicted kernels times the affinity of keys; level 0
                      * goes to the picture */
};

/* A layer's input and output are those of its convolution; light and coarse are what its prediction
 * is applied to. */
struct kpn_layer {
    enum op op;
    const char *name;
    int kernel, in, out;
    enum buffer input, output, light, coarse;
};

/* A network at work on a region. */
struct kpn_work {
    const struct nn_kernels *kernels;
    const struct kpn_job *job;
    int slots; /* kpn_layers_slots() */
    const float (
        *parity)[4][KPN_TAPS_COARSE]; /* added to the coarse logits: [level][place in 2x2] */
    const float (*scale)[2][NN_KEY];  /* of keys: [level][fine or coarse taps] */
    struct nn_tensor tensors[BUFFER_COUNT];
    struct kpn_image images[BUFFER_COUNT];
    char *scratch; /* kpn_scratch_bytes() for each thread */
};

/* Bytes of scratch a thread for a region of this width, a multiple of 64. */
size_t kpn_scratch_bytes(int width, int slots);

/* Makes row y of FEATURES, and rows 2 y and 2 y + 1 of LIGHT0. */
void kpn_features_row(struct kpn_work *work, int y);
/* Makes rows 2 y and 2 y + 1 of KEY0. */
void kpn_key_row(struct kpn_work *work, const struct kpn_layer *layer, const struct nn_conv *conv,
                 int y);
/* Makes row y of the next coarser level of LIGHT and KEY. */
void kpn_down_row(struct kpn_work *work, const struct kpn_layer *layer, const struct nn_conv *conv,
                  int y);
/* Makes row y of OUT1 to OUT4. */
void kpn_kernel_row(struct kpn_work *work, const struct kpn_layer *layer,
                    const struct nn_conv *conv, int y);
/* Makes rows 2 y and 2 y + 1 of the picture. */
void kpn_picture_rows(struct kpn_work *work, const struct kpn_layer *layer,
                      const struct nn_conv *conv, int y);

#endif
