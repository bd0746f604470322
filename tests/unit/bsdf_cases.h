/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_BSDF_CASES_H
#define FEWRAY_TESTS_BSDF_CASES_H

/* The materials of tests/data/mitsuba/bsdf.json, loaded as one scene of a rectangle each; see
 * tests/mitsuba/generate_bsdf_table.py. */

#include "tests/unit/mitsuba_table.h"

#include "guide/bsdf/bsdf.h"

static struct {
    struct mitsuba_table table;
    json_t *points;
    struct fewray_scene *scene;
    struct fewray_world *world;
    struct basis frame; /* of the surface, askew in the world */
} cases;

/* A material a line, so that an error's line tells which. */
static inline int cases_create(void **state) {
    (void)state;
    table_open(&cases.table, TEST_DATA "/mitsuba/bsdf.json");
    cases.points = json_object_get(cases.table.root, "points");
    FILE *file = table_begin_scene(&cases.table);
    json_t *entry;
    for (size_t i = 0; (entry = json_array_get(cases.table.configurations, i)); i++)
        fprintf(file, "<shape type='rectangle' id='%s'>%s</shape>\n", case_name(entry),
                table_string(entry, "xml"));
    fprintf(file, "<emitter type='constant'/>\n");
    table_end_scene(&cases.table, file, &cases.scene, &cases.world);
    struct vec3 n = normalize(vec(0.3f, -0.5f, 0.8f));
    struct vec3 s = normalize(cross(vec(0.2f, 1, 0.1f), n));
    cases.frame = (struct basis){s, cross(n, s), n};
    return 0;
}

static inline int cases_destroy(void **state) {
    (void)state;
    fewray_world_destroy(&cases.world);
    fewray_scene_destroy(&cases.scene);
    table_close(&cases.table);
    return 0;
}

/* A point of the case's rectangle. */
static inline struct surface case_surface(const json_t *entry, float u, float v) {
    struct surface surface = {.u = u, .v = v};
    for (int m = 0; m < cases.scene->mesh_count; m++)
        if (!strcmp(cases.scene->meshes[m].id, case_name(entry))) {
            surface.mesh = &cases.scene->meshes[m];
            surface.mesh_index = (uint32_t)m;
        }
    assert_non_null(surface.mesh);
    surface.normal = surface.geometric_normal = cases.frame.n;
    struct vec3 du = table_vector(json_object_get(cases.table.root, "dp_du"), 0);
    struct vec3 dv = table_vector(json_object_get(cases.table.root, "dp_dv"), 0);
    surface.dp_du = to_world(&cases.frame, du);
    surface.dp_dv = to_world(&cases.frame, dv);
    return surface;
}

/* The material as seen from a local direction. */
static inline struct shading case_shading(const json_t *entry, struct vec3 outgoing, float u,
                                          float v) {
    struct surface surface = case_surface(entry, u, v);
    struct shading shading;
    bsdf_at(cases.world, &surface, to_world(&cases.frame, outgoing), &shading);
    return shading;
}

static inline struct vec3 case_local(struct vec3 v) {
    return vec(dot(v, cases.frame.s), dot(v, cases.frame.t), dot(v, cases.frame.n));
}

#endif
