/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_SHOT_H
#define FEWRAY_PIPELINE_SHOT_H

/* What the frames of a sequence hand on to each other, and one frame of it. */

#include "fewray/pipeline.h"

struct shot {
    struct fewray_scene *scene; /* NULL before the first frame; owned by the shot, as all here */
    struct fewray_world *world;
    double time;                            /* of the frame, seconds */
    struct fewray_denoise_history *history; /* NULL: each frame is denoised by itself */
    struct fewray_view view;                /* of the frame that the history knows last */
    bool has_view;
};

/* fewray_job_run() of a frame of a shot, whose scene and world are used if they are there, else
 * made and left there. shot NULL: a picture of its own. */
int shot_run_frame(const struct fewray_job *job, struct shot *shot, struct fewray_frame **picture,
                   struct fewray_run_stats *stats, struct fewray_error *error);

/* Denoises a frame of the shot, and makes it the mean over the frames so far. */
int shot_denoise(struct shot *shot, struct fewray_denoiser *denoiser, struct fewray_frame *frame,
                 const char *const *parts, int part_count, struct fewray_denoise_stats *stats,
                 struct fewray_error *error);
/* Adds a frame that was rendered before, by what its file holds. */
int shot_remember(struct shot *shot, const struct fewray_denoise_options *options, const char *exr,
                  const char *const *parts, int part_count, struct fewray_error *error);
/* Scene and world go, the history stays. */
void shot_forget_scene(struct shot *shot);
void shot_end(struct shot *shot);

#endif
