/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_CHECK_H
#define FEWRAY_TESTS_CHECK_H

/* cmocka with the headers that it needs, and the statistics that several tests share. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#define assert_near(value, expected, tolerance)                                                    \
    do {                                                                                           \
        double near_value = (value), near_expected = (expected), near_tolerance = (tolerance);     \
        if (!(fabs(near_value - near_expected) <= near_tolerance))                                 \
            fail_msg("%s is %.9g, expected %.9g +- %.2g", #value, near_value, near_expected,       \
                     near_tolerance);                                                              \
    } while (0)

/* Pearson's statistic of observed counts against expected ones; cells that expect fewer than 5 are
 * pooled. *degrees gets the degrees of freedom. */
static inline double chi_square(const double *observed, const double *expected, int cells,
                                int *degrees) {
    double sum = 0, pooled_observed = 0, pooled_expected = 0;
    *degrees = -1;
    for (int i = 0; i < cells; i++) {
        if (expected[i] < 5) {
            pooled_observed += observed[i];
            pooled_expected += expected[i];
            continue;
        }
        sum += (observed[i] - expected[i]) * (observed[i] - expected[i]) / expected[i];
        ++*degrees;
    }
    if (pooled_expected >= 5) {
        sum += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) /
               pooled_expected;
        ++*degrees;
    }
    return sum;
}

/* The value that chi-square of so many degrees stays below with probability 1 - 1e-5 (Wilson and
 * Hilferty 1931). */
static inline double chi_square_limit(int degrees) {
    double k = 2.0 / (9.0 * degrees), z = 4.265;
    double c = 1 - k + z * sqrt(k);
    return degrees * c * c * c;
}

#endif
