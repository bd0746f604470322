/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_COARSE_H
#define FEWRAY_PIPELINE_COARSE_H

/* A coarse picture for previews in which most pixels have no sample yet. */

#include "fewray/denoise.h"
#include "fewray/guide.h"

/* Traces one path for every 4 x 4 pixels of a width x height picture, filters them (denoiser may be
 * NULL) and makes R, G, B of that size of them. They are no part of any film. *out is owned by the
 * caller. */
int coarse_trace(const struct fewray_world *world, const struct fewray_render_settings *settings,
                 int width, int height, struct fewray_denoiser *denoiser, struct fewray_frame **out,
                 struct fewray_error *error);

/* Pixels of a film's frame that have no sample, or saw nothing at all: mask[i], (height, width). */
void coarse_mask(const struct fewray_frame *frame, bool *mask);
/* Their R, G, B become the coarse picture's, of the same size. */
void coarse_fill(const struct fewray_frame *coarse, const bool *mask, struct fewray_frame *frame);

#endif
