/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_LAYER_NAMES_H
#define FEWRAY_PIPELINE_LAYER_NAMES_H

/* The channel names of other renderers. */

#include "fewray/features.h"

enum layer_naming {
    NAMING_AUTO,
    NAMING_FEWRAY,
    NAMING_MITSUBA,
    NAMING_BLENDER,
    NAMING_PBRT,
    NAMING_ARNOLD,
    NAMING_RENDERMAN,
    NAMING_VRAY,
    NAMING_KARMA,
    NAMING_COUNT
};
/* "auto", "fewray", ...; ends with NULL. */
extern const char *const LAYER_NAMINGS[NAMING_COUNT + 1];

/* Where a frame's layers come from. */
struct adopted_layer {
    bool found, adopted;            /* adopted: it had another name */
    enum layer_naming naming;       /* NAMING_AUTO: a name that several programs use */
    char names[3][FEWRAY_NAME_MAX]; /* of the file's channels */
};
struct adoption {
    struct adopted_layer layers[FEWRAY_LAYER_COUNT];
    char alpha[FEWRAY_NAME_MAX];     /* "" where it is A */
    char result[3][FEWRAY_NAME_MAX]; /* the channels that the denoised picture belongs in */
    bool keeps_noisy; /* the file has the noisy picture beside one that its renderer denoised */
    char added[FEWRAY_NAME_MAX]; /* first channel of the background in the emission, or "" */
    bool depth_of_place;
};

/* Renames the planes of another renderer to fewray's own names, for each layer that the frame
 * lacks. Where several fit, the best for a denoiser is taken (Blender's "Denoising Albedo" before
 * "DiffCol", its "Noisy Image" before the one that it denoised). Depths that stand for a miss
 * become 0, a background is added to the emission, and pbrt's variance, that of its samples, is
 * divided by their number, without which (frame->spp) it isn't taken. */
void adopt_layer_names(struct fewray_frame *frame, enum layer_naming naming);
/* The same; *adoption (may be NULL) tells of it. noisy false: the picture itself, denoised or not.
 */
void adopt_layers(struct fewray_frame *frame, enum layer_naming naming, bool noisy,
                  struct adoption *adoption);

/* The planes "PREFIX.stem + component" for the components "RGB" or "red,green,blue"; without a
 * prefix, else of the first one in the file; case doesn't count. */
bool layer_find(const struct fewray_frame *frame, const char *stem, const char *components,
                struct fewray_plane *found[3]);

/* The same among the layers that had such a name. */
bool layer_find_adopted(const struct fewray_frame *frame, const struct adoption *adoption,
                        const char *stem, struct fewray_plane *found[3]);

/* The channel that a plane of the frame has in the file. */
const char *adopted_name(const struct adoption *adoption, const char *plane);

/* Reads an EXR and adopts its names; a file without colour channels is an error. The picture is
 * what the file's renderer shows: denoised, where it denoised. */
int read_picture(const char *path, enum layer_naming naming, struct fewray_frame **out,
                 struct fewray_error *error);
/* The same to be denoised. */
int read_noisy_picture(const char *path, enum layer_naming naming, struct adoption *adoption,
                       struct fewray_frame **out, struct fewray_error *error);

#endif
