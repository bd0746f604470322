/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_TEMPORAL_H
#define FEWRAY_DENOISE_TEMPORAL_H

/* What the frames of a sequence share, pixel by pixel. */

#include "fewray/denoise.h"

/* A pixel of a frame, or of the mean over frames. */
struct temporal_pixel {
    float light[3];                    /* (colour - emission) / albedo */
    float variance[3];                 /* of noisy light */
    float depth, normal[3], albedo[3]; /* of the newest frame */
    float frames;                      /* that light is a mean of; 0 = nothing is known */
};

/* Pixels of the previous frame that show what a pixel of this one shows. */
struct temporal_taps {
    int count;
    size_t index[4];
    float weight[4]; /* bilinear, their sum is 1 */
};

/* Where the surface of pixel (x, y) of `now` was in `past`, both (height, width), and which of the
 * four pixels there show it: those whose depth, normal and albedo agree. position: in pixels from
 * the upper left corner. */
struct temporal_taps temporal_find(const struct temporal_pixel *past,
                                   const struct temporal_pixel *now, int width, int height, int x,
                                   int y, const float position[2], float previous_depth);
/* The mean over taps. The variance is the mean of variances: neighbours share taps, so that an
 * interpolated pixel has less noise, but an area hasn't. */
void temporal_mix(const struct temporal_pixel *past, const struct temporal_taps *taps,
                  struct temporal_pixel *out);

/* Lowers frames of each pixel of `warped` where its light differs from `now`'s by more than their
 * noise explains: what moved there isn't the surface. scratch: 4 (height, width) planes. */
void temporal_trust(const struct temporal_pixel *now, struct temporal_pixel *warped, int width,
                    int height, float sigmas, int threads, float *scratch);

#endif
