/* SPDX-License-Identifier: Apache-2.0 */
/* Time left of a run, from its phases' measured speeds. */

#include "pipeline/estimate.h"

#include <math.h>
#include <string.h>

/* How much a factor that was measured before counts against a phase's own speed, as a part of the
 * phase; a guess counts less. */
#define WEIGHT_OF_MEASURED 0.1
#define WEIGHT_OF_GUESS    0.02
/* Part of all expected seconds that must be over before the time left is told. */
#define KNOWN_PART 0.02
/* The end moves to where it is newly expected within this part of what is left, at most so many
 * seconds, and a small part more. */
#define SMOOTH_SOON    0.3
#define SMOOTH_SECONDS 1.0
#define SMOOTH_PART    0.05
/* Smoothing may not hide more than this factor. */
#define SMOOTH_LIMIT 2.0

void estimate_start(struct estimate *estimate, const struct estimate_phase *phases, int count,
                    double now) {
    *estimate = (struct estimate){.count = count, .start = now, .begin = now, .now = now};
    memcpy(estimate->phases, phases, sizeof(*phases) * (size_t)count);
    for (int k = 0; k < ESTIMATE_KINDS; k++)
        estimate->factor[k] = 1;
}

static int find_phase(const struct estimate *estimate, const char *name) {
    for (int i = 0; i < estimate->count; i++)
        if (!strcmp(estimate->phases[i].name, name))
            return i;
    return -1;
}

void estimate_expect(struct estimate *estimate, const char *phase, double seconds) {
    const int i = find_phase(estimate, phase);
    if (i > estimate->current || (i == estimate->current && estimate->part == 0))
        estimate->phases[i].expected = seconds;
}

/* Measured over expected seconds, of the current phase's kind, with what the phase itself shows. */
static double current_factor(const struct estimate *estimate) {
    const struct estimate_phase *phase = &estimate->phases[estimate->current];
    const double weight =
        phase->expected * (estimate->measured[phase->kind] ? WEIGHT_OF_MEASURED : WEIGHT_OF_GUESS);
    if (!(phase->expected > 0))
        return estimate->factor[phase->kind];
    const double took = fmax(estimate->now - estimate->begin, 0);
    return (took + weight * estimate->factor[phase->kind]) /
           (phase->expected * estimate->part + weight);
}

/* The current phase is over; `next` begins. */
static void begin_phase(struct estimate *estimate, int next, double now) {
    const struct estimate_phase *phase = &estimate->phases[estimate->current];
    if (phase->expected > 0 && estimate->part > 0) {
        estimate->part = 1;
        estimate->now = now;
        estimate->factor[phase->kind] = current_factor(estimate);
        estimate->measured[phase->kind] = true;
    }
    estimate->current = next;
    estimate->begin = now;
    estimate->part = 0;
}

/* Seconds left by the speeds so far; *covered gets the part of all expected seconds that is over.
 */
static double raw_left(const struct estimate *estimate, double *covered) {
    double left = 0, over = 0, all = 0;
    const int kind = estimate->phases[estimate->current].kind;
    for (int i = 0; i < estimate->count; i++) {
        const struct estimate_phase *phase = &estimate->phases[i];
        const double part = i < estimate->current ? 1 : i == estimate->current ? estimate->part : 0;
        all += phase->expected;
        over += part * phase->expected;
        left += (1 - part) * phase->expected *
                (phase->kind == kind ? current_factor(estimate) : estimate->factor[phase->kind]);
    }
    *covered = all > 0 ? over / all : 0;
    return left;
}

static void smooth(struct estimate *estimate, double left, double passed) {
    const double now = estimate->now;
    const double window = fmin(SMOOTH_SOON * left, SMOOTH_SECONDS) + SMOOTH_PART * left;
    estimate->end += (now + left - estimate->end) * (1 - exp(-passed / fmax(window, 1e-6)));
    estimate->end = fmin(fmax(estimate->end, now + left / SMOOTH_LIMIT), now + left * SMOOTH_LIMIT);
}

void estimate_update(struct estimate *estimate, const char *phase, double part, double now) {
    const int i = find_phase(estimate, phase);
    const double passed = fmax(now - estimate->now, 0);
    if (i < estimate->current)
        return;
    if (i > estimate->current)
        begin_phase(estimate, i, now);
    estimate->now = fmax(now, estimate->now);
    estimate->part = fmin(fmax(part, estimate->part), 1);

    double covered;
    const double left = raw_left(estimate, &covered);
    if (estimate->known) {
        smooth(estimate, left, passed);
    } else if (covered >= KNOWN_PART) {
        estimate->known = true;
        estimate->end = estimate->now + left;
    }
    if (!estimate->known)
        return;
    const double elapsed = estimate->now - estimate->start;
    const double fraction = elapsed / fmax(estimate->end - estimate->start, 1e-9);
    estimate->fraction = fmin(fmax(estimate->fraction, fraction), 1);
}

void estimate_except(struct estimate *estimate, double seconds) {
    estimate->begin += seconds;
}

double estimate_fraction(const struct estimate *estimate) {
    return estimate->fraction;
}

double estimate_left(const struct estimate *estimate) {
    return estimate->known ? fmax(estimate->end - estimate->now, 0) : -1;
}
