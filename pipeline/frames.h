/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_FRAMES_H
#define FEWRAY_PIPELINE_FRAMES_H

/* Numbers of frames on the command line and in files' names. */

#include <stdbool.h>

#include "fewray/pipeline.h"

/* Reads "7", "1..48" or "1..48x2" (every second one). False where it is none of these. */
bool frames_parse(const char *text, struct fewray_frames *out);
/* The number of frames. */
int frames_count(const struct fewray_frames *frames);

/* Whether the name has a place for the frame's number: one run of #, as "shot.####.exr", or one
 * %d or %04d. */
bool frames_name_has_place(const char *pattern);
/* The name of one frame's file, malloc'd: its number with as many digits as there are #, or as %d
 * says. A pattern without a place is copied. NULL: out of memory. */
char *frames_name(const char *pattern, int frame);

/* The numbers of the files that are there, in ascending order: *numbers is malloc'd. Only the
 * file's own name may have the place, not its folder's. */
int frames_find(const char *pattern, int **numbers, int *count, struct fewray_error *error);

#endif
