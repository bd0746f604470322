/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_PROGRESS_H
#define FEWRAY_PIPELINE_PROGRESS_H

/* A bar on the terminal: phase, percent, seconds left. Silent where stderr is no terminal. */

#include <stdbool.h>

struct progress {
    bool enabled, shown;
    const char *phase;
    double phase_start, last_drawn; /* seconds of the monotonic clock */
};

void progress_start(struct progress *progress);
/* For fewray_render_settings.progress; user is the struct progress. */
void progress_update(void *user, const char *phase, double fraction);
/* Wipes the bar, so that what is printed next starts on a clean line. */
void progress_end(struct progress *progress);

#endif
