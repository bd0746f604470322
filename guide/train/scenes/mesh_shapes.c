/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes of bodies of revolution, foliage and grass. */

#include "guide/train/scenes/mesh.h"

/* Rings of vertices share nothing with each other but triangles; the seam has its own column, and
 * each pole a vertex a column, so that uv and smooth normals are right everywhere. */
struct mesh *mesh_revolution(const float (*profile)[2], int count, int sides) {
    struct mesh *mesh = mesh_create(true);
    if (!mesh)
        return NULL;
    int columns = sides + 1;
    for (int i = 0; i < count; i++)
        for (int s = 0; s < columns; s++) {
            float u = (float)s / (float)sides, angle = 2 * PI_F * (float)(s % sides) / (float)sides;
            struct vec3 p =
                vec(profile[i][0] * cosf(angle), profile[i][1], profile[i][0] * sinf(angle));
            mesh_vertex(mesh, p, u, (float)i / (float)(count - 1));
        }
    for (int i = 0; i + 1 < count; i++)
        for (int s = 0; s < sides; s++) {
            int a = i * columns + s, b = a + 1, c = a + columns, d = c + 1;
            if (profile[i + 1][0] > 0)
                mesh_triangle(mesh, a, c, d);
            if (profile[i][0] > 0)
                mesh_triangle(mesh, a, d, b);
        }
    if (mesh->failed)
        mesh_destroy(&mesh);
    return mesh;
}

static struct vec3 any_direction(struct random *r) {
    float z = uniform(r, -1, 1), azimuth = uniform(r, 0, 2 * PI_F),
          rho = sqrtf(fmaxf(0, 1 - z * z));
    return vec(rho * cosf(azimuth), z, rho * sinf(azimuth));
}

/* Two triangles that share their middle rib, a little folded. */
static void add_leaf(struct mesh *mesh, struct random *r, struct vec3 root, struct vec3 along,
                     float size) {
    struct vec3 side = normalize(cross(along, any_direction(r))),
                up = cross(side, normalize(along));
    struct vec3 tip = add(root, scale(along, size)), middle = add(root, scale(along, size * 0.45f));
    float wide = size * uniform(r, 0.12f, 0.3f), fold = wide * uniform(r, 0, 0.6f);
    struct vec3 lift = scale(up, fold);
    int a = mesh_vertex(mesh, root, 0.5f, 0), b = mesh_vertex(mesh, tip, 0.5f, 1);
    int c = mesh_vertex(mesh, add(middle, add(scale(side, wide), lift)), 1, 0.45f);
    int d = mesh_vertex(mesh, add(middle, add(scale(side, -wide), lift)), 0, 0.45f);
    mesh_triangle(mesh, a, c, b);
    mesh_triangle(mesh, a, b, d);
}

struct mesh *mesh_foliage(struct random *r, int leaves, float height, float spread, float leaf) {
    struct mesh *mesh = mesh_create(false);
    if (!mesh)
        return NULL;
    for (int i = 0; i < leaves; i++) {
        struct vec3 out = any_direction(r), at = scale(out, spread * cbrtf(uniform(r, 0, 1)));
        at.y = fmaxf(at.y + height, leaf);
        struct vec3 along = normalize(add(out, scale(any_direction(r), 0.9f)));
        add_leaf(mesh, r, at, along, leaf * uniform(r, 0.5f, 1.3f));
    }
    if (mesh->failed)
        mesh_destroy(&mesh);
    return mesh;
}

struct mesh *mesh_grass(struct random *r, int blades, float radius, float height) {
    struct mesh *mesh = mesh_create(false);
    if (!mesh)
        return NULL;
    for (int i = 0; i < blades; i++) {
        float rho = radius * sqrtf(uniform(r, 0, 1)), azimuth = uniform(r, 0, 2 * PI_F),
              turn = uniform(r, 0, 2 * PI_F), tall = height * uniform(r, 0.4f, 1.2f),
              wide = tall * uniform(r, 0.015f, 0.04f);
        struct vec3 root = vec(rho * cosf(azimuth), 0, rho * sinf(azimuth)),
                    side = vec(wide * cosf(turn), 0, wide * sinf(turn));
        struct vec3 bend =
            vec(tall * uniform(r, -0.5f, 0.5f), tall, tall * uniform(r, -0.5f, 0.5f));
        int a = mesh_vertex(mesh, add(root, side), 1, 0),
            b = mesh_vertex(mesh, sub(root, side), 0, 0),
            c = mesh_vertex(mesh, add(root, bend), 0.5f, 1);
        mesh_triangle(mesh, a, b, c);
    }
    if (mesh->failed)
        mesh_destroy(&mesh);
    return mesh;
}
