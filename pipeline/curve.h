/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_CURVE_H
#define FEWRAY_PIPELINE_CURVE_H

/* A curve of error against time: what lies between its points is interpolated between the
 * logarithms of both, for error falls with a power of time. Nothing is extrapolated. */

enum { CURVE_POINTS_MAX = 32 };

struct curve {
    int count;                                                 /* points, in the order of time */
    double seconds[CURVE_POINTS_MAX], error[CURVE_POINTS_MAX]; /* > 0 */
};

/* Adds a point in its place; one without a positive time or error (NaN, or below the reference's
 * own noise), or beyond the most points, is left out. */
void curve_add(struct curve *curve, double seconds, double error);

/* The error after so many seconds; NaN before the first point and after the last one. */
double curve_error_at(const struct curve *curve, double seconds);

/* The seconds after which the error is first as small; NaN where it never is. Where already the
 * first point's error is smaller: that point's seconds. */
double curve_seconds_to(const struct curve *curve, double error);

#endif
