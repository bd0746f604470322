/* SPDX-License-Identifier: Apache-2.0 */
/* Tensors' sizes and borders. */

#include <string.h>

#include "denoise/nn/nn.h"

size_t nn_tensor_bytes(int height, int width, int channels) {
    size_t floats = ((size_t)height + 2) * ((size_t)width + 2) * (size_t)channels;
    return (floats * sizeof(float) + 63) & ~(size_t)63;
}

void nn_fill_border(const struct nn_tensor *t, enum nn_border border) {
    size_t pixel = (size_t)t->channels * sizeof(float);
    size_t row = ((size_t)t->width + 2) * pixel;
    memset(nn_at(t, -1, -1), 0, row);
    memset(nn_at(t, t->height, -1), 0, row);
    for (int y = 0; y < t->height; ++y) {
        float *left = nn_at(t, y, -1), *right = nn_at(t, y, t->width);
        if (border == NN_BORDER_WRAP_X) {
            memcpy(left, nn_at(t, y, t->width - 1), pixel);
            memcpy(right, nn_at(t, y, 0), pixel);
        } else {
            memset(left, 0, pixel);
            memset(right, 0, pixel);
        }
    }
}
