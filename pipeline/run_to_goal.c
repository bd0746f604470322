/* SPDX-License-Identifier: Apache-2.0 */
/* Samples until the planner has enough: it looks at the picture now and then. */

#include <math.h>

#include "pipeline/clock.h"
#include "pipeline/run.h"

/* Camera rays for the edges, before the first picture. */
static int edges_to_goal(struct run *run, struct fewray_error *error) {
    struct fewray_render_settings now = run->settings;
    now.progress = NULL;
    now.spp = planner_least_samples(run->planner);
    const int status = fewray_trace_edges(run->world, &now, run->film, &run->stats.counts, error);
    run->edges_traced = true;
    planner_edges_traced(run->planner);
    return status;
}

/* The samples so far as a finished picture, for the planner. */
static int show_planner(struct run *run, struct fewray_error *error) {
    int status = run->edges_traced ? FEWRAY_OK : edges_to_goal(run, error);
    if (!status)
        status = run_develop(run, error);
    run->stats.render_s += clock_lap(&run->lap);
    if (!status)
        status = run_denoise(run, error);
    if (!status)
        planner_see(run->planner, run->frame);
    return status;
}

int run_to_goal(struct run *run, struct fewray_error *error) {
    struct fewray_rest *rest = NULL;
    struct fewray_pass pass;
    int status = fewray_rest_create(run->world, run->maps, &run->settings, run->film, &rest, error);
    while (!status && planner_next_pass(run->planner, &pass)) {
        fewray_frame_destroy(&run->frame);
        status = fewray_rest_pass(rest, &pass, &run->stats.counts, error);
        if (!status)
            planner_passed(run->planner);
        if (!status && planner_wants_picture(run->planner))
            status = show_planner(run, error);
    }
    fewray_rest_destroy(&rest);
    if (!status && !run->frame)
        status = show_planner(run, error);
    planner_finish(run->planner, &run->stats.plan);
    run->stats.spp = (int)lround(run->stats.plan.spp);
    run->stats.render_s += clock_lap(&run->lap);
    return status;
}
