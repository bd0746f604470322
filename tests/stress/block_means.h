/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_BLOCK_MEANS_H
#define FEWRAY_TESTS_BLOCK_MEANS_H

/* Means of independent renders over blocks of pixels, and whether two sets of them have the same
 * expectation.
 *
 * A block's value in one render is the mean of R, G and B over its pixels. Of two sets of renders
 * the difference of a block's means over its standard error is Welch's t (Welch 1947); it is turned
 * into the deviate z of a normal distribution that is as improbable (Wallace 1959, equation 4.2),
 * so that few renders don't make it look large. */

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK_SIDE 8 /* pixels */

/* Floats' rounding of a mean over samples and renders: what is smaller isn't a difference. */
#define BLOCK_ROUNDING 1e-5

struct block_sum {
    double mean, deviation; /* over the renders: mean, and sum of squared deviations */
};

struct block_means {
    int columns, rows, renders;
    struct block_sum picture; /* of the whole picture's mean */
    struct block_sum *blocks; /* (rows, columns) */
};

static inline void block_sum_add(struct block_sum *sum, double value, int renders) {
    double delta = value - sum->mean; /* Welford 1962 */
    sum->mean += delta / renders;
    sum->deviation += delta * (value - sum->mean);
}

static inline double block_value(const float *const planes[3], int width, int height, int x0,
                                 int y0, int side) {
    double sum = 0;
    int count = 0;
    for (int y = y0; y < y0 + side && y < height; y++)
        for (int x = x0; x < x0 + side && x < width; x++, count += 3)
            for (int c = 0; c < 3; c++)
                sum += (double)planes[c][(size_t)y * (size_t)width + (size_t)x];
    return sum / count;
}

/* Adds a render. *means starts as {0}; free(means->blocks) at the end. False without memory. */
static inline bool block_means_add(struct block_means *means, const float *const planes[3],
                                   int width, int height) {
    means->columns = (width + BLOCK_SIDE - 1) / BLOCK_SIDE;
    means->rows = (height + BLOCK_SIDE - 1) / BLOCK_SIDE;
    const int blocks = means->columns * means->rows;
    if (!means->blocks)
        means->blocks = calloc((size_t)blocks, sizeof *means->blocks);
    if (!means->blocks)
        return false;
    means->renders++;
    for (int b = 0; b < blocks; b++)
        block_sum_add(&means->blocks[b],
                      block_value(planes, width, height, b % means->columns * BLOCK_SIDE,
                                  b / means->columns * BLOCK_SIDE, BLOCK_SIDE),
                      means->renders);
    block_sum_add(&means->picture,
                  block_value(planes, width, height, 0, 0, width > height ? width : height),
                  means->renders);
    return true;
}

/* Variance of a mean over the renders. */
static inline double block_variance(const struct block_sum *sum, int renders) {
    return sum->deviation / (renders - 1) / renders;
}

static inline double block_error(const struct block_sum *a, int a_renders,
                                 const struct block_sum *b, int b_renders) {
    const double rounding = BLOCK_ROUNDING * (fabs(a->mean) + fabs(b->mean));
    return sqrt(block_variance(a, a_renders) + block_variance(b, b_renders) + rounding * rounding);
}

/* z of the difference a - b; 0 where both are black in all renders. */
static inline double block_z(const struct block_sum *a, int a_renders, const struct block_sum *b,
                             int b_renders) {
    const double error = block_error(a, a_renders, b, b_renders);
    if (!(error > 0))
        return a->mean == b->mean ? 0 : INFINITY;
    const double va = block_variance(a, a_renders), vb = block_variance(b, b_renders);
    const double t = (a->mean - b->mean) / error;
    const double spread = va * va / (a_renders - 1) + vb * vb / (b_renders - 1);
    const double freedom = spread > 0 ? (va + vb) * (va + vb) / spread : 1e9; /* Satterthwaite */
    const double z = sqrt(freedom * log1p(t * t / freedom)) * (8 * freedom + 1) / (8 * freedom + 3);
    return copysign(z, t);
}

struct block_comparison {
    int blocks, over;  /* all; those with |z| > 3, of which chance gives 0.27 % */
    double greatest;   /* z of the block where it is farthest from 0 */
    int x, y;          /* that block's column and row */
    double picture;    /* z of the whole picture's mean */
    double resolution; /* standard error of the picture's difference over its mean */
};

static inline struct block_comparison block_compare(const struct block_means *a,
                                                    const struct block_means *b) {
    struct block_comparison c = {.blocks = b->columns * b->rows};
    for (int k = 0; k < c.blocks; k++) {
        const double z = block_z(&a->blocks[k], a->renders, &b->blocks[k], b->renders);
        c.over += fabs(z) > 3;
        if (fabs(z) <= fabs(c.greatest))
            continue;
        c.greatest = z;
        c.x = k % b->columns;
        c.y = k / b->columns;
    }
    c.picture = block_z(&a->picture, a->renders, &b->picture, b->renders);
    c.resolution =
        block_error(&a->picture, a->renders, &b->picture, b->renders) / fabs(b->picture.mean);
    return c;
}

/* --- what chance allows */

/* The |z| that a normal deviate exceeds with this probability. */
static inline double normal_limit(double probability) {
    double low = 0, high = 40;
    for (int i = 0; i < 80; i++) {
        const double middle = (low + high) / 2;
        *(erfc(middle / sqrt(2)) > probability ? &low : &high) = middle;
    }
    return high;
}

/* The number that a binomial count exceeds with at most this probability. */
static inline int binomial_limit(int n, double chance, double probability) {
    double term = pow(1 - chance, n), below = term;
    int k = 0;
    while (1 - below > probability && k < n) {
        term *= (double)(n - k) / (k + 1) * chance / (1 - chance);
        below += term;
        k++;
    }
    return k;
}

#define BLOCK_BEYOND_3 0.0026998 /* probability of |z| > 3 */

#endif
