/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_ASSIMP_API_H
#define FEWRAY_GUIDE_SCENE_ASSIMP_API_H

/* The functions of assimp that the loader calls. They stand in the module "assimp"
 * (features/module.h), which is opened by the first scene that needs it. */

#include <assimp/cimport.h>
#include <assimp/material.h>
#include <assimp/scene.h>

#include "fewray/features.h"

struct assimp_api {
    const struct aiScene *(*import_file)(const char *path, unsigned flags);
    void (*release)(const struct aiScene *scene);
    const char *(*error_string)(void);
    enum aiReturn (*floats)(const struct aiMaterial *material, const char *key, unsigned type,
                            unsigned index, ai_real *out, unsigned *count);
    enum aiReturn (*integers)(const struct aiMaterial *material, const char *key, unsigned type,
                              unsigned index, int *out, unsigned *count);
    enum aiReturn (*color)(const struct aiMaterial *material, const char *key, unsigned type,
                           unsigned index, struct aiColor4D *out);
    enum aiReturn (*string)(const struct aiMaterial *material, const char *key, unsigned type,
                            unsigned index, struct aiString *out);
};

FEWRAY_API extern const struct assimp_api fewray_assimp;

#endif
