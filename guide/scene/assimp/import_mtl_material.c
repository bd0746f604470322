/* SPDX-License-Identifier: Apache-2.0 */
/* Wavefront's MTL materials: Phong's, and the metallic ones that many exporters add. */

#include <string.h>

#include "guide/scene/assimp/import.h"

/* assimp has no name for it. */
#define MATKEY_ILLUM "$mat.illum", 0, 0

struct reader {
    struct import *import;
    const struct aiMaterial *material;
    struct import_material *out;
    int status;
};

/* The constant, or a texture; in MTL the texture is multiplied by the constant, but where that is
 * black exporters mean the texture alone. */
static void read_color(struct reader *r, enum aiTextureType type, struct vec3 constant,
                       int *index) {
    struct aiString name;
    struct texture texture = import_white();
    if (r->status)
        return;
    if (import_texture_name(r->import, r->material, type, &name)) {
        if (max_component(constant) > 0)
            texture.factor = constant;
        r->out->wants_uvs = true;
        r->status = import_bitmap(r->import, &texture, name.data, IMPORT_COLOR, 0, index);
    } else {
        r->status = import_constant(r->import, constant, index);
    }
}

static void read_grey(struct reader *r, enum aiTextureType type, float constant, int *index) {
    struct aiString name;
    struct texture texture = import_white();
    if (r->status)
        return;
    if (import_texture_name(r->import, r->material, type, &name)) {
        texture.channel = 0;
        r->out->wants_uvs = true;
        r->status = import_bitmap(r->import, &texture, name.data, IMPORT_RAW, 0, index);
    } else if (constant > 0) {
        r->status = import_constant(r->import, vec(constant, constant, constant), index);
    }
}

static bool is_metallic(const struct import *import, const struct aiMaterial *m) {
    struct aiString name;
    return import_number(import, m, AI_MATKEY_ROUGHNESS_FACTOR, -1) >= 0 ||
           import_number(import, m, AI_MATKEY_METALLIC_FACTOR, -1) >= 0 ||
           import_texture_name(import, m, aiTextureType_DIFFUSE_ROUGHNESS, &name) ||
           import_texture_name(import, m, aiTextureType_METALNESS, &name);
}

/* Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", 5.2: a Beckmann
 * lobe is about as wide as Blinn and Phong's of the exponent. */
static float alpha_of_exponent(float exponent) {
    return fminf(sqrtf(2 / (fmaxf(exponent, 0) + 2)), 1);
}

static void set_alpha(struct reader *r, float exponent, struct bsdf *out) {
    float alpha = alpha_of_exponent(exponent);
    out->microfacets = MICROFACET_BECKMANN;
    if (!r->status)
        r->status = import_constant(r->import, vec(alpha, alpha, alpha), &out->alpha_u);
    out->alpha_v = out->alpha_u;
}

/* Pr, Pm, Pc. */
static struct bsdf read_principled(struct reader *r, struct vec3 diffuse) {
    struct bsdf bsdf = import_bsdf(BSDF_PRINCIPLED);
    float ior = import_number(r->import, r->material, AI_MATKEY_REFRACTI, 1);
    bsdf.eta = ior > 1.001f ? fminf(ior, 10) : 1.5f;
    read_color(r, aiTextureType_DIFFUSE, diffuse, &bsdf.reflectance);
    read_grey(r, aiTextureType_DIFFUSE_ROUGHNESS,
              import_number(r->import, r->material, AI_MATKEY_ROUGHNESS_FACTOR, 0.5f),
              &bsdf.principled[PRINCIPLED_ROUGHNESS]);
    read_grey(r, aiTextureType_METALNESS,
              import_number(r->import, r->material, AI_MATKEY_METALLIC_FACTOR, 0),
              &bsdf.principled[PRINCIPLED_METALLIC]);
    read_grey(r, aiTextureType_CLEARCOAT,
              import_number(r->import, r->material, AI_MATKEY_CLEARCOAT_FACTOR, 0),
              &bsdf.principled[PRINCIPLED_CLEARCOAT]);
    return bsdf;
}

static struct bsdf read_glass(struct reader *r, float ior) {
    struct bsdf bsdf = import_bsdf(BSDF_DIELECTRIC);
    bsdf.eta = fminf(ior, 10);
    r->status = import_constant(r->import, vec(1, 1, 1), &bsdf.specular_reflectance);
    struct vec3 filter =
        import_color(r->import, r->material, AI_MATKEY_COLOR_TRANSPARENT, vec(1, 1, 1));
    if (!r->status)
        r->status = import_constant(r->import, max_component(filter) > 0 ? filter : vec(1, 1, 1),
                                    &bsdf.specular_transmittance);
    return bsdf;
}

static struct bsdf read_mirror(struct reader *r, struct vec3 specular, float exponent) {
    struct bsdf bsdf = import_bsdf(exponent >= 10000 ? BSDF_CONDUCTOR : BSDF_ROUGH_CONDUCTOR);
    bsdf.conductor_k = vec(1, 1, 1); /* eta 0: all is reflected */
    read_color(r, aiTextureType_SPECULAR, specular, &bsdf.specular_reflectance);
    if (bsdf.kind == BSDF_ROUGH_CONDUCTOR)
        set_alpha(r, exponent, &bsdf);
    return bsdf;
}

