/* SPDX-License-Identifier: Apache-2.0 */
/* lights_sample() for sixteen points: triangles of one colour side by side, the environment in
 * steps that ask for memory ahead of its use, other lights one by one. */

#include "guide/light/distribution.h"
#include "guide/light/light_source.h"
#include "guide/trace/bundle_lanes.h"

/* Sampled points of lights; see struct light_sample. */
struct light_lanes {
    struct vec3_lanes direction, position, radiance;
    float pdf[LANES];
    int distant[LANES], delta[LANES];
    struct environment_place places[LANES]; /* of those that the environment's map drew */
    bool mapped[LANES],
        dark[LANES]; /* mapped: by it; dark: the sky's radiance is still to be read */
} LANES_ALIGNMENT;

/* Triangles that shine alike all over. */
struct triangle_lanes {
    struct vec3_lanes corner, edge1, edge2;
    float pdf[LANES]; /* of a point, per area, with the pick; 0: another kind of light */
} LANES_ALIGNMENT;

/* Fills a lane where the light suits. */
static bool fetch_triangle(const struct fewray_scene *scene, const struct light_source *source,
                           float chance, int i, struct triangle_lanes *t,
                           struct vec3_lanes *radiance) {
    if (source->kind != SOURCE_TRIANGLE)
        return false;
    const struct mesh *mesh = &scene->meshes[source->index];
    const struct texture *texture = &scene->textures[mesh->emission];
    if (mesh->normals || texture->kind != TEXTURE_CONSTANT)
        return false;
    const uint32_t *c = mesh->indices + 3 * (size_t)source->triangle;
    const float *p0 = mesh->positions + 3 * (size_t)c[0], *p1 = mesh->positions + 3 * (size_t)c[1],
                *p2 = mesh->positions + 3 * (size_t)c[2];
    lane_set(&t->corner, i, vec(p0[0], p0[1], p0[2]));
    lane_set(&t->edge1, i, vec(p1[0] - p0[0], p1[1] - p0[1], p1[2] - p0[2]));
    lane_set(&t->edge2, i, vec(p2[0] - p0[0], p2[1] - p0[1], p2[2] - p0[2]));
    t->pdf[i] = source->pdf_area * source->chance * chance;
    lane_set(radiance, i, texture->color0);
    return true;
}

/* As sample_triangle() of light_source.c does it. */
static void sample_triangles(const struct triangle_lanes *t, const struct vec3_lanes *from,
                             float u[2][LANES], struct light_lanes *out) {
    EACH_LANE(i) {
        float root = sqrtf(u[0][i]), b1 = 1 - root, b2 = u[1][i] * root;
        struct vec3 e1 = lane_get(&t->edge1, i), e2 = lane_get(&t->edge2, i);
        struct vec3 q = add(lane_get(&t->corner, i), add(scale(e1, b1), scale(e2, b2)));
        struct vec3 to = sub(q, lane_get(from, i)), facing = cross(e1, e2);
        float distance2 = dot(to, to), area2 = length(facing);
        struct vec3 d = scale(to, distance2 > 0 ? 1 / sqrtf(distance2) : 0);
        float cosine = -dot(facing, d) * (area2 > 0 ? 1 / area2 : 0);
        float pdf = cosine > 0 ? t->pdf[i] * distance2 / cosine : 0;
        bool fits = t->pdf[i] > 0;
        struct vec3 old_d = lane_get(&out->direction, i), old_q = lane_get(&out->position, i);
        lane_set(&out->direction, i,
                 vec(fits ? d.x : old_d.x, fits ? d.y : old_d.y, fits ? d.z : old_d.z));
        lane_set(&out->position, i,
                 vec(fits ? q.x : old_q.x, fits ? q.y : old_q.y, fits ? q.z : old_q.z));
        out->pdf[i] = fits ? pdf : out->pdf[i];
    }
}

