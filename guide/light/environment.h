/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_ENVIRONMENT_H
#define FEWRAY_GUIDE_ENVIRONMENT_H

/* Radiance from infinitely far away, and its importance sampling by luminance. */

#include "guide/scene/scene.h"

struct environment_table {
    const struct environment *environment;
    int width, height;    /* cells of the sampling table; 0 without a map */
    float *row_cdf;       /* (height + 1) */
    float *column_cdf;    /* (height, width + 1) */
    uint32_t *column_cut; /* (height, cuts): see cdf_cut() */
    int cuts;
    double power_density; /* mean luminance over the sphere */
};

int environment_table_create(const struct environment *environment, struct environment_table *table,
                             struct fewray_error *error);
void environment_table_clear(struct environment_table *table);

/* Radiance that arrives from a unit direction. */
struct vec3 environment_radiance(const struct environment *environment, struct vec3 direction);
/* Draws a direction; *pdf gets its density (solid angle), 0 where it can't be used. */
struct vec3 environment_sample(const struct environment_table *table, const float u[2], float *pdf);
/* Density (solid angle) with which environment_sample() draws a direction. */
float environment_pdf(const struct environment_table *table, struct vec3 direction);

#endif
