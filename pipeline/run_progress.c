/* SPDX-License-Identifier: Apache-2.0 */
/* The phases of a run and how long each takes, before anything is measured. */

#include "pipeline/run_progress.h"

#include <math.h>
#include <string.h>

#include "pipeline/clock.h"

/* Seconds of one core: living-room at 350x200 on one core of an AMD EPYC, by `fewray render
 * --verbose`. Scenes differ in the tracing by a few times, in the other phases hardly; what the
 * first look takes corrects the rest of the tracing. */
#define LOOK_SAMPLE  6.1e-6
#define REST_SAMPLE  7.0e-6
#define EDGES_PIXEL  2.6e-6
#define MAPS_PIXEL   1.3e-6
#define FILTER_PIXEL 1.0e-6
#define EXR_PIXEL    1.1e-6 /* by one thread, as the PNG */
#define PNG_PIXEL    0.3e-6

enum { OPENING, TRACING, LEARNING, FILTERING, WRITING };

void run_progress_start(struct run_progress *progress) {
    static const struct estimate_phase phases[] = {
        {"load", OPENING, 0},       {"bvh", OPENING, 0},       {"pilot", OPENING, 0},
        {"first look", TRACING, 0}, {"guide", LEARNING, 0},    {"render", TRACING, 0},
        {"edges", TRACING, 0},      {"denoise", FILTERING, 0}, {"write", WRITING, 0}};
    estimate_start(&progress->estimate, phases, sizeof phases / sizeof *phases, clock_seconds());
}

void run_progress_start_denoise(struct run_progress *progress) {
    static const struct estimate_phase phases[] = {
        {"load", OPENING, 0}, {"denoise", FILTERING, 0}, {"write", WRITING, 0}};
    estimate_start(&progress->estimate, phases, sizeof phases / sizeof *phases, clock_seconds());
}

/* Part of a phase that a checkpoint has left. */
static double part_left(const struct run_progress *progress, const char *phase) {
    if (!progress->resumed_phase)
        return 1;
    if (!strcmp(phase, progress->resumed_phase))
        return 1 - progress->resumed_part;
    const bool before = !strcmp(phase, "first look") || !strcmp(phase, "guide");
    return before && !strcmp(progress->resumed_phase, "render") ? 0 : 1;
}

void run_progress_expect(struct run_progress *progress, const struct run_work *work) {
    struct estimate *estimate = &progress->estimate;
    const double pixels = (double)work->pixels, share = pixels / work->threads;
    estimate_expect(estimate, "first look",
                    share * LOOK_SAMPLE * work->look * part_left(progress, "first look"));
    estimate_expect(estimate, "guide",
                    work->maps ? share * MAPS_PIXEL * part_left(progress, "guide") : 0);
    estimate_expect(estimate, "render",
                    share * REST_SAMPLE * work->rest * part_left(progress, "render"));
    estimate_expect(estimate, "edges", work->edges ? share * EDGES_PIXEL : 0);
    estimate_expect(estimate, "denoise", work->denoised ? share * FILTER_PIXEL : 0);
    estimate_expect(estimate, "write", pixels * (EXR_PIXEL + PNG_PIXEL * work->pictures));
}

void run_progress_update(void *user, const char *phase, double part) {
    struct run_progress *progress = user;
    if (progress->tell_phase)
        progress->tell_phase(progress->phase_user, phase, part);
    if (!progress->tell)
        return;
    const double left = part_left(progress, phase);
    if (left < 1) /* the bar is of this run's own work */
        part = left > 0 ? 1 - fmin((1 - part) / left, 1) : 1;
    estimate_update(&progress->estimate, phase, part, clock_seconds());
    const struct fewray_progress now = {phase, estimate_fraction(&progress->estimate),
                                        estimate_left(&progress->estimate)};
    progress->tell(progress->user, &now);
}