static void set_light(struct light_lanes *out, int i, const struct light_sample *s) {
    lane_set(&out->direction, i, s->direction);
    lane_set(&out->position, i, s->position);
    lane_set(&out->radiance, i, s->radiance);
    out->pdf[i] = s->pdf;
    out->distant[i] = s->distant;
    out->delta[i] = s->delta;
    out->dark[i] = s->distant && !s->delta;
    out->mapped[i] = false;
}

/* What each lane's pick falls on: returns whether it is the environment's map; a triangle's lane of
 * t is filled; another light is sampled at once. */
static bool pick_light(const struct fewray_world *world, struct vec3 from, struct vec3 normal,
                       float pick, const float u[2], int i, struct triangle_lanes *t,
                       struct light_lanes *out) {
    const struct lights *lights = &world->lights;
    float near = lights->source_chance, left = pick;
    bool sky = !(pick < near);
    if (sky && lights->distant_count == 1 && lights->distant[0].kind == DISTANT_ENVIRONMENT &&
        world->environment.environment->kind == ENVIRONMENT_MAP)
        return true;
    if (!sky && lights->tree.node_count == 0) {
        left = fminf(left / near, 0x1.fffffep-1f);
        size_t k = cdf_sample(lights->cdf, lights->source_count, &left);
        if (fetch_triangle(world->scene, &lights->sources[k], 1, i, t, &out->radiance))
            return false;
    }
    struct light_sample s = lights_sample(world, from, normal, pick, u);
    set_light(out, i, &s);
    return false;
}

static void sample_environment(const struct fewray_world *world, const bool wanted[LANES],
                               float u[2][LANES], struct light_lanes *out) {
    const struct environment_table *table = &world->environment;
    struct environment_draw draws[LANES];
    for (int i = 0; i < LANES; i++)
        if (wanted[i])
            environment_draw_row(table, (float[2]){u[0][i], u[1][i]}, &draws[i]);
    for (int i = 0; i < LANES; i++)
        if (wanted[i])
            environment_draw_start(table, &draws[i]);
    for (int i = 0; i < LANES; i++) {
        if (!wanted[i])
            continue;
        float pdf;
        lane_set(&out->direction, i,
                 environment_draw_column(table, (float[2]){u[0][i], u[1][i]}, &draws[i],
                                         &out->places[i], &pdf));
        out->pdf[i] = pdf * world->lights.distant[0].chance;
        out->distant[i] = out->mapped[i] = out->dark[i] = true;
    }
}

/* A light for each lane's point `from`; without the radiance of lanes that are dark. */
static void light_lanes_sample(const struct fewray_world *world, const int alive[LANES],
                               const struct vec3_lanes *from, const struct vec3_lanes *normal,
                               const float pick[LANES], float u[2][LANES],
                               struct light_lanes *out) {
    struct triangle_lanes t = {.pdf = {0}};
    bool sky[LANES], any_sky = false;
    for (int i = 0; i < LANES; i++) {
        const float point[2] = {u[0][i], u[1][i]};
        static const struct light_sample nothing = {.pdf = 0};
        set_light(out, i, &nothing);
        sky[i] = alive[i] && pick_light(world, lane_get(from, i), lane_get(normal, i), pick[i],
                                        point, i, &t, out);
        any_sky |= sky[i];
    }
    if (world->lights.source_count > 0)
        sample_triangles(&t, from, u, out);
    if (any_sky)
        sample_environment(world, sky, u, out);
}

/* Reads what the sky sends from directions that are of use. */
static void light_lanes_shine(const struct fewray_world *world, const int wanted[LANES],
                              struct light_lanes *lights) {
    const struct environment *environment = &world->scene->environment;
    for (int i = 0; i < LANES; i++)
        if (wanted[i] && lights->mapped[i])
            environment_prefetch(environment, &lights->places[i]);
    for (int i = 0; i < LANES; i++) {
        if (!wanted[i] || !lights->dark[i])
            continue;
        lane_set(&lights->radiance, i,
                 lights->mapped[i] ? environment_radiance_at(environment, &lights->places[i])
                                   : lights_sky(world, lane_get(&lights->direction, i)));
    }
}
