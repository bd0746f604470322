/* SPDX-License-Identifier: Apache-2.0 */
/* Rectangle, disk, cube, cylinder and sphere as triangle meshes, with Mitsuba's uv and normals. */

#include <string.h>

#include "guide/scene/mesh_data.h"
#include "guide/vec.h"

#define DISK_SEGMENTS   512
#define TUBE_SEGMENTS   512
#define SPHERE_SEGMENTS 128 /* around the z axis */
#define SPHERE_RINGS    64  /* from pole to pole */

static void set_vertex(struct mesh_data *mesh, int index, struct vec3 p, struct vec3 n, float u,
                       float v) {
    const float position[3] = {p.x, p.y, p.z}, normal[3] = {n.x, n.y, n.z}, uv[2] = {u, v};
    memcpy(mesh->positions + 3 * index, position, sizeof(position));
    memcpy(mesh->normals + 3 * index, normal, sizeof(normal));
    memcpy(mesh->uvs + 2 * index, uv, sizeof(uv));
}

static void set_triangle(struct mesh_data *mesh, int index, int a, int b, int c) {
    const uint32_t corners[3] = {(uint32_t)a, (uint32_t)b, (uint32_t)c};
    memcpy(mesh->indices + 3 * index, corners, sizeof(corners));
}

bool mesh_make_rectangle(struct mesh_data *out) {
    if (!mesh_data_allocate(out, 4, 2, true, true))
        return false;
    for (int i = 0; i < 4; i++) {
        float u = i == 1 || i == 2, v = i >= 2;
        set_vertex(out, i, vec(2 * u - 1, 2 * v - 1, 0), vec(0, 0, 1), u, v);
    }
    set_triangle(out, 0, 0, 1, 2);
    set_triangle(out, 1, 2, 3, 0);
    return true;
}

/* uv are polar: (radius, angle / 2 pi). The centre is doubled for each segment, since its angle
 * differs. */
bool mesh_make_disk(struct mesh_data *out) {
    const int rim = DISK_SEGMENTS + 1;
    const struct vec3 up = vec(0, 0, 1);
    if (!mesh_data_allocate(out, DISK_SEGMENTS + (size_t)rim, DISK_SEGMENTS, true, true))
        return false;
    for (int i = 0; i < rim; i++) {
        double turn = (double)i / DISK_SEGMENTS, angle = 2 * 3.14159265358979323846 * turn;
        bool closed = i == DISK_SEGMENTS;
        struct vec3 p = closed ? vec(1, 0, 0) : vec((float)cos(angle), (float)sin(angle), 0);
        set_vertex(out, i, p, up, 1, (float)turn);
    }
    for (int i = 0; i < DISK_SEGMENTS; i++) {
        set_vertex(out, rim + i, vec(0, 0, 0), up, 0, ((float)i + 0.5f) / DISK_SEGMENTS);
        set_triangle(out, i, rim + i, i, i + 1);
    }
    return true;
}

/* Each face starts at the corner of uv (0, 1) and goes on over (1, 1), (1, 0) and (0, 0),
 * anticlockwise from outside. */
bool mesh_make_cube(struct mesh_data *out) {
    static const signed char corners[6][4][3] = {
        {{1, -1, -1}, {1, -1, 1}, {-1, -1, 1}, {-1, -1, -1}},
        {{1, 1, -1}, {-1, 1, -1}, {-1, 1, 1}, {1, 1, 1}},
        {{1, -1, -1}, {1, 1, -1}, {1, 1, 1}, {1, -1, 1}},
        {{1, -1, 1}, {1, 1, 1}, {-1, 1, 1}, {-1, -1, 1}},
        {{-1, -1, 1}, {-1, 1, 1}, {-1, 1, -1}, {-1, -1, -1}},
        {{1, 1, -1}, {1, -1, -1}, {-1, -1, -1}, {-1, 1, -1}},
    };
    static const signed char normals[6][3] = {{0, -1, 0}, {0, 1, 0},  {1, 0, 0},
                                              {0, 0, 1},  {-1, 0, 0}, {0, 0, -1}};
    if (!mesh_data_allocate(out, 24, 12, true, true))
        return false;
    for (int f = 0; f < 6; f++) {
        const signed char *n = normals[f];
        for (int i = 0; i < 4; i++) {
            const signed char *p = corners[f][i];
            set_vertex(out, 4 * f + i, vec(p[0], p[1], p[2]), vec(n[0], n[1], n[2]),
                       i == 1 || i == 2, i < 2);
        }
        set_triangle(out, 2 * f, 4 * f, 4 * f + 1, 4 * f + 2);
        set_triangle(out, 2 * f + 1, 4 * f + 3, 4 * f, 4 * f + 2);
    }
    return true;
}

/* uv are (azimuth / 2 pi, angle from +z / pi). The seam and the poles are doubled, since u differs
 * there. */
bool mesh_make_sphere(struct mesh_data *out) {
    const int columns = SPHERE_SEGMENTS + 1;
    if (!mesh_data_allocate(out, (size_t)columns * (SPHERE_RINGS + 1),
                            2 * SPHERE_SEGMENTS * (SPHERE_RINGS - 1), true, true))
        return false;
    for (int i = 0; i <= SPHERE_RINGS; i++) {
        double theta = 3.14159265358979323846 * i / SPHERE_RINGS;
        double z = cos(theta), radius = i % SPHERE_RINGS ? sin(theta) : 0;
        bool pole = i % SPHERE_RINGS == 0;
        for (int j = 0; j < columns; j++) {
            double turn = (double)(j % SPHERE_SEGMENTS) / SPHERE_SEGMENTS;
            double phi = 2 * 3.14159265358979323846 * turn;
            struct vec3 p = vec((float)(radius * cos(phi)), (float)(radius * sin(phi)), (float)z);
            float u = ((float)j + (pole ? 0.5f : 0)) / SPHERE_SEGMENTS;
            set_vertex(out, i * columns + j, p, p, u, (float)i / SPHERE_RINGS);
        }
    }
    int t = 0;
    for (int i = 0; i < SPHERE_RINGS; i++)
        for (int j = 0; j < SPHERE_SEGMENTS; j++) {
            int a = i * columns + j, b = a + columns;
            if (i > 0)
                set_triangle(out, t++, a, b, a + 1);
            if (i < SPHERE_RINGS - 1)
                set_triangle(out, t++, a + 1, b, b + 1);
        }
    return true;
}

/* uv are (azimuth / 2 pi, z). The seam is doubled, since u differs there. */
bool mesh_make_cylinder(struct mesh_data *out) {
    if (!mesh_data_allocate(out, 2 * (TUBE_SEGMENTS + 1), 2 * TUBE_SEGMENTS, true, true))
        return false;
    for (int i = 0; i <= TUBE_SEGMENTS; i++) {
        double phi = 2 * 3.14159265358979323846 * (i % TUBE_SEGMENTS) / TUBE_SEGMENTS;
        struct vec3 n = vec((float)cos(phi), (float)sin(phi), 0);
        for (int j = 0; j < 2; j++)
            set_vertex(out, 2 * i + j, vec(n.x, n.y, (float)j), n, (float)i / TUBE_SEGMENTS,
                       (float)j);
    }
    for (int i = 0; i < TUBE_SEGMENTS; i++) {
        set_triangle(out, 2 * i, 2 * i, 2 * i + 2, 2 * i + 3);
        set_triangle(out, 2 * i + 1, 2 * i, 2 * i + 3, 2 * i + 1);
    }
    return true;
}
