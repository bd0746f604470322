/* SPDX-License-Identifier: Apache-2.0 */
/* A triangle mesh's memory, and its smooth normals. */

#include "guide/scene/mesh_data.h"

#include <stdlib.h>

#include "guide/scene/team.h"
#include "guide/vec.h"

#define NORMAL_BLOCK ((size_t)1 << 16) /* triangles */

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

/* What a triangle adds to the normals of its corners; zeros where it has no area. */
static void weigh_normal(const struct mesh_data *mesh, size_t t, struct vec3 out[3]) {
    const uint32_t *index = mesh->indices + 3 * t;
    struct vec3 p[3];
    for (int i = 0; i < 3; i++)
        p[i] = load(mesh->positions, index[i]);
    struct vec3 n = normalize(cross(sub(p[1], p[0]), sub(p[2], p[0])));
    bool has_area = dot(n, n) > 0.5f;
    for (int i = 0; i < 3; i++) {
        struct vec3 a = normalize(sub(p[(i + 1) % 3], p[i]));
        struct vec3 b = normalize(sub(p[(i + 2) % 3], p[i]));
        out[i] = has_area ? scale(n, unit_angle(a, b)) : vec(0, 0, 0);
    }
}

/* Blocks of triangles are weighed by all threads, then added by one in the triangles' order, so
 * that every sum is rounded alike. */
static void add_normals(const struct mesh_data *mesh, struct vec3 *block, float *normals) {
    for (size_t begin = 0; begin < mesh->triangle_count; begin += NORMAL_BLOCK) {
        size_t end = begin + NORMAL_BLOCK < mesh->triangle_count ? begin + NORMAL_BLOCK
                                                                 : mesh->triangle_count;
#pragma omp taskloop num_tasks(team_tasks()) if (team_pays(end - begin))
        for (size_t t = begin; t < end; t++)
            weigh_normal(mesh, t, block + 3 * (t - begin));
        for (size_t i = 3 * begin; i < 3 * end; i++)
            store(normals, mesh->indices[i],
                  add(load(normals, mesh->indices[i]), block[i - 3 * begin]));
    }
}

float *mesh_smooth_normals(const struct mesh_data *mesh) {
    size_t most = mesh->triangle_count < NORMAL_BLOCK ? mesh->triangle_count : NORMAL_BLOCK;
    struct vec3 *block = malloc((3 * most + 1) * sizeof(*block));
    float *normals = calloc((size_t)mesh->vertex_count + 1, 3 * sizeof(float));
    if (!block || !normals) {
        free(block);
        free(normals);
        return NULL;
    }
    add_normals(mesh, block, normals);
    free(block);
#pragma omp taskloop num_tasks(team_tasks()) if (team_pays(mesh->vertex_count))
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        struct vec3 n = normalize(load(normals, i));
        /* A vertex of no triangle with an area is never seen, but must hold a direction. */
        store(normals, i, dot(n, n) > 0.5f ? n : vec(1, 0, 0));
    }
    return normals;
}
