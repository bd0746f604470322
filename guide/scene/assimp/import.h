/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_ASSIMP_IMPORT_H
#define FEWRAY_GUIDE_SCENE_ASSIMP_IMPORT_H

/* glTF 2.0 and OBJ + MTL as scenes. The order of work (import.c):
 *
 *     gltf_read()            the JSON of a glTF file, checked
 *     assimp                 the file -> its meshes, nodes, materials
 *     import_nodes()         nodes -> meshes and instances in world space, lights, the camera;
 *                            materials that they use -> BSDFs, textures, lists of images to read
 *     import_read_images()   all images, in parallel
 *     import_view()          film, and a camera and light where the file has none
 */

#include "guide/scene/assimp/api.h"
#include "guide/scene/assimp/gltf.h"
#include "guide/scene/scene.h"

/* What becomes of an image's file. */
enum import_image_use {
    IMPORT_COLOR,   /* linear, or 8-bit sRGB */
    IMPORT_RAW,     /* values as stored */
    IMPORT_OPACITY, /* the same; its channel 3 is channel 0 where there is no alpha */
    IMPORT_CUTOFF,  /* grey: 255 where alpha is at least `parameter`, else 0 */
    IMPORT_NORMALS  /* float RGB, x and y of the normal times `parameter` */
};

struct import_image {
    enum import_image_use use;
    float parameter;
    char *path;                       /* of a file; of an embedded image a name for messages */
    const struct aiTexture *embedded; /* or NULL */
    struct fewray_image *image;
    int status;
    struct fewray_error error;
};

struct import_material {
    bool done;
    int bsdf, emission; /* as in struct mesh */
    int uv_set;         /* of assimp's, that its textures are placed by */
    bool wants_uvs;
};

struct import {
    const char *path;
    const struct assimp_api *assimp;
    const struct aiScene *source;
    json_t *gltf; /* NULL for OBJ */
    struct fewray_scene *scene;
    struct fewray_error *error;
    int threads;

    struct import_image *images;
    int image_count;
    int *texture_images;               /* of each scene texture: index of an image, -1 = none */
    struct import_material *materials; /* (source->mNumMaterials) */
    int *mesh_uses;                    /* (source->mNumMeshes): nodes that show it */
    int *mesh_groups;                  /* (source->mNumMeshes): its group, -1 = none so far */
    bool has_camera, has_lights, has_orthographic;
    int camera_channels;  /* of animations: those that move the camera */
    double fov_y, aspect; /* of the file's camera */
    size_t image_capacity, texture_capacity, texture_image_capacity, bsdf_capacity, mesh_capacity,
        light_capacity, instance_capacity, warning_capacity;
};

int import_fail(struct import *import, enum fewray_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
int import_fail_memory(struct import *import);
/* Keeps "FILE: text" among the scene's warnings, once. */
int import_warn(struct import *import, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* --- textures and images: *index is of the scene's textures */

int import_constant(struct import *import, struct vec3 color, int *index);
/* A bitmap. texture: all but kind and image. name is assimp's: "*3" is embedded, others are beside
 * the scene. */
int import_bitmap(struct import *import, const struct texture *texture, const char *name,
                  enum import_image_use use, float parameter, int *index);
int import_read_images(struct import *import);
/* A texture of white, all defaults. */
struct texture import_white(void);

/* --- materials */

struct bsdf import_bsdf(enum bsdf_kind kind);
int import_add_bsdf(struct import *import, const struct bsdf *bsdf, int *index);
/* Lets nested shine from both sides, or with an opacity. *index: of nested, becomes the new one's.
 */
int import_add_twosided(struct import *import, int *index);
int import_add_mask(struct import *import, int opacity, int *index);
/* A black surface, for what only shines. */
int import_add_black(struct import *import, int *index);
/* Properties by assimp's keys, AI_MATKEY_..., which stand for three arguments. */
float import_number(const struct import *import, const struct aiMaterial *material, const char *key,
                    unsigned type, unsigned index, float fallback);
int import_integer(const struct import *import, const struct aiMaterial *material, const char *key,
                   unsigned type, unsigned index, int fallback);
struct vec3 import_color(const struct import *import, const struct aiMaterial *material,
                         const char *key, unsigned type, unsigned index, struct vec3 fallback);
/* The name of the texture of this kind; false where there is none. */
bool import_texture_name(const struct import *import, const struct aiMaterial *material,
                         enum aiTextureType type, struct aiString *name);
/* Both fill *out. json: the glTF material, NULL = its default. */
int import_gltf_material(struct import *import, const struct aiMaterial *material,
                         const json_t *json, struct import_material *out);
int import_mtl_material(struct import *import, const struct aiMaterial *material,
                        struct import_material *out);

/* --- nodes, meshes and the view */

int import_nodes(struct import *import);
/* The pose of struct camera at a node whose camera, as glTF has it, looks along -z with +x to the
 * right; scales are dropped. False where the node is scaled to nothing. */
bool import_camera_pose(const struct transform *node_to_world, struct transform *camera);
/* The keys by which the first animation moves the camera's node or those above it. */
int import_camera_keys(struct import *import, const struct aiNode *node);
/* Whether the file has skins, morph targets or animations that move more than the camera. */
bool import_moves_more(const struct import *import);
/* One mesh of assimp's by one node. to_world: NULL for a group's mesh, which keeps its own space.
 */
int import_mesh(struct import *import, const struct aiMesh *source,
                const struct import_material *material, const struct transform *to_world,
                int group);
int import_view(struct import *import);

/* Refuses MTL files that assimp can't read safely, and warns of those that aren't there. */
int import_check_mtl(struct import *import);

#endif
