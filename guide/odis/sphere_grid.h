/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SPHERE_GRID_H
#define FEWRAY_GUIDE_SPHERE_GRID_H

/* The full sphere in 32 x 32 bins of equal solid angle (paper, section 3.2): rows are equal steps
 * of y from +1 down to -1 (Archimedes), columns equal steps of azimuth around the y axis, which
 * wraps. */

#include <stdbool.h>

#include "guide/vec.h"

#define SPHERE_ROWS            32
#define SPHERE_COLUMNS         32
#define SPHERE_BINS            (SPHERE_ROWS * SPHERE_COLUMNS)
#define SPHERE_BIN_SOLID_ANGLE (4 * PI_F / SPHERE_BINS) /* steradians */

/* Column of the azimuth atan2(x, z), found by comparing slopes with those between the columns of
 * half a quadrant: every sample asks for it, and the arc tangent costs several times as much. */
static inline int sphere_column(float x, float z) {
    const float slope1 = 0.19891237f, slope2 = 0.41421356f, slope3 = 0.66817864f; /* tan(k pi/16) */
    float ax = fabsf(x), az = fabsf(z);
    float low = ax < az ? ax : az, high = ax < az ? az : ax;
    int c = (low >= slope1 * high) + (low >= slope2 * high) + (low >= slope3 * high);
    c = ax < az ? c : SPHERE_COLUMNS / 4 - 1 - c;
    c = z < 0 ? SPHERE_COLUMNS / 2 - 1 - c : c;
    return x < 0 ? SPHERE_COLUMNS - 1 - c : c;
}

static inline int sphere_bin(struct vec3 direction) {
    int row = (int)((1 - direction.y) * (0.5f * SPHERE_ROWS));
    row = row < 0 ? 0 : row < SPHERE_ROWS ? row : SPHERE_ROWS - 1;
    return row * SPHERE_COLUMNS + sphere_column(direction.x, direction.z);
}

/* Cosine of a column's middle azimuth; columns wrap. */
static inline float sphere_column_cosine(int column) {
    static const float quadrant[SPHERE_COLUMNS / 4] = {
        0.99518473f, 0.95694034f, 0.88192126f, 0.77301045f,
        0.63439328f, 0.47139674f, 0.29028468f, 0.09801714f,
    };
    int c = column & (SPHERE_COLUMNS / 2 - 1);
    bool behind = c >= SPHERE_COLUMNS / 4, turned = (column & (SPHERE_COLUMNS / 2)) != 0;
    float cosine = quadrant[behind ? SPHERE_COLUMNS / 2 - 1 - c : c];
    return behind != turned ? -cosine : cosine;
}

static inline float sphere_column_sine(int column) {
    return sphere_column_cosine(column - SPHERE_COLUMNS / 4);
}

/* Unit direction at (a, b) in [0, 1)^2 of a bin; uniform in solid angle. The azimuth is the
 * column's middle turned by at most pi / 32, for which three terms of the series are exact to
 * float. */
static inline struct vec3 sphere_direction(int row, int column, float a, float b) {
    float y = 1 - ((float)row + a) * (2.0f / SPHERE_ROWS);
    float r2 = 1 - y * y, r = r2 > 0 ? sqrtf(r2) : 0;
    float turn = (b - 0.5f) * (2 * PI_F / SPHERE_COLUMNS), t2 = turn * turn;
    float sine = turn * (1 - t2 * (1.0f / 6) * (1 - t2 * (1.0f / 20)));
    float cosine = 1 - t2 * 0.5f * (1 - t2 * (1.0f / 12) * (1 - t2 * (1.0f / 30)));
    float column_sine = sphere_column_sine(column), column_cosine = sphere_column_cosine(column);
    return vec(r * (column_sine * cosine + column_cosine * sine), y,
               r * (column_cosine * cosine - column_sine * sine));
}

/* Cosine of each bin's centre to a normal; 0 below the horizon. */
static inline void sphere_cosines(struct vec3 normal, float cosine[SPHERE_BINS]) {
    float level[SPHERE_COLUMNS]; /* of the columns' horizontal directions */
    for (int c = 0; c < SPHERE_COLUMNS; c++)
        level[c] = normal.x * sphere_column_sine(c) + normal.z * sphere_column_cosine(c);
    for (int row = 0; row < SPHERE_ROWS; row++) {
        float y = 1 - ((float)row + 0.5f) * (2.0f / SPHERE_ROWS), r = sqrtf(1 - y * y);
        for (int c = 0; c < SPHERE_COLUMNS; c++) {
            float cos_theta = r * level[c] + normal.y * y;
            cosine[row * SPHERE_COLUMNS + c] = cos_theta > 0 ? cos_theta : 0;
        }
    }
}

#endif
