/* SPDX-License-Identifier: Apache-2.0 */
/* What the materials of both formats share: lookups in assimp's, and wrappers. */

#include <string.h>

#include "guide/scene/assimp/import.h"
#include "guide/scene/memory.h"

struct bsdf import_bsdf(enum bsdf_kind kind) {
    struct bsdf bsdf = empty_bsdf(kind);
    bsdf.microfacets = MICROFACET_GGX;
    return bsdf;
}

int import_add_bsdf(struct import *import, const struct bsdf *bsdf, int *index) {
    struct fewray_scene *scene = import->scene;
    if (!array_reserve((void **)&scene->bsdfs, &import->bsdf_capacity,
                       (size_t)scene->bsdf_count + 1, sizeof(*scene->bsdfs)))
        return import_fail_memory(import);
    *index = scene->bsdf_count++;
    scene->bsdfs[*index] = *bsdf;
    return FEWRAY_OK;
}

int import_add_twosided(struct import *import, int *index) {
    struct bsdf bsdf = import_bsdf(BSDF_TWOSIDED);
    bsdf.nested[0] = bsdf.nested[1] = *index;
    bsdf.tangents = import->scene->bsdfs[*index].tangents;
    return import_add_bsdf(import, &bsdf, index);
}

int import_add_mask(struct import *import, int opacity, int *index) {
    struct bsdf nothing = import_bsdf(BSDF_NULL), mask = import_bsdf(BSDF_MASK);
    mask.nested[0] = *index;
    mask.weight = opacity;
    mask.tangents = import->scene->bsdfs[*index].tangents;
    int status = import_add_bsdf(import, &nothing, &mask.nested[1]);
    return status ? status : import_add_bsdf(import, &mask, index);
}

int import_add_black(struct import *import, int *index) {
    struct bsdf bsdf = import_bsdf(BSDF_DIFFUSE);
    int status = import_constant(import, vec(0, 0, 0), &bsdf.reflectance);
    return status ? status : import_add_bsdf(import, &bsdf, index);
}

static float finite_or(float value, float fallback) {
    return isfinite(value) ? value : fallback;
}

float import_number(const struct import *import, const struct aiMaterial *material, const char *key,
                    unsigned type, unsigned index, float fallback) {
    float value = fallback;
    unsigned count = 1;
    if (import->assimp->floats(material, key, type, index, &value, &count) != aiReturn_SUCCESS ||
        !count)
        return fallback;
    return finite_or(value, fallback);
}

int import_integer(const struct import *import, const struct aiMaterial *material, const char *key,
                   unsigned type, unsigned index, int fallback) {
    int value = fallback;
    unsigned count = 1;
    enum aiReturn done = import->assimp->integers(material, key, type, index, &value, &count);
    return done == aiReturn_SUCCESS && count ? value : fallback;
}

struct vec3 import_color(const struct import *import, const struct aiMaterial *material,
                         const char *key, unsigned type, unsigned index, struct vec3 fallback) {
    struct aiColor4D c = {fallback.x, fallback.y, fallback.z, 1};
    if (import->assimp->color(material, key, type, index, &c) != aiReturn_SUCCESS)
        return fallback;
    return vec(fmaxf(finite_or(c.r, fallback.x), 0), fmaxf(finite_or(c.g, fallback.y), 0),
               fmaxf(finite_or(c.b, fallback.z), 0));
}

bool import_texture_name(const struct import *import, const struct aiMaterial *material,
                         enum aiTextureType type, struct aiString *name) {
    return import->assimp->string(material, AI_MATKEY_TEXTURE(type, 0), name) == aiReturn_SUCCESS &&
           name->length > 0;
}
