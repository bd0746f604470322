/* SPDX-License-Identifier: Apache-2.0 */
/* Ticks of a logarithmic axis. */

#include "pipeline/axis.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

static const double SLACK = 1e-9; /* of an exponent, for powers that aren't exact */

struct axis axis_around(double least, double most) {
    const double margin = pow(most / least, 0.06); /* so that markers don't touch the frame */
    struct axis axis = {least / margin, most * margin};
    const double lacking = 2 / (axis.most / axis.least);
    if (lacking > 1) {
        axis.least /= sqrt(lacking);
        axis.most *= sqrt(lacking);
    }
    return axis;
}

double axis_place(struct axis axis, double value) {
    return log(value / axis.least) / log(axis.most / axis.least);
}

/* Whether the tick digit * 10^power is labelled where labels are made after rule 0, 1, 2, ... */
static bool has_label(int rule, int digit, int power) {
    if (rule == 0)
        return digit == 1 || digit == 2 || digit == 5;
    return digit == 1 && power % rule == 0;
}

static bool inside(struct axis axis, double value) {
    return value >= axis.least * (1 - SLACK) && value <= axis.most * (1 + SLACK);
}

static int count_labels(struct axis axis, int rule, int first, int last) {
    int count = 0;
    for (int power = first; power <= last; power++)
        for (int digit = 1; digit <= 9; digit++)
            count += has_label(rule, digit, power) && inside(axis, digit * pow(10, power));
    return count;
}

int axis_ticks(struct axis axis, int room, struct axis_tick ticks[AXIS_TICKS_MAX]) {
    const int first = (int)floor(log10(axis.least) - SLACK),
              last = (int)floor(log10(axis.most) + SLACK);
    int rule = 0, count = 0;
    while (rule <= last - first && count_labels(axis, rule, first, last) > room)
        rule++;
    const bool small = last - first <= 8; /* else they would touch each other */
    for (int power = first; power <= last; power++)
        for (int digit = 1; digit <= (small ? 9 : 1); digit++) {
            const double value = digit * pow(10, power);
            if (count == AXIS_TICKS_MAX || !inside(axis, value))
                continue;
            struct axis_tick *tick = &ticks[count++];
            tick->value = value;
            tick->label[0] = 0;
            if (has_label(rule, digit, power))
                snprintf(tick->label, sizeof tick->label, "%g", value);
        }
    return count;
}
