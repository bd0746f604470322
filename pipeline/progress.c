/* SPDX-License-Identifier: Apache-2.0 */
/* The progress bar, redrawn ten times a second at most. */

#include "pipeline/progress.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "pipeline/clock.h"

enum { BAR_MAX = 30, BAR_MIN = 8, WORDS_ROOM = 36, LINE_SIZE = 128, COLUMNS_UNKNOWN = 80 };

static int terminal_columns(void) {
    struct winsize window;
    return !ioctl(STDERR_FILENO, TIOCGWINSZ, &window) && window.ws_col > 0 ? window.ws_col
                                                                           : COLUMNS_UNKNOWN;
}

static void format_left(double seconds, char *text, size_t size) {
    const long whole = (long)(seconds + 0.5);
    if (seconds < 0)
        snprintf(text, size, "%s", "");
    else if (seconds < 9.95)
        snprintf(text, size, "  %.1f s left", seconds);
    else if (whole < 120)
        snprintf(text, size, "  %ld s left", whole);
    else if (whole < 7200)
        snprintf(text, size, "  %ld min %02ld s left", whole / 60, whole % 60);
    else
        snprintf(text, size, "  %ld h %02ld min left", whole / 3600, whole % 3600 / 60);
}

void progress_line(const struct fewray_progress *now, int columns, char *text, size_t size) {
    char left[48], words[LINE_SIZE], bar[BAR_MAX + 1];
    format_left(now->seconds_left, left, sizeof left);
    /* Only the end is 100 %. */
    const int percent = (int)(100 * now->fraction);
    snprintf(words, sizeof words, "%3d %%  %s%s", percent < 99 ? percent : 99, now->phase, left);
    /* Terminals wrap a line that fills the last column. The bar's length mustn't follow the words'.
     */
    const int length = (int)strlen(words);
    int room = columns - 1 - 3 - (length > WORDS_ROOM ? length : WORDS_ROOM);
    room = room < BAR_MAX ? room : BAR_MAX;
    if (room < BAR_MIN) {
        snprintf(text, size, "%.*s", columns > 1 ? columns - 1 : 0, words);
        return;
    }
    const int full = (int)(now->fraction * room);
    memset(bar, '#', (size_t)full);
    memset(bar + full, '.', (size_t)(room - full));
    bar[room] = 0;
    snprintf(text, size, "[%s] %s", bar, words);
}

void progress_start(struct progress *progress) {
    const char *terminal = getenv("TERM");
    *progress = (struct progress){.enabled = isatty(STDERR_FILENO) &&
                                             (!terminal || strcmp(terminal, "dumb"))};
}

void progress_update(void *user, const struct fewray_progress *now) {
    struct progress *progress = user;
    if (!progress->enabled)
        return;
    const double seconds = clock_seconds();
    const bool same = progress->phase && !strcmp(progress->phase, now->phase);
    if (same && seconds - progress->last_drawn < 0.1)
        return;
    if (!same)
        progress->phase_start = seconds;
    progress->phase = now->phase;
    progress->last_drawn = seconds;
    char line[LINE_SIZE + BAR_MAX];
    progress_line(now, terminal_columns(), line, sizeof line);
    fprintf(stderr, "\r%s\033[K", line);
    fflush(stderr);
    progress->shown = true;
}

void progress_update_phase(void *user, const char *phase, double fraction) {
    const struct progress *progress = user;
    const bool same = progress->phase && !strcmp(progress->phase, phase);
    const double spent = same ? clock_seconds() - progress->phase_start : 0;
    const struct fewray_progress now = {phase, fraction,
                                        fraction > 0.02 ? spent * (1 / fraction - 1) : -1};
    progress_update(user, &now);
}

void progress_end(struct progress *progress) {
    if (progress->shown)
        fputs("\r\033[K", stderr);
    progress->shown = false;
}
