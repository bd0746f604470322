/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_ASSIMP_GLTF_H
#define FEWRAY_GUIDE_SCENE_ASSIMP_GLTF_H

/* The JSON of a glTF file, for what assimp 5.2 doesn't deliver or delivers wrongly: cameras (it
 * multiplies the vertical angle by the aspect), lights that several nodes share, emissive strength
 * and texture transforms; and for checks that keep it from crashing. */

#include <jansson.h>

#include "fewray/features.h"
#include "guide/scene/scene.h"
#include "guide/scene/transform.h"

/* Reads the JSON of a .gltf or .glb file. Refuses what isn't glTF 2, needs an extension that fewray
 * or assimp doesn't know, or has nodes that aren't a forest. *out: json_decref(). */
int gltf_read(const char *path, json_t **out, struct fewray_error *error);

/* Refuses members of a wrong type. */
int gltf_check_types(const char *path, const json_t *gltf, struct fewray_error *error);

/* Refuses accessors beyond their buffers, or of a type that their use doesn't have. body: bytes of
 * a .glb's binary chunk. */
int gltf_check_bounds(const char *path, const json_t *gltf, size_t body,
                      struct fewray_error *error);

/* The scene to show; NULL where the file has none. */
const json_t *gltf_scene(const json_t *gltf);
/* A root of the scene, or a node's child; NULL beyond the last. */
const json_t *gltf_root(const json_t *gltf, size_t index);
const json_t *gltf_child(const json_t *gltf, const json_t *node, size_t index);
size_t gltf_child_count(const json_t *parent, const char *key);

/* The primitives of a node's mesh, and the material of one: NULL where it has none. */
size_t gltf_primitive_count(const json_t *gltf, const json_t *node);
const json_t *gltf_primitive_material(const json_t *gltf, const json_t *node, size_t primitive);

/* A node's perspective camera. *aspect is 0 where the file leaves it open. *orthographic tells of a
 * camera that is none. */
bool gltf_node_camera(const json_t *gltf, const json_t *node, double *fov_y, double *aspect,
                      bool *orthographic);
/* A node's light, placed. KHR_lights_punctual counts in candela and lux; W/sr and W/m2 are 1/683 of
 * them, as Blender's "standard" lighting mode has it. */
bool gltf_node_light(const json_t *gltf, const json_t *node, const struct transform *to_world,
                     struct light *out);

/* KHR_materials_emissive_strength; 1 where it isn't given or material is NULL. */
double gltf_emissive_strength(const json_t *material);
/* KHR_texture_transform of a material's texture ("normalTexture", or "pbrMetallicRoughness" and
 * "baseColorTexture"): the rows of struct texture's to_uv. */
void gltf_texture_transform(const json_t *material, const char *group, const char *name,
                            float to_uv[6]);
/* Whether the file has skins or morph targets. */
bool gltf_deforms(const json_t *gltf);

#endif
