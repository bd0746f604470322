/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_REGRESSION_CASE_H
#define FEWRAY_TESTS_REGRESSION_CASE_H

/* expected.json of a regression folder. */

#include <stdbool.h>

enum { MODE_COUNT = 4, METRIC_COUNT = 2 };

/* What is rendered, and what is measured of it. */
extern const struct regression_mode {
    const char *name;
    bool guided, denoised;
} REGRESSION_MODES[MODE_COUNT];
extern const char *const REGRESSION_METRICS[METRIC_COUNT];

struct regression_case {
    char scene[512]; /* a file of examples/ */
    int width, height, spp;
    int seeds; /* pictures to average the errors of: 1, 2, ... */
    int reference_spp;
    double tolerance; /* by which an error may grow, as a share */
    double expected[MODE_COUNT][METRIC_COUNT];
};

/* Both return false and print why. expected is 0 where the file has none yet. */
bool regression_case_read(const char *path, struct regression_case *out);
bool regression_case_write(const char *path, const struct regression_case *in);

#endif
