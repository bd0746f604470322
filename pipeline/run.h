/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_RUN_H
#define FEWRAY_PIPELINE_RUN_H

/* What the steps of a picture's way hand to each other: see render.c, which goes it. */

#include "pipeline/outputs.h"
#include "pipeline/part.h"
#include "pipeline/planner.h"
#include "pipeline/preview.h"
#include "pipeline/run_checkpoint.h"
#include "pipeline/run_progress.h"
#include "pipeline/shot.h"

struct run {
    const struct fewray_job *job;
    struct fewray_outputs outputs; /* the job's in the first process of a team, else none */
    struct shot *shot;             /* NULL: a picture of its own */
    struct fewray_render_settings
        settings; /* the job's, with the number of threads and the first look settled */
    struct fewray_run_stats stats;
    bool guided;       /* what the pilot left of the job's wish */
    double start, lap; /* seconds of the monotonic clock */
    struct fewray_scene *scene;
    struct fewray_world *world;
    struct fewray_film *film;
    struct fewray_look *look;
    struct fewray_maps *maps;
    struct fewray_frame *frame;
    struct part_label label; /* of a part of a picture */
    struct planner *planner; /* NULL: no goal, settings.spp samples everywhere */
    enum fewray_denoise_model model;
    bool edges_traced; /* of a render to a goal */
    bool undenoised;   /* the denoiser failed: the frame is as it was */
    struct run_progress progress;
    struct preview preview;
    struct run_checkpoint checkpoint;
};

/* A step's status that ends the run without fault. */
enum { PART_IS_THERE = 1 };

/* Whether this process makes the picture of what its team has traced. */
static inline bool run_is_first(const struct run *run) {
    return !run->settings.team || run->settings.team->rank == 0;
}

/* A step is done where it is done in all processes of the team. */
static inline int run_agree(const struct run *run, int status, struct fewray_error *error) {
    return fewray_team_agree(run->settings.team, status, error);
}

/* What can be told to be impossible before anything is loaded. */
int run_check(const struct run *run, struct fewray_error *error);
/* Of a part: what it is, and whether it is there already. */
int run_label_part(struct run *run);

/* Shows the film to who waits, where that is due. */
void run_show_preview(struct run *run, bool whole_pass);

/* The film's sums become the picture and its feature layers. */
int run_develop(struct run *run, struct fewray_error *error);
/* R, G, B, and their parts where they were kept apart, become the filtered picture; what they were
 * is kept as noisy.R, noisy.G, noisy.B ... Not again, where the planner saw this picture. */
int run_denoise(struct run *run, struct fewray_error *error);
/* The remaining samples: as many, and where, as the planner wants. */
int run_to_goal(struct run *run, struct fewray_error *error);

#endif
