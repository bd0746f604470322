/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_MESH_BUILD_H
#define FEWRAY_GUIDE_SCENE_MESH_BUILD_H

/* Shapes as the scene's file describes them, and how they become meshes in world space. */

#include <stdbool.h>

#include "guide/scene/transform.h"
#include "guide/vec.h"

enum shape_kind {
    SHAPE_FILE,
    SHAPE_RECTANGLE,
    SHAPE_DISK,
    SHAPE_CUBE,
    SHAPE_CYLINDER,
    SHAPE_SPHERE
};

struct shape {
    const struct xml_node *node;
    const char *name; /* for messages */
    enum shape_kind kind;
    int asset; /* of SHAPE_FILE */
    struct transform to_world;
    bool face_normals, flip_normals, flip_v;
    int group; /* -1: the scene itself */
    int bsdf;
    bool has_emitter; /* maybe a black one */
    int emission;     /* texture; -1 = none */
};

/* Fills scene->meshes, in parallel, one for each shape. */
int meshes_build(struct loader *loader);

#endif
