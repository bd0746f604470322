/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_KPN_NETWORK_H
#define FEWRAY_DENOISE_KPN_NETWORK_H

/* What kpn_create() makes: the layers in their order, with weights, and the sizes of the buffers
 * between them. */

#include "denoise/kpn_rows.h"

enum { KPN_WIDTHS = 4, KPN_LAYER_COUNT = 35 };

struct kpn {
    const struct nn_kernels *kernels;
    int widths[KPN_WIDTHS]; /* channels of levels 1 to 4 */
    struct kpn_layer layers[KPN_LAYER_COUNT];
    struct nn_conv convs[KPN_LAYER_COUNT];
    int levels[BUFFER_COUNT];   /* a buffer has 1 / 2^level of the picture's resolution */
    int channels[BUFFER_COUNT]; /* of tensors, in whole vectors, whose rest stays 0 */
    /* Added to the coarse logits of levels 1 to 3: by level and place in a 2x2 block. */
    float parity[4][4][KPN_TAPS_COARSE];
    float scale[KPN_LEVELS][2][NN_KEY]; /* of keys: by level, for fine and coarse taps */
};

#endif
