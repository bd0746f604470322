/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_LIGHTS_H
#define FEWRAY_GUIDE_LIGHTS_H

/* Next-event estimation: one light within the scene, picked by its power or, where there are many,
 * by a tree, or one from infinitely far away. */

#include "guide/light/environment.h"
#include "guide/light/light_tree.h"
#include "guide/scene/scene.h"

struct fewray_world;
struct surface;

enum source_kind { SOURCE_TRIANGLE, SOURCE_SPHERE, SOURCE_POINT, SOURCE_SPOT };

/* A light within the scene. */
struct light_source {
    enum source_kind kind;
    uint32_t index;    /* of the mesh, or of the scene's light */
    uint32_t triangle; /* of the mesh */
    float chance;      /* of picking it, among all lights; with a tree: of picking the tree */
    float pdf_area;    /* of a point on it, uniform over its area; without the pick */
};

enum distant_kind { DISTANT_ENVIRONMENT, DISTANT_DIRECTIONAL, DISTANT_SUN };

/* A light from infinitely far away. */
struct distant_light {
    enum distant_kind kind;
    struct vec3 direction; /* unit, towards the light; of the environment: unused */
    struct vec3 radiance;  /* sun; directional: irradiance across the direction */
    float cone;            /* sun: 1 - the cosine of its half angle */
    float chance;          /* of picking it, among all lights */
};

struct lights {
    size_t source_count;
    struct light_source *sources;
    float *cdf;             /* (source_count + 1); without a tree */
    struct light_tree tree; /* of many sources; else it has no nodes */
    float source_chance;    /* of picking a source, not a distant light */
    uint32_t *first_source; /* (mesh_count): of a mesh's first triangle, UINT32_MAX: none */
    bool has_sky;           /* a ray that leaves the scene meets the environment, or a sun's sky */
    int distant_count;
    struct distant_light *distant; /* the environment first, if there is one */
    float *distant_cdf;            /* (distant_count + 1) */
};

/* A point that may light a surface. */
struct light_sample {
    struct vec3 direction; /* unit, towards the light */
    struct vec3 position;  /* on the light; unused where distant */
    bool distant;          /* infinitely far away: the environment, the sun, a directional light */
    bool delta;            /* from a point or one direction: no ray can hit it by chance */
    struct vec3
        radiance; /* that it sends here if nothing is between; of the environment: not filled */
    float pdf;    /* solid angle, the pick included (delta: the pick's chance alone); 0: no light
                     arrives */
};

/* radius: of a sphere around all surfaces, over which the power of distant lights is measured. */
int lights_create(const struct fewray_scene *scene, const struct environment_table *environment,
                  double radius, struct lights *lights, struct fewray_error *error);
void lights_clear(struct lights *lights);

/* A light for the surface point `from`. normal: its unit shading normal where light from below is
 * of no use, else zero; a light tree prefers lights above it. */
struct light_sample lights_sample(const struct fewray_world *world, struct vec3 from,
                                  struct vec3 normal, float pick, const float u[2]);
/* Density (solid angle) with which lights_sample() would have drawn this hit of a ray from `from`,
 * with the same normal. */
float lights_pdf_hit(const struct fewray_world *world, struct vec3 from, struct vec3 normal,
                     struct vec3 direction, const struct surface *hit);
/* Likewise of a ray along the unit direction that leaves the scene: by the environment and the
 * suns. */
float lights_pdf_sky(const struct fewray_world *world, struct vec3 direction);
/* Radiance that a ray along the unit direction meets where it leaves the scene: the environment and
 * the sun. */
struct vec3 lights_sky(const struct fewray_world *world, struct vec3 direction);
/* Both at once; *pdf is that of lights_pdf_sky(). */
struct vec3 lights_sky_and_pdf(const struct fewray_world *world, struct vec3 direction, float *pdf);
/* Radiance that a hit surface emits against the ray. */
struct vec3 lights_emitted(const struct fewray_world *world, const struct surface *hit,
                           struct vec3 direction);

#endif
