/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_SHAPE_STAGE_H
#define FEWRAY_TESTS_SHAPE_STAGE_H

/* Scenes made ready for rays, for the tests of shapes and instances. */

#include "guide/basis.h"
#include "guide/trace/surface.h"
#include "scene_scratch.h"

#define COUNT(array) (sizeof(array) / sizeof(*(array)))

static inline struct fewray_world *make_world(const struct fewray_scene *scene) {
    struct fewray_world *world = NULL;
    struct fewray_error error = {0};
    if (fewray_world_create(scene, 1, &world, &error))
        fail_msg("%s", error.what);
    return world;
}

/* A scene with its world; every material gets tangents. */
struct stage {
    struct fewray_scene *scene;
    struct fewray_world *world;
};

static inline struct stage stage_open(const char *body) {
    struct stage stage = {scratch_scene(body), NULL};
    for (int i = 0; i < stage.scene->bsdf_count; i++)
        stage.scene->bsdfs[i].tangents = true;
    stage.world = make_world(stage.scene);
    return stage;
}

static inline void stage_close(struct stage *stage) {
    fewray_world_destroy(&stage->world);
    fewray_scene_destroy(&stage->scene);
}

/* Of the scene's file in its world: see recentre.h. */
static inline struct vec3 scene_origin(const struct fewray_scene *scene) {
    return vec(scene->origin[0], scene->origin[1], scene->origin[2]);
}

static inline void assert_close(const char *what, struct vec3 a, const float *b, float tolerance) {
    float off = length(sub(a, vec(b[0], b[1], b[2])));
    if (!(off <= tolerance))
        fail_msg("%s is (%g %g %g), expected (%g %g %g)", what, a.x, a.y, a.z, b[0], b[1], b[2]);
}

/* Even in [0, 1). */
static inline float uniform(void) {
    static uint32_t state = 1;
    state = state * 1664525u + 1013904223u;
    return (float)(state >> 8) * (1.0f / 16777216);
}

static inline struct vec3 any_direction(void) {
    float u[2] = {uniform(), uniform()};
    return uniform_sphere(u);
}

#endif
