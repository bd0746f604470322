/* SPDX-License-Identifier: Apache-2.0 */
/* Applying predicted kernels: each tap is one multiply-add of a four-channel pixel. */

#include "denoise/kernel_apply.h"

#include <string.h>

#include "denoise/clones.h"

/* GCC's and Clang's vectors, compiled to whatever the target has. */
typedef float pixel4 __attribute__((vector_size(16)));

CLONED_INLINE pixel4 load(const float *p) {
    pixel4 v;
    memcpy(&v, p, sizeof v);
    return v;
}

CLONED_INLINE void store(float *p, pixel4 v) {
    memcpy(p, &v, sizeof v);
}

size_t kpn_image_bytes(int height, int width, int channels) {
    size_t floats =
        (size_t)(height + 2 * KPN_BORDER) * (size_t)(width + 2 * KPN_BORDER) * (size_t)channels;
    return (floats * sizeof(float) + 63) & ~(size_t)63;
}

void kpn_fill_border(const struct kpn_image *image, int y0, int y1) {
    int h = image->height, w = image->width;
    size_t pixel = (size_t)image->channels * sizeof(float);
    for (int y = y0; y < y1; y++)
        for (int i = 1; i <= KPN_BORDER; i++) {
            memcpy(kpn_pixel(image, y, -i), kpn_pixel(image, y, 0), pixel);
            memcpy(kpn_pixel(image, y, w - 1 + i), kpn_pixel(image, y, w - 1), pixel);
        }
    size_t row = kpn_row_floats(image) * sizeof(float);
    for (int i = 1; i <= KPN_BORDER; i++) {
        if (y0 == 0)
            memcpy(kpn_pixel(image, -i, -KPN_BORDER), kpn_pixel(image, 0, -KPN_BORDER), row);
        if (y1 == h)
            memcpy(kpn_pixel(image, h - 1 + i, -KPN_BORDER), kpn_pixel(image, h - 1, -KPN_BORDER),
                   row);
    }
}

CLONED void kpn_apply(const float *weights, const struct kpn_image *fine,
                      const struct kpn_image *coarse, int y, int x, float *out) {
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

CLONED void kpn_apply_slots(const float *weights, const struct kpn_image *fine,
                            const struct kpn_image *coarse, int y, int x, float *out,
                            size_t slot_floats) {
    const int pixel = fine->channels;
    for (int c = 0; c < pixel; c += 4) {
        pixel4 sum[5] = {{0}}; /* in the order of kpn_apply(): the same bits */
        for (int dy = 0; dy < 5; dy++) {
            const float *p = kpn_pixel(fine, y + dy - 2, x - 2) + c, *k = weights + 5 * dy;
            for (int dx = 0; dx < 5; dx++)
                sum[dx] += k[dx] * load(p + pixel * dx);
        }
        for (int dy = 0; coarse && dy < 3; dy++) {
            const float *p = kpn_pixel(coarse, y / 2 + dy - 1, x / 2 - 1) + c;
            const float *k = weights + KPN_TAPS_FINE + 3 * dy;
            for (int dx = 0; dx < 3; dx++)
                sum[dx] += k[dx] * load(p + pixel * dx);
        }
        store(out + (size_t)(c / 4) * slot_floats, (sum[0] + sum[1]) + (sum[2] + sum[3]) + sum[4]);
    }
}

CLONED void kpn_downsample_row(const float *weights, const struct kpn_image *fine, int y, int x0,
                               int count, float *out) {
    int channels = fine->channels;
    for (int i = 0; i < count; i++) {
        const float *upper = kpn_pixel(fine, 2 * y, 2 * (x0 + i)), *k = weights + 4 * i;
        const float *lower = kpn_pixel(fine, 2 * y + 1, 2 * (x0 + i));
        for (int c = 0; c < channels; c += 4)
            store(out + channels * i + c,
                  (k[0] * load(upper + c) + k[1] * load(upper + channels + c)) +
                      (k[2] * load(lower + c) + k[3] * load(lower + channels + c)));
    }
}
