/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_ASSIMP_IMPORT_SCENE_H
#define FEWRAY_GUIDE_SCENE_ASSIMP_IMPORT_SCENE_H

/* glTF 2.0 (.gltf, .glb) and OBJ + MTL as scenes, through assimp. */

#include "fewray/guide.h"

/* Whether a file of this name is one for import_scene(). */
bool import_knows(const char *path);

/* The error names the file. *out is owned by the caller. */
int import_scene(const char *path, int threads, struct fewray_scene **out,
                 struct fewray_error *error);

#endif
