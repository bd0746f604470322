/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_RUN_CHECKPOINT_H
#define FEWRAY_PIPELINE_RUN_CHECKPOINT_H

/* A run that keeps its state in a file, and goes on with one. */

#include <stdatomic.h>

#include "pipeline/checkpoint.h"

struct run;

struct run_checkpoint {
    struct fewray_state *state; /* NULL: no checkpoints */
    struct checkpoint_file from;
    struct checkpoint_info info;
    double start, due;      /* of this run, of the next one; changes only while no thread traces */
    _Atomic double noticed; /* when the first thread stopped because it was due; 0: none has */
    double earlier_s;       /* of the runs before */
    volatile int stop; /* the tracing's own cancel: set between tiles, once the state is safe */
    bool traced;       /* all samples are there; what follows is done anew by who goes on */
    struct fewray_render_stats counts; /* by then */
    bool stopped;                      /* what the interrupt left is in the file */
    bool failing;                      /* the last one couldn't be written, and that was told */
};

/* Opens the file to go on with, where there is one. */
int run_checkpoint_open(struct run *run, struct fewray_error *error);
/* Takes its state, once the film is there and it is known whether there is a guide. */
int run_checkpoint_resume(struct run *run, struct fewray_error *error);
/* The run's settings for steps whose samples count: paused for checkpoints and previews, and not
 * cancelled within a tile. */
struct fewray_render_settings run_checkpoint_settings(struct run *run);
/* All samples are traced. */
void run_checkpoint_traced(struct run *run);
/* Writes what an interrupt outside those steps leaves. Returns whether the file holds all that is
 * done. */
bool run_checkpoint_stop(struct run *run);
/* The outputs are there: once they are safe against loss of power, the file isn't needed. */
void run_checkpoint_remove(struct run *run);
void run_checkpoint_end(struct run *run);

#endif
