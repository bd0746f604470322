/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_CLOCK_H
#define FEWRAY_PIPELINE_CLOCK_H

/* Wall time. */

#include <time.h>

/* Seconds of a clock that nobody sets. */
static inline double clock_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Seconds since *start, which becomes now. */
static inline double clock_lap(double *start) {
    const double now = clock_seconds(), seconds = now - *start;
    *start = now;
    return seconds;
}

#endif
