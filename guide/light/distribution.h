/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_DISTRIBUTION_H
#define FEWRAY_GUIDE_DISTRIBUTION_H

/* Sampling of an index in proportion to weights by a cumulative sum. */

#include <stddef.h>
#include <stdint.h>

/* Fills cdf[0..n] (cdf[0] = 0, cdf[n] = 1) from non-negative weights summed in double precision;
 * returns the sum. All weights zero: uniform. */
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

/* Position of *u within the interval i, in [0, 1). */
static inline void cdf_rescale(const float *cdf, size_t i, float *u) {
    float width = cdf[i + 1] - cdf[i];
    float position = width > 0 ? (*u - cdf[i]) / width : 0;
    *u = position < 0x1.fffffep-1f ? position : 0x1.fffffep-1f;
}

/* The index i with cdf[i] <= *u < cdf[i + 1]; *u becomes the position within that interval, in [0,
 * 1). */
static inline size_t cdf_sample(const float *cdf, size_t n, float *u) {
    size_t low = 0, high = n;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (cdf[middle] <= *u)
            low = middle;
        else
            high = middle;
    }
    cdf_rescale(cdf, low, u);
    return low;
}

/* Where the search for k / cuts may start, for each k in 0..cuts-1 (Chen and Asau 1974): a long
 * table is then read at one place instead of along a bisection. */
static inline void cdf_cut(const float *cdf, size_t n, uint32_t *start, size_t cuts) {
    size_t i = 0;
    for (size_t k = 0; k < cuts; k++) {
        while (i + 1 < n && cdf[i + 1] <= (float)k / (float)cuts)
            i++;
        start[k] = (uint32_t)i;
    }
}

/* The entry of cdf_cut()'s table that u starts from. */
static inline size_t cdf_cut_of(float u, size_t cuts) {
    size_t k = (size_t)(u * (float)cuts);
    return k < cuts ? k : cuts - 1;
}

/* cdf_sample() from where that entry says; the same result. */
static inline size_t cdf_sample_from(const float *cdf, size_t n, size_t start, float *u) {
    size_t i = start;
    while (i > 0 && cdf[i] > *u)
        i--;
    while (i + 1 < n && cdf[i + 1] <= *u)
        i++;
    cdf_rescale(cdf, i, u);
    return i;
}

#endif
