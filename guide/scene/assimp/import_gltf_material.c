/* SPDX-License-Identifier: Apache-2.0 */
/* glTF's materials as Mitsuba's principled BSDF. Both square roughness to the microfacets' alpha,
 * mix metal and dielectric by `metallic`, and tint metal by the base colour. */

#include <assimp/GltfMaterial.h>
#include <string.h>

#include "guide/scene/assimp/import.h"

#define FILTER_NEAREST 9728 /* OpenGL's number, which glTF writes */

/* One texture of the material, looked up. */
struct slot {
    enum aiTextureType type;  /* assimp's */
    const char *group, *name; /* in the JSON */
    struct aiString file;
    struct texture texture; /* its place on the surface */
};

static enum texture_wrap wrap_of(int mode) {
    return mode == aiTextureMapMode_Clamp    ? WRAP_CLAMP
           : mode == aiTextureMapMode_Mirror ? WRAP_MIRROR
                                             : WRAP_REPEAT;
}

/* False where the material has no such texture. A mesh keeps one set of texture coordinates: that
 * of the material's first texture. */
static bool find_slot(struct import *import, const struct aiMaterial *material, const json_t *json,
                      struct import_material *out, struct slot *slot, int *status) {
    if (*status || !import_texture_name(import, material, slot->type, &slot->file))
        return false;
    int uv_set = import_integer(import, material, AI_MATKEY_UVWSRC(slot->type, 0), 0);
    if (!out->wants_uvs)
        out->uv_set = uv_set;
    else if (out->uv_set != uv_set)
        *status = import_warn(import, "materials that place textures by two sets of texture "
                                      "coordinates: the first is used for all");
    out->wants_uvs = true;
    slot->texture = import_white();
    slot->texture.wrap =
        wrap_of(import_integer(import, material, AI_MATKEY_MAPPINGMODE_U(slot->type, 0), 0));
    slot->texture.nearest =
        import_integer(import, material, AI_MATKEY_GLTF_MAPPINGFILTER_MAG(slot->type, 0), 0) ==
        FILTER_NEAREST;
    gltf_texture_transform(json, slot->group, slot->name, slot->texture.to_uv);
    return *status == FEWRAY_OK;
}

struct reader {
    struct import *import;
    const struct aiMaterial *material;
    const json_t *json;
    struct import_material *out;
    int status;
};

static void read_color(struct reader *r, struct slot slot, struct vec3 factor, int *index) {
    if (r->status)
        return;
    if (find_slot(r->import, r->material, r->json, r->out, &slot, &r->status)) {
        slot.texture.factor = factor;
        r->status = import_bitmap(r->import, &slot.texture, slot.file.data, IMPORT_COLOR, 0, index);
    } else if (!r->status) {
        r->status = import_constant(r->import, factor, index);
    }
}

/* A channel of a texture times the factor; *index stays -1 where that is 0 all over. */
static void read_grey(struct reader *r, struct slot slot, int channel, float factor, int *index) {
    if (r->status || !(factor > 0))
        return;
    if (find_slot(r->import, r->material, r->json, r->out, &slot, &r->status)) {
        slot.texture.factor = vec(factor, factor, factor);
        slot.texture.channel = channel;
        r->status = import_bitmap(r->import, &slot.texture, slot.file.data, IMPORT_RAW, 0, index);
    } else if (!r->status) {
        r->status = import_constant(r->import, vec(factor, factor, factor), index);
    }
}

static const struct slot base_color_slot = {
    .type = aiTextureType_BASE_COLOR, .group = "pbrMetallicRoughness", .name = "baseColorTexture"};
static const struct slot metallic_slot = {.type = aiTextureType_METALNESS,
                                          .group = "pbrMetallicRoughness",
                                          .name = "metallicRoughnessTexture"};
static const struct slot roughness_slot = {.type = aiTextureType_DIFFUSE_ROUGHNESS,
                                           .group = "pbrMetallicRoughness",
                                           .name = "metallicRoughnessTexture"};
static const struct slot emissive_slot = {.type = aiTextureType_EMISSIVE,
                                          .name = "emissiveTexture"};
static const struct slot normal_slot = {.type = aiTextureType_NORMALS, .name = "normalTexture"};
static const struct slot transmission_slot = {.type = aiTextureType_TRANSMISSION,
                                              .name = "transmissionTexture"};
static const struct slot clearcoat_slot = {.type = aiTextureType_CLEARCOAT,
                                           .name = "clearcoatTexture"};

/* The base colour's alpha as the opacity of a mask. */
static void add_alpha(struct reader *r, int *bsdf) {
    struct aiString mode = {0};
    const struct import *import = r->import;
    struct slot slot = base_color_slot;
    int opacity = -1;
    if (r->status ||
        import->assimp->string(r->material, AI_MATKEY_GLTF_ALPHAMODE, &mode) != aiReturn_SUCCESS)
        return;
    bool cut = !strcmp(mode.data, "MASK");
    if (!cut && strcmp(mode.data, "BLEND") != 0)
        return;
    float alpha = fminf(fmaxf(import_number(import, r->material, AI_MATKEY_OPACITY, 1), 0), 1);
    float cutoff = import_number(import, r->material, AI_MATKEY_GLTF_ALPHACUTOFF, 0.5f);
    if (find_slot(r->import, r->material, r->json, r->out, &slot, &r->status)) {
        float factor = cut ? 1 : alpha;
        slot.texture.factor = vec(factor, factor, factor);
        slot.texture.channel = cut ? 0 : 3;
        /* Alpha times its factor is compared: where that is 0, the most there can be is 0. */
        float least = alpha > 0 ? cutoff / alpha : cutoff > 0 ? INFINITY : 0;
        r->status = import_bitmap(r->import, &slot.texture, slot.file.data,
                                  cut ? IMPORT_CUTOFF : IMPORT_RAW, cut ? least : 0, &opacity);
    } else if (!r->status) {
        float constant = cut ? (float)(alpha >= cutoff) : alpha;
        if (constant >= 1)
            return;
        r->status = import_constant(r->import, vec(constant, constant, constant), &opacity);
    }
    if (!r->status)
        r->status = import_add_mask(r->import, opacity, bsdf);
}

