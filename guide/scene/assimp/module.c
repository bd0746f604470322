/* SPDX-License-Identifier: Apache-2.0 */
/* The module "assimp": assimp's functions in one table, and nothing else. */

#include "guide/scene/assimp/api.h"

const struct assimp_api fewray_assimp = {
    .import_file = aiImportFile,
    .release = aiReleaseImport,
    .error_string = aiGetErrorString,
    .floats = aiGetMaterialFloatArray,
    .integers = aiGetMaterialIntegerArray,
    .color = aiGetMaterialColor,
    .string = aiGetMaterialString,
};
