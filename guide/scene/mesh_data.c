/* SPDX-License-Identifier: Apache-2.0 */
/* A triangle mesh's memory, and its smooth normals. */

#include "guide/scene/mesh_data.h"

#include <stdlib.h>

#include "guide/vec.h"

bool mesh_data_allocate(struct mesh_data *mesh, size_t vertices, size_t triangles, bool normals,
                        bool uvs) {
    *mesh = (struct mesh_data){.vertex_count = (uint32_t)vertices,
                               .triangle_count = (uint32_t)triangles};
    mesh->positions = calloc(vertices + 1, 3 * sizeof(float));
    mesh->indices = calloc(triangles + 1, 3 * sizeof(uint32_t));
    if (normals)
        mesh->normals = calloc(vertices + 1, 3 * sizeof(float));
    if (uvs)
        mesh->uvs = calloc(vertices + 1, 2 * sizeof(float));
    return mesh->positions && mesh->indices && (!normals || mesh->normals) && (!uvs || mesh->uvs);
}

void mesh_data_free(struct mesh_data *mesh) {
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->uvs);
    free(mesh->indices);
    *mesh = (struct mesh_data){0};
}

static struct vec3 load(const float *values, uint32_t index) {
    const float *v = values + 3 * (size_t)index;
    return vec(v[0], v[1], v[2]);
}

static void store(float *values, uint32_t index, struct vec3 v) {
    float *to = values + 3 * (size_t)index;
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
}

/* Angle between unit vectors, well-conditioned near 0 and pi. Kahan, "How Futile are Mindless
 * Assessments of Roundoff", 2006. */
static float unit_angle(struct vec3 a, struct vec3 b) {
    float half_chord = length(sub(a, b)) / 2, half_sum = length(add(a, b)) / 2;
    return 2 * atan2f(half_chord, half_sum);
}

float *mesh_smooth_normals(const struct mesh_data *mesh) {
    float *normals = calloc((size_t)mesh->vertex_count + 1, 3 * sizeof(float));
    if (!normals)
        return NULL;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *index = mesh->indices + 3 * (size_t)t;
        struct vec3 p[3];
        for (int i = 0; i < 3; i++)
            p[i] = load(mesh->positions, index[i]);
        struct vec3 n = normalize(cross(sub(p[1], p[0]), sub(p[2], p[0])));
        if (!(dot(n, n) > 0.5f))
            continue;
        for (int i = 0; i < 3; i++) {
            struct vec3 a = normalize(sub(p[(i + 1) % 3], p[i]));
            struct vec3 b = normalize(sub(p[(i + 2) % 3], p[i]));
            store(normals, index[i], add(load(normals, index[i]), scale(n, unit_angle(a, b))));
        }
    }
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        struct vec3 n = normalize(load(normals, i));
        /* A vertex of no triangle with an area is never seen, but must hold a direction. */
        store(normals, i, dot(n, n) > 0.5f ? n : vec(1, 0, 0));
    }
    return normals;
}
