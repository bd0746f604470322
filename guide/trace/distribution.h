/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_DISTRIBUTION_H
#define FEWRAY_GUIDE_DISTRIBUTION_H

/* Sampling of an index in proportion to weights by a cumulative sum. */

#include <stddef.h>

/* Fills cdf[0..n] (cdf[0] = 0, cdf[n] = 1) from non-negative weights summed in double precision; returns the sum. All
 * weights zero: uniform. */
static inline double cdf_build(const float *weights, size_t n, float *cdf) {
    double total = 0;
    for (size_t i = 0; i < n; i++)
        total += weights[i];
    double sum = 0;
    cdf[0] = 0;
    for (size_t i = 0; i < n; i++) {
        sum += total > 0 ? weights[i] / total : 1.0 / (double)n;
        cdf[i + 1] = (float)(sum < 1 ? sum : 1);
    }
    cdf[n] = 1;
    return total;
}

/* The index i with cdf[i] <= *u < cdf[i + 1]; *u becomes the position within that interval, in [0, 1). */
static inline size_t cdf_sample(const float *cdf, size_t n, float *u) {
    size_t low = 0, high = n;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (cdf[middle] <= *u)
            low = middle;
        else
            high = middle;
    }
    float width = cdf[low + 1] - cdf[low];
    float position = width > 0 ? (*u - cdf[low]) / width : 0;
    *u = position < 0x1.fffffep-1f ? position : 0x1.fffffep-1f;
    return low;
}

#endif
