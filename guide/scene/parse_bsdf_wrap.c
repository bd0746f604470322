/* SPDX-License-Identifier: Apache-2.0 */
/* BSDFs that change or join others: twosided, mask, blendbsdf, bumpmap and normalmap. */

#include <string.h>

#include "guide/scene/parse_bsdf.h"

/* Reads the nested BSDFs, least..most of them, into out->nested. */
static int parse_nested(struct loader *loader, struct xml_node *node, int least, int most,
                        struct bsdf *out) {
    struct xml_node *nested;
    for (int i = 0; i <= most; i++) {
        int status = next_nested_bsdf(loader, node, &nested);
        if (status)
            return status;
        if (!nested && i == 0)
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "%s has no BSDF inside",
                               xml_attribute(node, "type"));
        if (!nested && i < least)
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "%s needs %d BSDFs inside",
                               xml_attribute(node, "type"), least);
        if (!nested)
            break;
        if (i == most)
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, nested,
                               "%s takes at most %d BSDF%s inside", xml_attribute(node, "type"),
                               most, most > 1 ? "s" : "");
        status = parse_bsdf(loader, nested, &out->nested[i]);
        if (status)
            return status;
        out->tangents |= loader->scene->bsdfs[out->nested[i]].tangents;
    }
    return FEWRAY_OK;
}

/* Whether light gets through it. */
static bool transmits(const struct fewray_scene *scene, int index) {
    const struct bsdf *bsdf = &scene->bsdfs[index];
    switch (bsdf->kind) {
    case BSDF_DIELECTRIC:
    case BSDF_THIN_DIELECTRIC:
    case BSDF_ROUGH_DIELECTRIC:
    case BSDF_NULL:
    case BSDF_MASK:
        return true;
    case BSDF_PRINCIPLED:
        return bsdf->principled[PRINCIPLED_SPEC_TRANS] >= 0;
    default:
        return (bsdf->nested[0] >= 0 && transmits(scene, bsdf->nested[0])) ||
               (bsdf->nested[1] >= 0 && transmits(scene, bsdf->nested[1]));
    }
}

int parse_twosided(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    int status = parse_nested(loader, node, 1, 2, out);
    for (int i = 0; i < 2 && !status; i++)
        if (out->nested[i] >= 0 && transmits(loader->scene, out->nested[i]))
            status = loader_fail(loader, FEWRAY_ERROR_FORMAT, node,
                                 "twosided can't hold a BSDF that lets light through");
    return status;
}

/* How many plain BSDFs it joins at a point. */
static int count_parts(const struct fewray_scene *scene, int index) {
    const struct bsdf *bsdf = &scene->bsdfs[index];
    int first = bsdf->nested[0] >= 0 ? count_parts(scene, bsdf->nested[0]) : 1;
    int second = bsdf->nested[1] >= 0 ? count_parts(scene, bsdf->nested[1]) : 0;
    if (bsdf->kind == BSDF_TWOSIDED)
        return first > second ? first : second;
    return first + second;
}

static int limit_parts(struct loader *loader, const struct xml_node *node,
                       const struct bsdf *bsdf) {
    int parts =
        count_parts(loader->scene, bsdf->nested[0]) + count_parts(loader->scene, bsdf->nested[1]);
    if (parts > SHADING_LOCALS)
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, node,
                           "%s joins %d BSDFs: more than %d are not supported yet",
                           xml_attribute(node, "type"), parts, SHADING_LOCALS);
    return FEWRAY_OK;
}

int parse_mask(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    int status = parse_grey(loader, node, "opacity", 0.5f, &out->weight);
    if (!status)
        status = parse_nested(loader, node, 1, 1, out);
    if (!status && loader->null_bsdf < 0)
        status = add_bsdf(loader, empty_bsdf(BSDF_NULL), &loader->null_bsdf);
    out->nested[1] = loader->null_bsdf;
    return status ? status : limit_parts(loader, node, out);
}

int parse_blend(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    if (!param_find(node, "weight"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "blendbsdf has no weight");
    int status = parse_grey(loader, node, "weight", 0.5f, &out->weight);
    if (!status)
        status = parse_nested(loader, node, 2, 2, out);
    return status ? status : limit_parts(loader, node, out);
}

static int parse_map_options(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    int status = param_boolean(loader, node, "flip_invalid_normals", &out->flip_invalid_normals);
    return status ? status
                  : param_boolean(loader, node, "use_shadowing_function",
                                  &out->use_shadowing_function);
}

/* The only texture among the children, whatever its name. */
static int parse_height(struct loader *loader, struct xml_node *node, int *index) {
    int status = FEWRAY_OK;
    for (struct xml_node *child = node->first_child; child && !status; child = child->next) {
        struct xml_node *object;
        status = loader_resolve(loader, child, &object);
        if (status || !object || strcmp(object->tag, "texture"))
            continue;
        child->used = true;
        status = *index < 0 ? parse_texture(loader, object, index)
                            : loader_fail(loader, FEWRAY_ERROR_FORMAT, child,
                                          "bumpmap takes only one texture");
    }
    if (!status && *index < 0)
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "bumpmap has no texture inside");
    return status;
}

int parse_bump_map(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    double factor = 1;
    int status = parse_height(loader, node, &out->weight);
    if (!status)
        status = param_number(loader, node, "scale", -1e6, 1e6, &factor);
    if (!status)
        status = parse_map_options(loader, node, out);
    if (!status)
        status = parse_nested(loader, node, 1, 1, out);
    out->bump_scale = (float)factor;
    out->tangents = true;
    return status;
}

int parse_normal_map(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    if (!param_find(node, "normalmap"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "normalmap has no normalmap texture");
    int status = parse_reflectance(loader, node, "normalmap", vec(0.5f, 0.5f, 1), &out->weight);
    if (!status)
        status = parse_map_options(loader, node, out);
    if (!status)
        status = parse_nested(loader, node, 1, 1, out);
    out->tangents = true;
    return status;
}
