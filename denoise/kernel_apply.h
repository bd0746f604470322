/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_KERNEL_APPLY_H
#define FEWRAY_DENOISE_KERNEL_APPLY_H

/* Applying predicted kernels to one level of the irradiance pyramid.
 *
 * A pixel's 25 weights over the 5x5 pixels of its own level come first, row by row, then 9 over the
 * 3x3 pixels of the next coarser level's result around its parent. Pixels beyond the border repeat
 * the nearest one. */

#include <stddef.h>

#define KPN_TAPS_FINE   25
#define KPN_TAPS_COARSE 9
#define KPN_TAPS        (KPN_TAPS_FINE + KPN_TAPS_COARSE)
#define KPN_BORDER      2

/* (height + 4, width + 4, channels) floats, 16-byte aligned. Light has 4 channels for the beauty
 * and for each other layer: RGB and coverage; keys have NN_KEY. */
struct kpn_image {
    int height, width, channels;
    float *data;
};

size_t kpn_image_bytes(int height, int width, int channels);
/* The channels of a pixel; coordinates from -KPN_BORDER to size - 1 + KPN_BORDER. */
static inline float *kpn_pixel(const struct kpn_image *image, int y, int x) {
    ptrdiff_t pitch = image->width + 2 * KPN_BORDER;
    return image->data + ((y + KPN_BORDER) * pitch + x + KPN_BORDER) * image->channels;
}
/* Floats from a row to the next. */
static inline size_t kpn_row_floats(const struct kpn_image *image) {
    return (size_t)(image->width + 2 * KPN_BORDER) * (size_t)image->channels;
}
/* Repeats the outermost pixels of rows y0 <= y < y1 into the border; the first and last rows also
 * into the border above and below. */
void kpn_fill_border(const struct kpn_image *image, int y0, int y1);

/* out[0..3] = the weighted mean around (y, x); weights are non-negative and sum to one; coarse may
 * be NULL (25 weights). */
void kpn_apply(const float *weights, const struct kpn_image *fine, const struct kpn_image *coarse,
               int y, int x, float *out);
/* The same for each slot of four channels, fine's and coarse's: slot s to out[s * slot_floats]. */
void kpn_apply_slots(const float *weights, const struct kpn_image *fine,
                     const struct kpn_image *coarse, int y, int x, float *out, size_t slot_floats);
/* out (count, channels) = means of 2x2 pixels from (2y, 2 x0) on; weights (count, 4) in the order
 * (0,0) (0,1) (1,0) (1,1). */
void kpn_downsample_row(const float *weights, const struct kpn_image *fine, int y, int x0,
                        int count, float *out);

#endif
