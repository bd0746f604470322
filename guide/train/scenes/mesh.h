/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_MESH_H
#define FEWRAY_TRAIN_MESH_H

/* Triangle meshes for what boxes and balls can't be: leaves, vases, folds. In metres. */

#include <stdbool.h>
#include <stdint.h>

#include "fewray/features.h"
#include "guide/train/scenes/random.h"
#include "guide/vec.h"

struct mesh {
    int vertex_count, vertex_capacity, triangle_count, triangle_capacity;
    struct vec3 *positions;
    float (*uvs)[2];
    int (*triangles)[3];
    bool smooth; /* shading normals from the neighbours; else the faces' own */
    bool failed; /* out of memory: the mesh is incomplete */
};

struct mesh *mesh_create(bool smooth); /* NULL where memory is short */
void mesh_destroy(struct mesh **mesh);
int mesh_vertex(struct mesh *mesh, struct vec3 position, float u, float v);
void mesh_triangle(struct mesh *mesh, int a, int b, int c);
/* Radius of a sphere around the mesh. */
float mesh_bounds(const struct mesh *mesh, struct vec3 *center);
/* Ray parameter of the nearest hit beyond least, or -1; *normal gets that triangle's. */
float mesh_hit(const struct mesh *mesh, struct vec3 origin, struct vec3 dir, float least,
               struct vec3 *normal);
/* Wavefront OBJ. */
int mesh_write(const struct mesh *mesh, const char *path, struct fewray_error *error);

/* A closed body around the y axis: count radii and heights from the bottom's middle to the top's
 * (or, for a hollow one, over the rim and down inside), the first and the last radius 0. */
struct mesh *mesh_revolution(const float (*profile)[2], int count, int sides);
/* Pointed leaves in a cloud: around (0, height, 0), within these half axes. */
struct mesh *mesh_foliage(struct random *r, int leaves, float height, float spread, float leaf);
/* Blades of grass that rise from a disk. */
struct mesh *mesh_grass(struct random *r, int blades, float radius, float height);

#endif
