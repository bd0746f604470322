/* SPDX-License-Identifier: Apache-2.0 */
/* Conductors, dielectrics and plastics, smooth and rough. */

#include <string.h>
#include <strings.h>

#include "guide/scene/materials.h"
#include "guide/scene/parse_bsdf.h"

static const struct vec3 white = {1, 1, 1};

/* An index of refraction as a number or by a material's name. */
static int parse_ior(struct loader *loader, struct xml_node *node, const char *name,
                     const char *fallback, double *ior) {
    struct xml_node *parameter = param_find(node, name);
    dielectric_find(fallback, ior);
    if (!parameter)
        return FEWRAY_OK;
    if (strcmp(parameter->tag, "string"))
        return param_number(loader, node, name, 1e-3, 1e3, ior);
    const char *material = "";
    int status = param_string(loader, node, name, &material);
    if (!status && !dielectric_find(material, ior))
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, parameter,
                             "%s = '%s' is no material whose index of refraction Mitsuba 3 knows",
                             name, material);
    return status;
}

static int parse_eta(struct loader *loader, struct xml_node *node, const char *inside,
                     struct bsdf *out) {
    double interior, exterior;
    int status = parse_ior(loader, node, "int_ior", inside, &interior);
    if (!status)
        status = parse_ior(loader, node, "ext_ior", "air", &exterior);
    if (!status)
        out->eta = (float)(interior / exterior);
    return status;
}

static int parse_distribution(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    static const char *const ignored[] = {"sample_visible", NULL};
    const char *name = "beckmann";
    int status = param_string(loader, node, "distribution", &name);
    params_ignore(node, ignored);
    if (status)
        return status;
    if (strcasecmp(name, "beckmann") && strcasecmp(name, "ggx"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(node, "distribution"),
                           "distribution = '%s' should be beckmann or ggx", name);
    out->microfacets = strcasecmp(name, "ggx") ? MICROFACET_BECKMANN : MICROFACET_GGX;
    return FEWRAY_OK;
}

/* alpha, or alpha_u and alpha_v. */
static int parse_roughness(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    bool u = param_find(node, "alpha_u"), v = param_find(node, "alpha_v");
    int status = parse_distribution(loader, node, out);
    if (!status && (u != v || (u && param_find(node, "alpha"))))
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, node,
                             "give either alpha, or both alpha_u and alpha_v");
    if (!status)
        status = parse_grey(loader, node, u ? "alpha_u" : "alpha", 0.1f, &out->alpha_u);
    if (!status)
        status = parse_grey(loader, node, v ? "alpha_v" : "alpha", 0.1f, &out->alpha_v);
    out->tangents = out->alpha_u != out->alpha_v;
    return status;
}

/* eta or k as a colour. Colours out of the gamut have negative components; only their squares
 * count. */
static int parse_index(struct loader *loader, struct xml_node *node, const char *name,
                       struct vec3 *out) {
    struct xml_node *parameter = param_find(node, name), *object;
    int status = parameter ? loader_resolve(loader, parameter, &object) : FEWRAY_OK;
    if (!parameter || status)
        return status;
    if (object)
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, parameter,
                           "%s: a texture is not supported here yet: give an <rgb>", name);
    status = param_color(loader, parameter, COLOR_SIGNED, out);
    *out = vec(fabsf(out->x), fabsf(out->y), fabsf(out->z));
    return status;
}

int parse_conductor(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    const char *material = "none";
    struct xml_node *named = param_find(node, "material");
    int status = param_string(loader, node, "material", &material);
    if (status)
        return status;
    if (named && (param_find(node, "eta") || param_find(node, "k")))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, named,
                           "both a material and eta or k are given");
    if (!metal_find(material, &out->conductor_eta, &out->conductor_k))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, named,
                           "material = '%s' is no metal that Mitsuba 3 knows", material);
    status = parse_index(loader, node, "eta", &out->conductor_eta);
    if (!status)
        status = parse_index(loader, node, "k", &out->conductor_k);
    if (!status)
        status = parse_reflectance(loader, node, "specular_reflectance", white,
                                   &out->specular_reflectance);
    if (!status && out->kind == BSDF_ROUGH_CONDUCTOR)
        status = parse_roughness(loader, node, out);
    return status;
}

int parse_dielectric(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    int status = parse_eta(loader, node, "bk7", out);
    if (!status)
        status = parse_reflectance(loader, node, "specular_reflectance", white,
                                   &out->specular_reflectance);
    if (!status)
        status = parse_reflectance(loader, node, "specular_transmittance", white,
                                   &out->specular_transmittance);
    if (status || out->kind != BSDF_ROUGH_DIELECTRIC)
        return status;
    if (out->eta == 1)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node,
                           "int_ior and ext_ior of a roughdielectric must differ");
    return parse_roughness(loader, node, out);
}

int parse_plastic(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    double alpha = 0.1;
    int status = parse_eta(loader, node, "polypropylene", out);
    if (!status)
        status = parse_reflectance(loader, node, "diffuse_reflectance", vec(0.5f, 0.5f, 0.5f),
                                   &out->reflectance);
    if (!status)
        status = parse_reflectance(loader, node, "specular_reflectance", white,
                                   &out->specular_reflectance);
    if (!status)
        status = param_boolean(loader, node, "nonlinear", &out->nonlinear);
    if (status || out->kind == BSDF_PLASTIC)
        return status;
    /* One number, as the transmittance through the coat is tabulated beforehand. */
    status = param_number(loader, node, "alpha", 0, 1e3, &alpha);
    if (!status)
        status = parse_distribution(loader, node, out);
    if (!status)
        status = make_constant_texture(loader, vec((float)alpha, (float)alpha, (float)alpha),
                                       &out->alpha_u);
    out->alpha_v = out->alpha_u;
    return status;
}
