/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_PROGRESS_H
#define FEWRAY_PIPELINE_PROGRESS_H

/* A bar on the terminal: percent of the whole run, phase, seconds left. Silent where stderr is no
 * terminal. */

#include "fewray/pipeline.h"

struct progress {
    bool enabled, shown;
    const char *phase;
    double last_drawn, phase_start; /* seconds of the monotonic clock */
};

void progress_start(struct progress *progress);
/* For struct fewray_job's progress; user is the struct progress. */
void progress_update(void *user, const struct fewray_progress *now);
/* For work that tells of single phases; its time left is the phase's. */
void progress_update_phase(void *user, const char *phase, double fraction);
/* Wipes the bar, so that what is printed next starts on a clean line. */
void progress_end(struct progress *progress);

/* "[###.......]  12 %  render  8.4 s left" in fewer than `columns` characters: without the bar, or
 * cut, where there is no room. text has size bytes. */
void progress_line(const struct fewray_progress *now, int columns, char *text, size_t size);

#endif
