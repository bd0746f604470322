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
    uint32_t *row_cut;    /* (height): see cdf_cut() */
    uint32_t *column_cut; /* (height, cuts): likewise */
    int cuts;
    double power_density; /* mean luminance over the sphere */
};

int environment_table_create(const struct environment *environment, struct environment_table *table,
                             struct fewray_error *error);
void environment_table_clear(struct environment_table *table);

/* A point of the map, [0, 1]^2; 0 where there is none. */
struct environment_place {
    float u, v;
};
struct environment_place environment_find(const struct environment *environment,
                                          struct vec3 direction);

/* Radiance that arrives from a unit direction. */
struct vec3 environment_radiance(const struct environment *environment, struct vec3 direction);
struct vec3 environment_radiance_at(const struct environment *environment,
                                    const struct environment_place *place);
/* Asks for the memory that environment_radiance_at() will read. */
void environment_prefetch(const struct environment *environment,
                          const struct environment_place *place);

/* Draws a direction; *pdf gets its density (solid angle), 0 where it can't be used. */
struct vec3 environment_sample(const struct environment_table *table, const float u[2], float *pdf);
/* Density (solid angle) with which environment_sample() draws a direction. */
float environment_pdf(const struct environment_table *table, struct vec3 direction);
float environment_pdf_at(const struct environment_table *table,
                         const struct environment_place *place);

/* environment_sample() of a map in three steps, each of which asks for the memory that the next one
 * will read: so that many can be drawn at once without waiting for each. */
struct environment_draw {
    uint32_t row, start; /* of the table; where the search for the column starts */
    float v;
};
void environment_draw_row(const struct environment_table *table, const float u[2],
                          struct environment_draw *draw);
void environment_draw_start(const struct environment_table *table, struct environment_draw *draw);
struct vec3 environment_draw_column(const struct environment_table *table, const float u[2],
                                    const struct environment_draw *draw,
                                    struct environment_place *place, float *pdf);

#endif
