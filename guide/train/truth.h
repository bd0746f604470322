/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_TRAIN_TRUTH_H
#define FEWRAY_GUIDE_TRAIN_TRUTH_H

/* What arrives at a surface point, traced bin by bin instead of inferred. */

#include "guide/trace/integrator.h"

struct truth_bin {
    int used;           /* samples that were finite */
    double mean;        /* radiance, mean of RGB */
    double root_moment; /* root of the mean square of what a sample brings beside next-event
                           estimation at LOOK_PDF: what a sampling map should be in proportion to */
};

/* By `samples` directions spread over a bin of sphere_grid.h, each with one estimate of the
 * radiance that arrives. normal: unit, shading and geometric. */
struct truth_bin truth_bin(const struct integrator *in, struct vec3 position, struct vec3 normal,
                           int bin, int samples, uint32_t seed);

#endif
