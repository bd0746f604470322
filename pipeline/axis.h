/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_AXIS_H
#define FEWRAY_PIPELINE_AXIS_H

/* A logarithmic axis of a plot: where its ticks stand and what they are called. */

enum { AXIS_TICKS_MAX = 200 };

struct axis {
    double least, most; /* 0 < least < most */
};

struct axis_tick {
    double value;
    char label[16]; /* "0.05"; empty: a small tick between labels */
};

/* The axis from least to most, with some room at both ends; at least a factor of two wide. */
struct axis axis_around(double least, double most);

/* Ticks at 1, 2, ..., 9 times a power of ten, ascending, from the axis's least to its most. So many
 * of them are labelled as fit: at most room, at least one where there is any. Labels are at 1, 2,
 * 5; else at powers of ten; else at every 2nd, 3rd, ... power. Returns the number of ticks. */
int axis_ticks(struct axis axis, int room, struct axis_tick ticks[AXIS_TICKS_MAX]);

/* Where value stands: 0 at least, 1 at most; may lie outside. */
double axis_place(struct axis axis, double value);

#endif
