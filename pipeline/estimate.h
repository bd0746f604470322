/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_ESTIMATE_H
#define FEWRAY_PIPELINE_ESTIMATE_H

/* How far a run of several phases is, and how long it will still take. Each phase has expected
 * seconds; phases of one kind of work share a factor between expected and measured seconds, so that
 * the first of them tells about the later ones. Pure arithmetic: the caller brings the clock. */

#include <stdbool.h>

enum { ESTIMATE_PHASES = 12, ESTIMATE_KINDS = 8 };

struct estimate_phase {
    const char *name; /* static */
    int kind;         /* of work, 0..ESTIMATE_KINDS - 1 */
    double expected;  /* seconds; 0: unknown, or left out */
};

struct estimate {
    struct estimate_phase phases[ESTIMATE_PHASES]; /* in the order of time */
    int count, current;
    double start, begin;           /* of the run, of the current phase; seconds */
    double now;                    /* of the last update */
    double part;                   /* of the current phase that is done, 0..1 */
    double factor[ESTIMATE_KINDS]; /* measured over expected seconds, of what is finished */
    bool measured[ESTIMATE_KINDS]; /* else the factor is a guess: 1 */
    bool known;                    /* enough is measured for a word on the time left */
    double end;                    /* expected end of the run, smoothed; seconds */
    double fraction;               /* see estimate_fraction() */
};

/* now in seconds of a clock that only goes forward, here and below. */
void estimate_start(struct estimate *estimate, const struct estimate_phase *phases, int count,
                    double now);
/* What is learnt about a phase that hasn't begun; unknown names are ignored. */
void estimate_expect(struct estimate *estimate, const char *phase, double seconds);
/* `part` of the phase is done, 0..1. A later phase than the current one ends all before it; an
 * earlier or an unknown one changes nothing. */
void estimate_update(struct estimate *estimate, const char *phase, double part, double now);
/* Seconds of the current phase that were spent on something else and tell nothing of its speed. */
void estimate_except(struct estimate *estimate, double seconds);

/* Share of the whole run's time that is over, 0..1; never falls. */
double estimate_fraction(const struct estimate *estimate);
/* Seconds until the run's end; negative: not known yet. */
double estimate_left(const struct estimate *estimate);

#endif
