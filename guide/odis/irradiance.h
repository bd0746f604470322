/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_IRRADIANCE_H
#define FEWRAY_GUIDE_IRRADIANCE_H

/* Irradiance around a grid point from the first look: next-event estimation at the first hits, and
 * the bounces with the pooled radiance of their ends. */

#include "guide/odis/look.h"

struct irradiance {
    struct vec3 value; /* irradiance / pi, RGB */
    float confidence;  /* value^2 / (value^2 + variance of its mean), 0..1 */
};

/* Of the records of pixels x0 <= x < x1, y0 <= y < y1 (clamped to the picture) whose surface has
 * about this unit normal. */
struct irradiance irradiance_gather(const struct fewray_look *look, int x0, int y0, int x1, int y1,
                                    struct vec3 normal);

#endif
