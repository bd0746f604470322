/* SPDX-License-Identifier: Apache-2.0 */
/* Applying predicted kernels: each tap is one multiply-add of a four-channel pixel. */

#include "denoise/kernel_apply.h"

#include <string.h>

/* GCC's and Clang's vectors, compiled to whatever the target has. */
typedef float pixel4 __attribute__((vector_size(16)));

static inline pixel4 load(const float *p) {
    pixel4 v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline void store(float *p, pixel4 v) {
    memcpy(p, &v, sizeof v);
}

size_t kpn_image_bytes(int height, int width) {
    size_t bytes =
        (size_t)(height + 2 * KPN_BORDER) * (size_t)(width + 2 * KPN_BORDER) * 4 * sizeof(float);
    return (bytes + 63) & ~(size_t)63;
}

void kpn_fill_border(const struct kpn_image *image) {
    int h = image->height, w = image->width;
    for (int y = 0; y < h; y++) {
        pixel4 left = load(kpn_pixel(image, y, 0)), right = load(kpn_pixel(image, y, w - 1));
        for (int i = 1; i <= KPN_BORDER; i++) {
            store(kpn_pixel(image, y, -i), left);
            store(kpn_pixel(image, y, w - 1 + i), right);
        }
    }
    size_t row = (size_t)(w + 2 * KPN_BORDER) * 4 * sizeof(float);
    for (int i = 1; i <= KPN_BORDER; i++) {
        memcpy(kpn_pixel(image, -i, -KPN_BORDER), kpn_pixel(image, 0, -KPN_BORDER), row);
        memcpy(kpn_pixel(image, h - 1 + i, -KPN_BORDER), kpn_pixel(image, h - 1, -KPN_BORDER), row);
    }
}

void kpn_apply(const float *weights, const struct kpn_image *fine, const struct kpn_image *coarse,
               int y, int x, float *out) {
    /* Five independent sums, so that additions needn't wait for each other. */
    pixel4 sum[5] = {{0}};
    for (int dy = 0; dy < 5; dy++) {
        const float *p = kpn_pixel(fine, y + dy - 2, x - 2), *k = weights + 5 * dy;
        for (int dx = 0; dx < 5; dx++)
            sum[dx] += k[dx] * load(p + 4 * dx);
    }
    if (coarse) {
        for (int dy = 0; dy < 3; dy++) {
            const float *p = kpn_pixel(coarse, y / 2 + dy - 1, x / 2 - 1);
            const float *k = weights + KPN_TAPS_FINE + 3 * dy;
            for (int dx = 0; dx < 3; dx++)
                sum[dx] += k[dx] * load(p + 4 * dx);
        }
    }
    store(out, (sum[0] + sum[1]) + (sum[2] + sum[3]) + sum[4]);
}

void kpn_downsample_row(const float *weights, const struct kpn_image *fine, int y, int x0,
                        int count, float *out) {
    for (int i = 0; i < count; i++) {
        const float *upper = kpn_pixel(fine, 2 * y, 2 * (x0 + i)), *k = weights + 4 * i;
        const float *lower = kpn_pixel(fine, 2 * y + 1, 2 * (x0 + i));
        store(out + 4 * i, (k[0] * load(upper) + k[1] * load(upper + 4)) +
                               (k[2] * load(lower) + k[3] * load(lower + 4)));
    }
}
