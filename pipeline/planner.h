/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_PLANNER_H
#define FEWRAY_PIPELINE_PLANNER_H

/* Leads a render to its goal (struct fewray_goal): measures, decides by plan.h, and remembers why.
 *
 *     planner_create()       scene loaded: how long are denoising and writing?
 *     planner_prepare()      pilot traced: guide, first look, edges, the denoiser's model
 *     planner_next_pass()    until it says that it is enough:
 *     planner_passed()         the pass was traced
 *     planner_see()            where planner_wants_picture(): the denoised picture
 *     planner_finish()       the plan as it went
 */

#include "fewray/pipeline.h"

struct planner;

bool planner_has_goal(const struct fewray_goal *goal);

/* job must outlive it. start: of the run, seconds of clock_seconds(). *out is owned by the caller.
 */
int planner_create(const struct fewray_job *job, double start, struct planner **out,
                   struct fewray_error *error);
void planner_destroy(struct planner **planner);

/* pilot_s: seconds it took. *guided: comes as what the job and the
 * pilot want. Changes settings and model. */
int planner_prepare(struct planner *planner, const struct fewray_pilot *pilot, double pilot_s,
                    struct fewray_render_settings *settings, bool *guided,
                    enum fewray_denoise_model *model, struct fewray_error *error);

/* The next pass; *pass's array is the planner's. False: enough. */
bool planner_next_pass(struct planner *planner, struct fewray_pass *pass);
void planner_passed(struct planner *planner);
/* Samples a pixel of the tile that has the fewest. */
int planner_least_samples(const struct planner *planner);
/* The camera rays for edges are done. */
void planner_edges_traced(struct planner *planner);
/* Whether the samples so far are to be made a picture before there are more. */
bool planner_wants_picture(const struct planner *planner);
/* The denoised picture of the samples so far; also the last, unless it was seen. */
void planner_see(struct planner *planner, const struct fewray_frame *frame);

/* What was planned; to be called before the statistics are written. */
void planner_finish(struct planner *planner, struct fewray_plan *plan);

#endif
