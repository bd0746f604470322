/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_LAYER_NAMES_H
#define FEWRAY_PIPELINE_LAYER_NAMES_H

/* The channel names of other renderers. */

#include "fewray/features.h"

enum layer_naming { NAMING_AUTO, NAMING_FEWRAY, NAMING_MITSUBA, NAMING_BLENDER, NAMING_PBRT };

/* Renames the planes of another renderer to fewray's own names, for each layer that the frame
 * lacks. Where several fit, the best for a denoiser is taken (Blender's "Denoising Albedo" before
 * "DiffCol"). Depths that stand for a miss become 0, Blender's environment is added to its
 * emission, and pbrt's variance, that of its samples, is divided by their number, without which
 * (frame->spp) it isn't taken. */
void adopt_layer_names(struct fewray_frame *frame, enum layer_naming naming);

/* Reads an EXR and adopts its names; a file without colour channels is an error. */
int read_picture(const char *path, enum layer_naming naming, struct fewray_frame **out,
                 struct fewray_error *error);

#endif
