/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_LIGHT_STAGE_H
#define FEWRAY_TESTS_LIGHT_STAGE_H

/* Small scenes of lights, without an acceleration structure, and the irradiance by their samples.
 */

#include "tests/unit/check.h"

#include <string.h>

#include "guide/basis.h"
#include "guide/trace/sampler.h"
#include "guide/trace/surface.h"

enum { MESHES = 3, LIGHTS = 2, SAMPLES = 1 << 14 };

/* A scene and what lights_sample() reads of its world. */
struct stage {
    struct fewray_scene scene;
    struct fewray_world world;
    struct mesh meshes[MESHES];
    struct light lights[LIGHTS];
    struct texture textures[MESHES];
};

static const struct vec3 origin = {0, 0, 0}, up = {0, 0, 1}, radiance = {2, 3, 5};

static inline float uniform(uint32_t stream, uint32_t i) {
    return to_unit_float(hash_combine(stream, i));
}

static inline void stage_start(struct stage *s) {
    memset(s, 0, sizeof(*s));
    s->scene.meshes = s->meshes;
    s->scene.lights = s->lights;
    s->scene.textures = s->textures;
    s->world.scene = &s->scene;
}

static inline void stage_ready(struct stage *s) {
    struct environment_table *e = &s->world.environment;
    assert_int_equal(environment_table_create(&s->scene.environment, e, NULL), 0);
    assert_int_equal(lights_create(&s->scene, e, 1, &s->world.lights, NULL), 0);
}

static inline void stage_end(struct stage *s) {
    lights_clear(&s->world.lights);
    environment_table_clear(&s->world.environment);
}

static inline struct mesh *add_mesh(struct stage *s) {
    int m = s->scene.mesh_count++;
    s->textures[m] = (struct texture){.color0 = radiance, .to_uv = {1, 0, 0, 0, 1, 0}};
    s->scene.texture_count++;
    s->meshes[m] = (struct mesh){.group = -1, .emission = m};
    return &s->meshes[m];
}

static inline void add_sphere(struct stage *s, float x, float y, float z, float radius) {
    struct mesh *mesh = add_mesh(s);
    static const float axes[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    mesh->kind = MESH_SPHERE;
    mesh->sphere[0] = x;
    mesh->sphere[1] = y;
    mesh->sphere[2] = z;
    mesh->sphere[3] = radius;
    memcpy(mesh->sphere_axes, axes, sizeof(axes));
}

static uint32_t triangle_indices[] = {0, 1, 2, 0, 2, 3};

static inline void add_triangles(struct stage *s, float *positions, float *uvs,
                                 uint32_t triangles) {
    struct mesh *mesh = add_mesh(s);
    mesh->positions = positions;
    mesh->uvs = uvs;
    mesh->indices = triangle_indices;
    mesh->vertex_count = triangles + 2;
    mesh->triangle_count = triangles;
}

static inline struct light_sample draw(const struct stage *s, struct vec3 from, struct vec3 normal,
                                       uint32_t stream, uint32_t i) {
    float u[2] = {uniform(stream, 3 * i), uniform(stream, 3 * i + 1)};
    struct light_sample l = lights_sample(&s->world, from, normal, uniform(stream, 3 * i + 2), u);
    if (l.pdf > 0 && l.distant && !l.delta)
        l.radiance = lights_sky(&s->world, l.direction);
    return l;
}

/* Irradiance of a surface at `from` by the mean over the samples, nothing in between. */
static inline struct vec3 irradiance(const struct stage *s, struct vec3 from, struct vec3 normal) {
    double sum[3] = {0, 0, 0};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        struct light_sample l = draw(s, from, normal, 1, i);
        if (!(l.pdf > 0))
            continue;
        assert_near(length(l.direction), 1, 1e-5);
        assert_true(isfinite(l.pdf));
        float cosine = fmaxf(0, dot(normal, l.direction));
        sum[0] += l.radiance.x * cosine / l.pdf;
        sum[1] += l.radiance.y * cosine / l.pdf;
        sum[2] += l.radiance.z * cosine / l.pdf;
    }
    return scale(vec((float)sum[0], (float)sum[1], (float)sum[2]), 1.0f / SAMPLES);
}

static inline void assert_irradiance(const struct stage *s, struct vec3 from, struct vec3 normal,
                                     double factor, double tolerance) {
    struct vec3 e = irradiance(s, from, normal);
    assert_near(e.x, radiance.x * factor, tolerance * factor * radiance.x);
    assert_near(e.y, radiance.y * factor, tolerance * factor * radiance.y);
    assert_near(e.z, radiance.z * factor, tolerance * factor * radiance.z);
}

#endif
