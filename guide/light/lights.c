/* SPDX-License-Identifier: Apache-2.0 */
/* Picking and sampling of lights, and the densities of what is drawn. */

#include "guide/light/lights.h"

#include "guide/basis.h"
#include "guide/light/distribution.h"
#include "guide/light/light_source.h"
#include "guide/trace/surface.h"
#include "guide/trace/texture.h"

/* Whether a unit direction lies in a cone around a unit axis; cone = 1 - cos of its half angle.
 * By the squared chord, which narrow cones need. */
static bool in_cone(struct vec3 direction, struct vec3 axis, float cone) {
    struct vec3 chord = sub(direction, axis);
    return dot(chord, chord) <= 2 * cone;
}

static struct vec3 sample_cone(struct vec3 axis, float cone, const float u[2]) {
    struct basis basis = basis_around(axis);
    return normalize(to_world(&basis, uniform_cone(cone, u)));
}

static float sky_pdf(const struct fewray_world *world, const struct environment_place *place,
                     struct vec3 direction) {
    const struct lights *lights = &world->lights;
    float pdf = 0;
    for (int i = 0; i < lights->distant_count; i++) {
        const struct distant_light *d = &lights->distant[i];
        if (d->kind == DISTANT_ENVIRONMENT)
            pdf += environment_pdf_at(&world->environment, place) * d->chance;
        else if (d->kind == DISTANT_SUN && d->chance > 0 &&
                 in_cone(direction, d->direction, d->cone))
            pdf += d->chance / (2 * PI_F * d->cone);
    }
    return pdf;
}

float lights_pdf_sky(const struct fewray_world *world, struct vec3 direction) {
    struct environment_place place = environment_find(&world->scene->environment, direction);
    return sky_pdf(world, &place, direction);
}

static struct light_sample sample_distant(const struct fewray_world *world, float pick,
                                          const float u[2]) {
    const struct lights *lights = &world->lights;
    struct light_sample s = {.distant = true};
    if (lights->distant_count == 0)
        return s;
    const struct distant_light *d =
        &lights->distant[cdf_sample(lights->distant_cdf, (size_t)lights->distant_count, &pick)];
    if (d->kind == DISTANT_ENVIRONMENT) {
        s.direction = environment_sample(&world->environment, u, &s.pdf);
        s.pdf *= d->chance;
        if (lights->distant_count > 1 && s.pdf > 0)
            s.pdf = lights_pdf_sky(world, s.direction);
    } else if (d->kind == DISTANT_SUN) {
        s.direction = sample_cone(d->direction, d->cone, u);
        s.pdf = lights_pdf_sky(world, s.direction);
    } else {
        s.direction = d->direction;
        s.radiance = d->radiance;
        s.delta = true;
        s.pdf = d->chance;
    }
    return s;
}

struct light_sample lights_sample(const struct fewray_world *world, struct vec3 from,
                                  struct vec3 normal, float pick, const float u[2]) {
    const struct lights *lights = &world->lights;
    float near = lights->source_chance;
    if (!(pick < near))
        return sample_distant(world, fminf((pick - near) / (1 - near), 0x1.fffffep-1f), u);
    pick = fminf(pick / near, 0x1.fffffep-1f);
    uint32_t i;
    float chance = 1;
    if (lights->tree.node_count > 0)
        chance = light_tree_pick(&lights->tree, from, normal, pick, &i);
    else
        i = (uint32_t)cdf_sample(lights->cdf, lights->source_count, &pick);
    if (!(chance > 0))
        return (struct light_sample){.pdf = 0};
    const struct light_source *source = &lights->sources[i];
    struct light_sample s = source_sample(world->scene, source, from, u);
    s.pdf *= source->chance * chance;
    return s;
}

float lights_pdf_hit(const struct fewray_world *world, struct vec3 from, struct vec3 normal,
                     struct vec3 direction, const struct surface *hit) {
    const struct lights *lights = &world->lights;
    uint32_t i = lights->first_source[hit->mesh_index];
    if (i == UINT32_MAX)
        return 0;
    if (hit->mesh->kind == MESH_TRIANGLES)
        i += hit->triangle;
    const struct light_source *source = &lights->sources[i];
    float chance = source->chance;
    if (lights->tree.node_count > 0)
        chance *= light_tree_chance(&lights->tree, from, normal, i);
    return chance > 0 ? chance * source_pdf(source, from, direction, hit) : 0;
}

/* place: of the direction on the environment's map. */
static struct vec3 sky_radiance(const struct fewray_world *world,
                                const struct environment_place *place, struct vec3 direction) {
    const struct lights *lights = &world->lights;
    struct vec3 radiance = environment_radiance_at(&world->scene->environment, place);
    for (int i = 0; i < lights->distant_count; i++) {
        const struct distant_light *d = &lights->distant[i];
        if (d->kind == DISTANT_SUN && in_cone(direction, d->direction, d->cone))
            radiance = add(radiance, d->radiance);
    }
    return radiance;
}

struct vec3 lights_sky(const struct fewray_world *world, struct vec3 direction) {
    struct environment_place place = environment_find(&world->scene->environment, direction);
    return sky_radiance(world, &place, direction);
}

struct vec3 lights_sky_and_pdf(const struct fewray_world *world, struct vec3 direction,
                               float *pdf) {
    struct environment_place place = environment_find(&world->scene->environment, direction);
    *pdf = sky_pdf(world, &place, direction);
    return sky_radiance(world, &place, direction);
}

struct vec3 lights_emitted(const struct fewray_world *world, const struct surface *hit,
                           struct vec3 direction) {
    if (hit->mesh->emission < 0 || dot(hit->normal, direction) >= 0)
        return vec(0, 0, 0);
    return texture_value(&world->scene->textures[hit->mesh->emission], hit->u, hit->v);
}
