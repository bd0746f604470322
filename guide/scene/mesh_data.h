/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_MESH_DATA_H
#define FEWRAY_GUIDE_SCENE_MESH_DATA_H

/* A triangle mesh in its own space, as a file or a simple shape gives it, and its makers. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fewray/features.h"

struct mesh_data {
    uint32_t vertex_count, triangle_count;
    float *positions;  /* (vertex_count, 3), one vertex more is allocated */
    float *normals;    /* (vertex_count, 3) as stored, or NULL */
    float *uvs;        /* (vertex_count, 2), or NULL */
    uint32_t *indices; /* (triangle_count, 3), all < vertex_count */
};

/* Most vertices or triangles a mesh may have: three indices of each still fit 32 bits. */
#define MESH_MAX_COUNT 0x3fffffffu

/* Allocates arrays for the counts, zeroed; normals and uvs where asked. False without memory
 * (destroy *mesh). */
bool mesh_data_allocate(struct mesh_data *mesh, size_t vertices, size_t triangles, bool normals,
                        bool uvs);
void mesh_data_free(struct mesh_data *mesh);

/* Wavefront OBJ: polygons are split into fans; v/vt/vn triples become vertices, equal ones once.
 * Normals and uvs are dropped unless every corner has them. */
int mesh_read_obj(const char *path, struct mesh_data *out, struct fewray_error *error);
/* The same from text with a NUL behind it; path is for messages. */
int mesh_parse_obj(const char *path, const char *text, size_t size, struct mesh_data *out,
                   struct fewray_error *error);

/* PLY, binary little endian or ascii. */
int mesh_read_ply(const char *path, struct mesh_data *out, struct fewray_error *error);

/* Mesh `index` of a file in Mitsuba's serialized format, version 3 or 4. */
int mesh_read_serialized(const char *path, int index, struct mesh_data *out,
                         struct fewray_error *error);

/* Simple shapes as Mitsuba has them: [-1,1]^2 in the xy plane; radius 1 in the xy plane; [-1,1]^3;
 * radius 1 around 0; radius 1 around the z axis from 0 to 1, open. False without memory. */
bool mesh_make_rectangle(struct mesh_data *out);
bool mesh_make_disk(struct mesh_data *out);
bool mesh_make_cube(struct mesh_data *out);
bool mesh_make_sphere(struct mesh_data *out);
bool mesh_make_cylinder(struct mesh_data *out);

/* Vertex normals (vertex_count, 3) that weight each triangle's normal by its angle at the vertex:
 * what Mitsuba gives to meshes without normals. NULL without memory. Thürmer and Wüthrich,
 * "Computing Vertex Normals from Polygonal Facets", 1998. */
float *mesh_smooth_normals(const struct mesh_data *mesh);

#endif
