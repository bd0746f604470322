/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_EMITTERS_H
#define FEWRAY_DENOISE_EMITTERS_H

/* Lamps and windows in pictures that have albedo but no emission layer.
 *
 * What such pixels show isn't reflected by their albedo, which is about 0: divided by it, it would
 * be a huge irradiance, and a thousandth of that is a halo on the wall beside. Black pixels that
 * are bright and alike (a noisy mirror's aren't) are taken for emitters: what exceeds the light
 * that could be reflected there, in them and in the pixels with some albedo that touch them,
 * becomes emission. Black pixels near them, edges against black frames, get so much albedo, up to
 * 1, that their irradiance is believable, too. */

#include "denoise/features_kpn.h"

/* No more irradiance than this times the picture's median is believed beside an emitter. */
#define EMITTERS_IRRADIANCE_MAX 4.0f

#define EMITTERS_BLOCK 32 /* pixels a side */

/* What was found: a mark for each pixel of the blocks that have any, as most have none. Positive:
 * the least albedo; negative: an emitter, of whose colour this part is its own, and the rest an
 * outlier on it. */
struct emitters {
    int width, columns, rows; /* of the picture in pixels; in blocks */
    float **blocks; /* (rows, columns) of (EMITTERS_BLOCK, EMITTERS_BLOCK) or NULL; owned */
    float bound;    /* irradiance that is believed, in the picture's unit */
};

/* From in's color and albedo; scale is in's. A single bright pixel is an outlier and no emitter.
 * Fails only without memory; emitters_clear() is due in any case. */
int emitters_find(const struct fewray_denoise_input *in, const struct kpn_scale *scale, int threads,
                  struct emitters *emitters, struct fewray_error *error);
void emitters_clear(struct emitters *emitters);

/* Change pixels x0 <= x < x0 + count of row y of one channel, where there are marks: albedo from
 * in's to what the denoiser divides by, emission from 0; beyond the picture's right edge the last
 * pixel is repeated. */
void emitters_raise_albedo(const struct emitters *emitters, int y, int x0, int count,
                           float *albedo);
void emitters_add_emission(const struct emitters *emitters, const struct fewray_denoise_input *in,
                           int c, int y, int x0, int count, float *emission);

#endif
