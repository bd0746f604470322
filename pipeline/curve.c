/* SPDX-License-Identifier: Apache-2.0 */
/* Curves of error against time. */

#include "pipeline/curve.h"

#include <math.h>

void curve_add(struct curve *curve, double seconds, double error) {
    if (!(seconds > 0 && error > 0) || isinf(seconds) || isinf(error) ||
        curve->count == CURVE_POINTS_MAX)
        return;
    int place = curve->count++;
    for (; place > 0 && curve->seconds[place - 1] > seconds; place--) {
        curve->seconds[place] = curve->seconds[place - 1];
        curve->error[place] = curve->error[place - 1];
    }
    curve->seconds[place] = seconds;
    curve->error[place] = error;
}

/* y at x on the line between (x0, y0) and (x1, y1) in logarithms. */
static double interpolate(double x0, double y0, double x1, double y1, double x) {
    if (x0 == x1)
        return fmin(y0, y1);
    const double t = log(x / x0) / log(x1 / x0);
    return y0 * pow(y1 / y0, t);
}

double curve_error_at(const struct curve *curve, double seconds) {
    const double *s = curve->seconds, *e = curve->error;
    for (int i = 0; i < curve->count; i++) {
        if (seconds == s[i])
            return e[i];
        if (i > 0 && seconds > s[i - 1] && seconds < s[i])
            return interpolate(s[i - 1], e[i - 1], s[i], e[i], seconds);
    }
    return NAN;
}

double curve_seconds_to(const struct curve *curve, double error) {
    const double *s = curve->seconds, *e = curve->error;
    for (int i = 0; i < curve->count; i++)
        if (e[i] <= error)
            return i == 0 ? s[0] : interpolate(e[i - 1], s[i - 1], e[i], s[i], error);
    return NAN;
}
