/* SPDX-License-Identifier: Apache-2.0 */
/* The progress bar, redrawn ten times a second at most. */

#include "pipeline/progress.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "pipeline/clock.h"

enum { BAR_WIDTH = 30 };

void progress_start(struct progress *progress) {
    const char *terminal = getenv("TERM");
    *progress = (struct progress){.enabled = isatty(STDERR_FILENO) &&
                                             (!terminal || strcmp(terminal, "dumb"))};
}

void progress_update(void *user, const char *phase, double fraction) {
    struct progress *progress = user;
    if (!progress->enabled)
        return;
    const double now = clock_seconds();
    if (!progress->phase || strcmp(progress->phase, phase)) {
        progress->phase = phase;
        progress->phase_start = now;
        progress->last_drawn = 0;
    }
    if (now - progress->last_drawn < 0.1)
        return;
    progress->last_drawn = now;
    fraction = fraction < 0 ? 0 : fraction > 1 ? 1 : fraction;

    char bar[BAR_WIDTH + 1], left[32] = "";
    const int full = (int)(fraction * BAR_WIDTH);
    memset(bar, '#', (size_t)full);
    memset(bar + full, '.', (size_t)(BAR_WIDTH - full));
    bar[BAR_WIDTH] = 0;
    if (fraction > 0.02)
        snprintf(left, sizeof left, "%.0f s left",
                 (now - progress->phase_start) * (1 / fraction - 1));
    fprintf(stderr, "\r\033[K%-10s [%s] %3.0f %%  %s", phase, bar, 100 * fraction, left);
    fflush(stderr);
    progress->shown = true;
}

void progress_end(struct progress *progress) {
    if (progress->shown)
        fputs("\r\033[K", stderr);
    progress->shown = false;
}