/* A coat of index 1.5 reflects 0.04 head on, for which exporters write Ks = 0.5. */
static struct bsdf read_plastic(struct reader *r, struct vec3 diffuse, struct vec3 specular,
                                float exponent) {
    struct bsdf bsdf = import_bsdf(BSDF_ROUGH_PLASTIC);
    struct vec3 coat =
        vec(fminf(2 * specular.x, 1), fminf(2 * specular.y, 1), fminf(2 * specular.z, 1));
    bsdf.eta = 1.5f;
    read_color(r, aiTextureType_DIFFUSE, diffuse, &bsdf.reflectance);
    if (!r->status)
        r->status = import_constant(r->import, coat, &bsdf.specular_reflectance);
    set_alpha(r, exponent, &bsdf);
    return bsdf;
}

static struct bsdf read_diffuse(struct reader *r, struct vec3 diffuse) {
    struct bsdf bsdf = import_bsdf(BSDF_DIFFUSE);
    read_color(r, aiTextureType_DIFFUSE, diffuse, &bsdf.reflectance);
    return bsdf;
}

/* illum 6 and 7 refract; 4 and 9 are glass where something shows through. */
static bool is_glass(int illum, float opacity, float ior) {
    return ior > 1.001f &&
           (illum == 6 || illum == 7 || ((illum == 4 || illum == 9) && opacity < 1));
}

/* opacity is assimp's of d and Tr. map_d is an alpha channel, or grey where it has none. */
static void add_opacity(struct reader *r, float opacity, int *bsdf) {
    struct aiString name;
    struct texture texture = import_white();
    int weight = -1;
    if (r->status)
        return;
    if (import_texture_name(r->import, r->material, aiTextureType_OPACITY, &name)) {
        texture.channel = 3;
        r->out->wants_uvs = true;
        r->status = import_bitmap(r->import, &texture, name.data, IMPORT_OPACITY, 0, &weight);
    } else if (opacity < 1) {
        float constant = fmaxf(opacity, 0);
        r->status = import_constant(r->import, vec(constant, constant, constant), &weight);
    }
    if (!r->status && weight >= 0)
        r->status = import_add_mask(r->import, weight, bsdf);
}

static void add_normal_map(struct reader *r, int *bsdf) {
    struct aiString name;
    struct texture texture = import_white();
    struct bsdf map = import_bsdf(BSDF_NORMAL_MAP);
    if (r->status)
        return;
    if (import_texture_name(r->import, r->material, aiTextureType_HEIGHT, &name))
        r->status = import_warn(r->import, "bump map %.200s is ignored", name.data);
    if (r->status || !import_texture_name(r->import, r->material, aiTextureType_NORMALS, &name))
        return;
    map.nested[0] = *bsdf;
    map.tangents = r->out->wants_uvs = true;
    r->status = import_bitmap(r->import, &texture, name.data, IMPORT_RAW, 0, &map.weight);
    if (!r->status)
        r->status = import_add_bsdf(r->import, &map, bsdf);
}

int import_mtl_material(struct import *import, const struct aiMaterial *material,
                        struct import_material *out) {
    struct reader r = {.import = import, .material = material, .out = out};
    const struct vec3 black = {0, 0, 0};
    struct vec3 diffuse =
        import_color(import, material, AI_MATKEY_COLOR_DIFFUSE, vec(0.6f, 0.6f, 0.6f));
    struct vec3 specular = import_color(import, material, AI_MATKEY_COLOR_SPECULAR, black);
    struct vec3 emission = import_color(import, material, AI_MATKEY_COLOR_EMISSIVE, black);
    float exponent = import_number(import, material, AI_MATKEY_SHININESS, 0);
    float opacity = import_number(import, material, AI_MATKEY_OPACITY, 1);
    float ior = import_number(import, material, AI_MATKEY_REFRACTI, 1);
    int illum = import_integer(import, material, MATKEY_ILLUM, 1);
    bool shiny = illum >= 2 && max_component(specular) > 0 && exponent > 0;
    struct bsdf bsdf;
    *out = (struct import_material){.done = true, .bsdf = -1, .emission = -1};

    if (is_metallic(import, material))
        bsdf = read_principled(&r, diffuse);
    else if (is_glass(illum, opacity, ior))
        bsdf = read_glass(&r, ior);
    else if (shiny && (illum == 3 || illum == 5) && max_component(diffuse) < 0.001f)
        bsdf = read_mirror(&r, specular, exponent);
    else if (shiny)
        bsdf = read_plastic(&r, diffuse, specular, exponent);
    else
        bsdf = read_diffuse(&r, diffuse);
    if (!r.status)
        r.status = import_add_bsdf(import, &bsdf, &out->bsdf);
    add_normal_map(&r, &out->bsdf);
    if (bsdf.kind != BSDF_DIELECTRIC) {
        if (!r.status)
            r.status = import_add_twosided(import, &out->bsdf);
        add_opacity(&r, opacity, &out->bsdf);
    }
    if (max_component(emission) > 0)
        read_color(&r, aiTextureType_EMISSIVE, emission, &out->emission);
    return r.status;
}
