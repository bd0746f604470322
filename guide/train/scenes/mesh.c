/* SPDX-License-Identifier: Apache-2.0 */
/* A mesh's containers, rays against it, and its file. */

#include "guide/train/scenes/mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

struct mesh *mesh_create(bool smooth) {
    struct mesh *mesh = calloc(1, sizeof *mesh);
    if (mesh)
        mesh->smooth = smooth;
    return mesh;
}

void mesh_destroy(struct mesh **mesh) {
    if (!*mesh)
        return;
    free((*mesh)->positions);
    free((*mesh)->uvs);
    free((*mesh)->triangles);
    free(*mesh);
    *mesh = NULL;
}

int mesh_vertex(struct mesh *mesh, struct vec3 position, float u, float v) {
    if (mesh->vertex_count == mesh->vertex_capacity) {
        int wanted = mesh->vertex_capacity ? 2 * mesh->vertex_capacity : 256;
        struct vec3 *positions = realloc(mesh->positions, (size_t)wanted * sizeof *positions);
        if (positions)
            mesh->positions = positions;
        float(*uvs)[2] = realloc(mesh->uvs, (size_t)wanted * sizeof *uvs);
        if (uvs)
            mesh->uvs = uvs;
        if (!positions || !uvs) {
            mesh->failed = true;
            return 0;
        }
        mesh->vertex_capacity = wanted;
    }
    mesh->positions[mesh->vertex_count] = position;
    mesh->uvs[mesh->vertex_count][0] = u;
    mesh->uvs[mesh->vertex_count][1] = v;
    return mesh->vertex_count++;
}

void mesh_triangle(struct mesh *mesh, int a, int b, int c) {
    if (mesh->failed)
        return;
    if (mesh->triangle_count == mesh->triangle_capacity) {
        int wanted = mesh->triangle_capacity ? 2 * mesh->triangle_capacity : 256;
        int(*triangles)[3] = realloc(mesh->triangles, (size_t)wanted * sizeof *triangles);
        if (!triangles) {
            mesh->failed = true;
            return;
        }
        mesh->triangles = triangles;
        mesh->triangle_capacity = wanted;
    }
    int *corners = mesh->triangles[mesh->triangle_count++];
    corners[0] = a, corners[1] = b, corners[2] = c;
}

float mesh_bounds(const struct mesh *mesh, struct vec3 *center) {
    struct vec3 low = vec(1e30f, 1e30f, 1e30f), high = negate(low);
    for (int i = 0; i < mesh->vertex_count; i++) {
        struct vec3 p = mesh->positions[i];
        low = vec(fminf(low.x, p.x), fminf(low.y, p.y), fminf(low.z, p.z));
        high = vec(fmaxf(high.x, p.x), fmaxf(high.y, p.y), fmaxf(high.z, p.z));
    }
    *center = scale(add(low, high), 0.5f);
    return length(sub(high, low)) / 2;
}

/* Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997. */
static float triangle_hit(const struct vec3 *p, struct vec3 origin, struct vec3 dir) {
    struct vec3 a = sub(p[1], p[0]), b = sub(p[2], p[0]), h = cross(dir, b);
    float determinant = dot(a, h);
    if (determinant == 0)
        return -1;
    struct vec3 s = sub(origin, p[0]), q = cross(s, a);
    float u = dot(s, h) / determinant, v = dot(dir, q) / determinant;
    return u >= 0 && v >= 0 && u + v <= 1 ? dot(b, q) / determinant : -1;
}

float mesh_hit(const struct mesh *mesh, struct vec3 origin, struct vec3 dir, float least,
               struct vec3 *normal) {
    float nearest = -1;
    for (int i = 0; i < mesh->triangle_count; i++) {
        const int *corners = mesh->triangles[i];
        struct vec3 p[3];
        for (int c = 0; c < 3; c++)
            p[c] = mesh->positions[corners[c]];
        float t = triangle_hit(p, origin, dir);
        if (t > least && (nearest < 0 || t < nearest)) {
            nearest = t;
            *normal = cross(sub(p[1], p[0]), sub(p[2], p[0]));
        }
    }
    return nearest;
}

int mesh_write(const struct mesh *mesh, const char *path, struct fewray_error *error) {
    FILE *file = fopen(path, "w");
    if (!file)
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't be written");
    for (int i = 0; i < mesh->vertex_count; i++) {
        struct vec3 p = mesh->positions[i];
        fprintf(file, "v %.6g %.6g %.6g\n", (double)p.x, (double)p.y, (double)p.z);
    }
    for (int i = 0; i < mesh->vertex_count; i++)
        fprintf(file, "vt %.5g %.5g\n", (double)mesh->uvs[i][0], (double)mesh->uvs[i][1]);
    for (int i = 0; i < mesh->triangle_count; i++) {
        const int *t = mesh->triangles[i];
        fprintf(file, "f %d/%d %d/%d %d/%d\n", t[0] + 1, t[0] + 1, t[1] + 1, t[1] + 1, t[2] + 1,
                t[2] + 1);
    }
    bool bad = ferror(file) != 0;
    bad |= fclose(file) != 0;
    return bad ? fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't be written: is the disk full?")
               : FEWRAY_OK;
}
