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

/* Fills albedo and emission, (height, width, 3) each, from in's color and albedo; scale is in's.
 * A single bright pixel is an outlier and no emitter. */
void emitters_find(const struct fewray_denoise_input *in, const struct kpn_scale *scale,
                   int threads, float *albedo, float *emission);

#endif
