/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_PART_H
#define FEWRAY_PIPELINE_PART_H

/* Parts of a picture: each has a share of every pixel's samples. A part's file holds the layers of
 * an unfiltered render as 32-bit floats, the moments of fewray_film_add_moments(), and in its
 * header, as texts, what the part is of. */

#include "fewray/pipeline.h"

/* What the header tells: the attributes fewray.part ("3/10"), fewray.spp, fewray.seed,
 * fewray.scene, fewray.scene_fingerprint and fewray.settings. */
struct part_label {
    int part, parts;   /* 1..parts */
    int spp;           /* samples a pixel of each part */
    int width, height; /* pixels */
    char seed[24], fingerprint[24];
    char scene[512]; /* path, cut; for people */
    char settings[768];
};

/* What the part of a job will be; settings are the job's with the defaults resolved. */
void part_label_of_job(const struct fewray_job *job, const struct fewray_render_settings *settings,
                       uint64_t fingerprint, int width, int height, struct part_label *label);

/* Puts the label into the frame's header; false without memory. */
bool part_label_write(const struct part_label *label, struct fewray_frame *frame);
/* Takes it from a frame, whose file is refused where it is no part. */
int part_label_read(const struct fewray_frame *frame, const char *path, struct part_label *label,
                    struct fewray_error *error);

/* In what two parts differ that should be of one picture, "the scene" say; NULL: they belong
 * together. Their numbers aren't looked at. */
const char *part_difference(const struct part_label *a, const struct part_label *b);

/* Reads a part's pixels; one without all planes, or with values that no render has, is refused. */
int part_read(const char *path, struct fewray_frame **out, struct fewray_error *error);

/* Whether the file at path is this very part, whole. */
bool part_is_there(const struct part_label *label, const char *path);

/* Adds a part to the sum of others, whose planes are weighted means by the number of samples that
 * each pixel has in each part. Both have been read by part_read(); the sum starts as a first part.
 * False where their planes differ. */
bool part_add(struct fewray_frame *sum, const struct fewray_frame *part);

/* Turns the sum into a picture: the variance by the spread of all parts' samples, no moments. */
void part_finish(struct fewray_frame *sum);

#endif
