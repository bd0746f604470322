/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_RUN_PROGRESS_H
#define FEWRAY_PIPELINE_RUN_PROGRESS_H

/* What a run tells whoever waits for it: phase, part and seconds left of the whole. */

#include "fewray/pipeline.h"
#include "pipeline/estimate.h"

struct run_progress {
    struct estimate estimate;
    void (*tell)(void *user, const struct fewray_progress *progress); /* NULL: nobody waits */
    void *user;
    void (*tell_phase)(void *user, const char *phase, double part); /* NULL */
    void *phase_user;
    const char *resumed_phase; /* NULL; where a checkpoint goes on: phases before it are over */
    double resumed_part;       /* that is done of it, 0..1 */
};

/* What there is to do, as far as is known. */
struct run_work {
    long long pixels;
    int threads;
    int look, rest; /* samples a pixel before and after the guide */
    bool maps, edges, denoised;
    int pictures; /* PNG files to write beside the EXR */
};

/* A render's phases; nothing is expected of them yet. */
void run_progress_start(struct run_progress *progress);
/* `fewray denoise`: load, denoise, write. */
void run_progress_start_denoise(struct run_progress *progress);
/* Of the phases that are still to come. */
void run_progress_expect(struct run_progress *progress, const struct run_work *work);
/* For struct fewray_render_settings' progress; user is the struct run_progress. */
void run_progress_update(void *user, const char *phase, double part);

#endif
