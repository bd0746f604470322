/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SPHERE_GRID_H
#define FEWRAY_GUIDE_SPHERE_GRID_H

/* The full sphere in 32 x 32 bins of equal solid angle (paper, section 3.2): rows are equal steps
 * of y from +1 down to -1 (Archimedes), columns equal steps of azimuth around the y axis, which
 * wraps. */

#include "guide/vec.h"

#define SPHERE_ROWS            32
#define SPHERE_COLUMNS         32
#define SPHERE_BINS            (SPHERE_ROWS * SPHERE_COLUMNS)
#define SPHERE_BIN_SOLID_ANGLE (4 * PI_F / SPHERE_BINS) /* steradians */

static inline int sphere_bin(struct vec3 direction) {
    int row = (int)((1 - direction.y) * (0.5f * SPHERE_ROWS));
    float turn = atan2f(direction.x, direction.z) * (0.5f / PI_F);
    int column = (int)((turn < 0 ? turn + 1 : turn) * SPHERE_COLUMNS);
    row = row < 0 ? 0 : row < SPHERE_ROWS ? row : SPHERE_ROWS - 1;
    return row * SPHERE_COLUMNS + (column & (SPHERE_COLUMNS - 1));
}

/* Unit direction at (a, b) in [0, 1)^2 of a bin; uniform in solid angle. */
static inline struct vec3 sphere_direction(int row, int column, float a, float b) {
    float y = 1 - ((float)row + a) * (2.0f / SPHERE_ROWS);
    float r = sqrtf(fmaxf(0, 1 - y * y));
    float phi = ((float)column + b) * (2 * PI_F / SPHERE_COLUMNS);
    return vec(r * sinf(phi), y, r * cosf(phi));
}

#endif
