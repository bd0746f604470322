/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_LIGHTS_H
#define FEWRAY_GUIDE_LIGHTS_H

/* Next-event estimation: one emitting triangle, or the environment, picked by its power. */

#include "guide/scene/scene.h"
#include "guide/trace/environment.h"

struct fewray_world;
struct surface;

struct light_triangle {
    uint32_t mesh, triangle;
    float pdf_area; /* probability of the pick / area: density over the triangle's area */
};

struct lights {
    size_t triangle_count;
    struct light_triangle *triangles;
    float *cdf;               /* (triangle_count + 1 + 1): triangles, then the environment */
    float environment_chance; /* of picking the environment */
    uint32_t *first_triangle; /* (mesh_count): index of a mesh's first emitting triangle, UINT32_MAX
                                 for none */
};

/* A point that may light a surface. */
struct light_sample {
    struct vec3 direction; /* unit, towards the light */
    struct vec3 position;  /* on the light; unused where distant */
    bool distant;          /* the environment */
    struct vec3
        radiance; /* that it sends here if nothing is between; of the environment: not filled */
    float pdf;    /* solid angle, the pick included; 0: no light arrives */
};

int lights_create(const struct fewray_scene *scene, const struct environment_table *environment,
                  struct lights *lights, struct fewray_error *error);
void lights_clear(struct lights *lights);

struct light_sample lights_sample(const struct fewray_world *world, struct vec3 from, float pick,
                                  const float u[2]);
/* Density (solid angle) with which lights_sample() would have drawn this hit of a ray from `from`.
 */
float lights_pdf_hit(const struct fewray_world *world, struct vec3 direction,
                     const struct surface *hit);
float lights_pdf_environment(const struct fewray_world *world, struct vec3 direction);

#endif