static void add_normal_map(struct reader *r, int *bsdf) {
    struct slot slot = normal_slot;
    struct bsdf map = import_bsdf(BSDF_NORMAL_MAP);
    if (!find_slot(r->import, r->material, r->json, r->out, &slot, &r->status))
        return;
    float factor = import_number(r->import, r->material,
                                 AI_MATKEY_GLTF_TEXTURE_SCALE(aiTextureType_NORMALS, 0), 1);
    map.nested[0] = *bsdf;
    map.tangents = true;
    r->status = import_bitmap(r->import, &slot.texture, slot.file.data,
                              factor == 1 ? IMPORT_RAW : IMPORT_NORMALS, factor == 1 ? 0 : factor,
                              &map.weight);
    if (!r->status)
        r->status = import_add_bsdf(r->import, &map, bsdf);
}

static void read_emission(struct reader *r) {
    struct vec3 radiance =
        import_color(r->import, r->material, AI_MATKEY_COLOR_EMISSIVE, vec(0, 0, 0));
    radiance = scale(radiance, (float)fmin(gltf_emissive_strength(r->json), 1e30));
    if (max_component(radiance) > 0)
        read_color(r, emissive_slot, radiance, &r->out->emission);
}

static void read_principled(struct reader *r, struct vec3 base_color, struct bsdf *out) {
    const struct import *import = r->import;
    const struct aiMaterial *m = r->material;
    int *p = out->principled;
    float ior = import_number(import, m, AI_MATKEY_REFRACTI, 1.5f);
    out->eta = fminf(fmaxf(ior, 1.001f), 10);
    read_color(r, base_color_slot, base_color, &out->reflectance);
    read_grey(r, metallic_slot, 2, import_number(import, m, AI_MATKEY_METALLIC_FACTOR, 1),
              &p[PRINCIPLED_METALLIC]);
    read_grey(r, roughness_slot, 1, import_number(import, m, AI_MATKEY_ROUGHNESS_FACTOR, 1),
              &p[PRINCIPLED_ROUGHNESS]);
    read_grey(r, transmission_slot, 0, import_number(import, m, AI_MATKEY_TRANSMISSION_FACTOR, 0),
              &p[PRINCIPLED_SPEC_TRANS]);
    read_grey(r, clearcoat_slot, 0, import_number(import, m, AI_MATKEY_CLEARCOAT_FACTOR, 0),
              &p[PRINCIPLED_CLEARCOAT]);
    float gloss = 1 - import_number(import, m, AI_MATKEY_CLEARCOAT_ROUGHNESS_FACTOR, 0);
    if (!r->status && p[PRINCIPLED_CLEARCOAT] >= 0 && gloss > 0)
        r->status =
            import_constant(r->import, vec(gloss, gloss, gloss), &p[PRINCIPLED_CLEARCOAT_GLOSS]);
}

/* Unlit: the base colour shines, and nothing is reflected. */
static void read_unlit(struct reader *r, struct vec3 base_color, int *bsdf) {
    if (max_component(base_color) > 0)
        read_color(r, base_color_slot, base_color, &r->out->emission);
    if (!r->status)
        r->status = import_add_black(r->import, bsdf);
}

int import_gltf_material(struct import *import, const struct aiMaterial *material,
                         const json_t *json, struct import_material *out) {
    struct reader r = {.import = import, .material = material, .json = json, .out = out};
    struct vec3 base_color = import_color(import, material, AI_MATKEY_BASE_COLOR, vec(1, 1, 1));
    int mode = import_integer(import, material, AI_MATKEY_SHADING_MODEL, aiShadingMode_PBR_BRDF);
    *out = (struct import_material){.done = true, .bsdf = -1, .emission = -1};
    if (mode == aiShadingMode_Unlit) {
        read_unlit(&r, base_color, &out->bsdf);
    } else {
        struct bsdf bsdf = import_bsdf(BSDF_PRINCIPLED);
        read_principled(&r, base_color, &bsdf);
        if (!r.status)
            r.status = import_add_bsdf(import, &bsdf, &out->bsdf);
        if (!r.status)
            add_normal_map(&r, &out->bsdf);
        /* Also where it isn't double-sided: path tracers don't cull what is seen from behind. */
        if (!r.status && bsdf.principled[PRINCIPLED_SPEC_TRANS] < 0)
            r.status = import_add_twosided(import, &out->bsdf);
        if (!r.status)
            read_emission(&r);
    }
    add_alpha(&r, &out->bsdf);
    return r.status;
}
