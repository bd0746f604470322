/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_DENSITY_H
#define FEWRAY_GUIDE_DENSITY_H

/* Sampling of a density over the sphere that is constant within each bin of a grid of size x size
 * bins, laid out as in sphere_grid.h; size divides that grid's. */

#include "guide/light/distribution.h"
#include "guide/odis/sphere_grid.h"

/* A position within a bin, kept off its borders so that rounding can't lead into a bin of another
 * density. */
static inline float density_inside(float position) {
    return position < 1e-5f ? 1e-5f : position < 1 - 1e-5f ? position : 1 - 1e-5f;
}

static inline int density_bin(struct vec3 direction, int size) {
    int bin = sphere_bin(direction), bins = SPHERE_ROWS / size;
    return bin / SPHERE_COLUMNS / bins * size + bin % SPHERE_COLUMNS / bins;
}

/* Unit direction at (a, b) in [0, 1)^2 of a bin; uniform in solid angle. */
static inline struct vec3 density_direction(int row, int column, float a, float b, int size) {
    int bins = SPHERE_ROWS / size;
    float y = a * (float)bins, x = b * (float)bins;
    int fine_row = (int)y, fine_column = (int)x;
    return sphere_direction(row * bins + fine_row, column * bins + fine_column, y - (float)fine_row,
                            x - (float)fine_column);
}

/* Cumulative sum of the rows of values (pdf up to a factor) and the density (solid angle;
 * integrates to 1 over the sphere). row_cdf: (size + 1). False where all values are zero, or so
 * small that what normalises them isn't a float; or where one is negative or isn't finite. */
static inline bool density_build(const float *values, int size, float *row_cdf, float *density) {
    float rows[SPHERE_ROWS];
    double total = 0;
    float least = 0;
    for (int r = 0; r < size; r++) {
        float sum = 0;
        for (int c = 0; c < size; c++) {
            float value = values[r * size + c];
            sum += value;
            least = value < least ? value : least;
        }
        rows[r] = sum;
        total += sum;
    }
    float to_density = (float)((double)(size * size) / (total * 4 * (double)PI_F));
    if (!(total > 0) || !isfinite(total) || !isfinite(to_density) || least < 0)
        return false;
    cdf_build(rows, (size_t)size, row_cdf);
    for (int b = 0; b < size * size; b++)
        density[b] = values[b] * to_density;
    return true;
}

/* Draws a unit direction. */
static inline struct vec3 density_sample(const float *row_cdf, const float *density, int size,
                                         const float u[2]) {
    float a = u[0], b = u[1];
    int row = (int)cdf_sample(row_cdf, (size_t)size, &a);
    const float *values = density + row * size;
    b *= (row_cdf[row + 1] - row_cdf[row]) * ((float)(size * size) / (4 * PI_F));
    int column = 0, last = 0;
    for (; column < size && b >= values[column]; column++) {
        b -= values[column];
        if (values[column] > 0)
            last = column;
    }
    if (column == size) /* rounding at the row's end */
        column = last, b = values[last];
    return density_direction(row, column, density_inside(a), density_inside(b / values[column]),
                             size);
}

#endif
