/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_H
#define FEWRAY_GUIDE_SCENE_H

/* A scene as plain data: what the loaders fill and the tracer reads. Everything is in world space;
 * every shape is a triangle mesh (rectangle 2, cube 12 triangles; disk and sphere are tessellated).
 */

#include <stdbool.h>
#include <stdint.h>

#include "guide/guide.h"
#include "guide/vec.h"

enum texture_kind { TEXTURE_CONSTANT, TEXTURE_BITMAP, TEXTURE_CHECKERBOARD };

struct texture {
    enum texture_kind kind;
    struct vec3 color0, color1;       /* constant: color0; checkerboard: both (Mitsuba's order) */
    float to_uv[6];                   /* u' = m0 u + m1 v + m2, v' = m3 u + m4 v + m5 */
    const struct fewray_image *image; /* bitmap; owned by the scene's images */
    bool nearest;                     /* no bilinear filter */
    bool srgb;                        /* 8-bit values carry the sRGB transfer function */
};

struct bsdf {
    int reflectance; /* index of a texture */
    bool twosided;
};

struct mesh {
    char *id; /* the shape's id, or its file, for messages */
    uint32_t vertex_count, triangle_count;
    float *positions;  /* (vertex_count, 3), one vertex more is allocated (Embree reads 16 bytes) */
    float *normals;    /* (vertex_count, 3) unit shading normals, or NULL: use the face's */
    float *uvs;        /* (vertex_count, 2), or NULL */
    uint32_t *indices; /* (triangle_count, 3); the face normal is (p1-p0) x (p2-p0) */
    int bsdf;
    bool emissive;
    struct vec3 radiance; /* emitted on the side that the normal points to */
};

enum environment_kind { ENVIRONMENT_NONE, ENVIRONMENT_CONSTANT, ENVIRONMENT_MAP };

struct environment {
    enum environment_kind kind;
    struct vec3 radiance; /* constant */
    const struct fewray_image
        *image; /* map: float, 3 channels; latitude-longitude as Mitsuba's envmap */
    float scale;
    float
        to_local[9]; /* rows of the rotation that takes a world direction to the map's own space */
};

struct camera {
    float
        to_world[12]; /* 3 rows of 4; looks along +z with +x to the LEFT of the image, as Mitsuba */
    float fov_x;      /* radians, along the image's width */
    int width, height; /* pixels */
};

struct fewray_scene {
    char *path;
    struct camera camera;
    int max_depth; /* as Mitsuba counts: 1 = emission only, 2 = direct light; -1 = no limit */
    int rr_depth;
    int sample_count; /* the file's own spp */

    int texture_count, bsdf_count, mesh_count, image_count, warning_count;
    struct texture *textures;
    struct bsdf *bsdfs;
    struct mesh *meshes;
    struct fewray_image **images;
    struct environment environment;
    char **warnings; /* one line each: what was approximated (printed by the command, not here) */
};

#endif
