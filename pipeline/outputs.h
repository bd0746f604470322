/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_OUTPUTS_H
#define FEWRAY_PIPELINE_OUTPUTS_H

/* The files that a run leaves: all of them or none. */

#include "fewray/pipeline.h"

/* Two outputs of the same name. */
bool outputs_clash(const struct fewray_outputs *outputs);

/* Tries whether every output could be written, so that hours of work aren't lost on a wrong folder.
 * Leaves nothing. */
int outputs_check(const struct fewray_outputs *outputs, struct fewray_error *error);

/* Writes every output beside its place, then renames them all. Sets stats->write_s, and
 * stats->total_s as the seconds since start. */
int outputs_write(const struct fewray_outputs *outputs, const struct fewray_frame *frame,
                  struct fewray_run_stats *stats, double start, struct fewray_error *error);

/* A file that the EXR is a copy of, but for some channels. */
struct kept_file {
    const char *source;
    struct fewray_exr_change *changes; /* pixels are the frame's */
    int change_count;
    char (*noisy_names)[FEWRAY_NAME_MAX]; /* of some changes */
    int noisy_count;
    bool half; /* the picture is written as half floats */
};

/* The same with such an EXR; kept NULL: with all planes of the frame. */
int outputs_write_kept(const struct fewray_outputs *outputs, const struct fewray_frame *frame,
                       const struct kept_file *kept, struct fewray_run_stats *stats, double start,
                       struct fewray_error *error);

#endif
