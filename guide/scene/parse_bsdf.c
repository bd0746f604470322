/* SPDX-License-Identifier: Apache-2.0 */
/* BSDFs: which plugin is read by which function, and what becomes of those that aren't supported.
 */

#include "guide/scene/parse_bsdf.h"

#include <string.h>

#include "guide/scene/memory.h"

#define MAX_DEPTH 16

int add_bsdf(struct loader *loader, struct bsdf bsdf, int *index) {
    struct fewray_scene *scene = loader->scene;
    if (!array_reserve((void **)&scene->bsdfs, &loader->bsdf_capacity,
                       (size_t)scene->bsdf_count + 1, sizeof(*scene->bsdfs)))
        return loader_fail_memory(loader);
    *index = scene->bsdf_count++;
    scene->bsdfs[*index] = bsdf;
    return FEWRAY_OK;
}

int make_grey_bsdf(struct loader *loader, float reflectance, int *index) {
    struct bsdf bsdf = empty_bsdf(BSDF_DIFFUSE);
    int status = make_constant_texture(loader, vec(reflectance, reflectance, reflectance),
                                       &bsdf.reflectance);
    return status ? status : add_bsdf(loader, bsdf, index);
}

int next_nested_bsdf(struct loader *loader, struct xml_node *node, struct xml_node **nested) {
    *nested = NULL;
    for (struct xml_node *child = node->first_child; child; child = child->next) {
        struct xml_node *object;
        int status = child->used ? FEWRAY_OK : loader_resolve(loader, child, &object);
        if (status)
            return status;
        if (!child->used && object && !strcmp(object->tag, "bsdf")) {
            child->used = true;
            *nested = object;
            return FEWRAY_OK;
        }
    }
    return FEWRAY_OK;
}

static int parse_diffuse(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    return parse_reflectance(loader, node, "reflectance", vec(0.5f, 0.5f, 0.5f), &out->reflectance);
}

static int parse_null(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    (void)loader, (void)node, (void)out;
    return FEWRAY_OK;
}

static const struct {
    const char *type;
    enum bsdf_kind kind;
    int (*parse)(struct loader *, struct xml_node *, struct bsdf *);
} plugins[] = {
    {"diffuse", BSDF_DIFFUSE, parse_diffuse},
    {"plastic", BSDF_PLASTIC, parse_plastic},
    {"roughplastic", BSDF_ROUGH_PLASTIC, parse_plastic},
    {"conductor", BSDF_CONDUCTOR, parse_conductor},
    {"roughconductor", BSDF_ROUGH_CONDUCTOR, parse_conductor},
    {"dielectric", BSDF_DIELECTRIC, parse_dielectric},
    {"thindielectric", BSDF_THIN_DIELECTRIC, parse_dielectric},
    {"roughdielectric", BSDF_ROUGH_DIELECTRIC, parse_dielectric},
    {"principled", BSDF_PRINCIPLED, parse_principled},
    {"null", BSDF_NULL, parse_null},
    {"twosided", BSDF_TWOSIDED, parse_twosided},
    {"mask", BSDF_MASK, parse_mask},
    {"blendbsdf", BSDF_BLEND, parse_blend},
    {"bumpmap", BSDF_BUMP_MAP, parse_bump_map},
    {"normalmap", BSDF_NORMAL_MAP, parse_normal_map},
};

/* The id of the BSDF, or of the one around it. */
static const char *find_id(const struct xml_node *node) {
    for (; node && node->tag && !strcmp(node->tag, "bsdf"); node = node->parent)
        if (xml_attribute(node, "id"))
            return xml_attribute(node, "id");
    return NULL;
}

static int read_plugin(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    const char *type = xml_attribute(node, "type"), *id = find_id(node);
    for (size_t i = 0; i < sizeof(plugins) / sizeof(*plugins); i++)
        if (!strcmp(type, plugins[i].type)) {
            *out = empty_bsdf(plugins[i].kind);
            int status = plugins[i].parse(loader, node, out);
            return status ? status : params_finish(loader, node);
        }
    return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, node,
                       "bsdf '%s'%s%s%s is not supported yet (--lenient draws it diffuse)", type,
                       id ? " (id '" : "", id ? id : "", id ? "')" : "");
}

/* The parameter that says best how much of the light such a BSDF reflects. */
static const char *reflectance_name(struct xml_node *node) {
    static const char *const names[] = {"diffuse_reflectance", "base_color", "specular_reflectance",
                                        NULL};
    for (int i = 0; names[i]; i++)
        if (param_find(node, names[i]))
            return names[i];
    return "reflectance";
}

/* What isn't supported becomes twosided: its first nested BSDF, or a diffuse one. */
static int approximate(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    struct xml_node *nested;
    const char *id = find_id(node);
    struct bsdf inner = empty_bsdf(BSDF_DIFFUSE);
    int status =
        loader_warn(loader, node, "bsdf '%s'%s%s%s is rendered as diffuse",
                    xml_attribute(node, "type"), id ? " (id '" : "", id ? id : "", id ? "')" : "");
    for (struct xml_node *child = node->first_child; child; child = child->next)
        child->used = false;
    if (!status)
        status = next_nested_bsdf(loader, node, &nested);
    if (status)
        return status;
    *out = empty_bsdf(BSDF_TWOSIDED);
    if (nested)
        status = parse_bsdf(loader, nested, &out->nested[0]);
    else
        status = parse_reflectance(loader, node, reflectance_name(node), vec(0.5f, 0.5f, 0.5f),
                                   &inner.reflectance);
    if (!nested && !status)
        status = add_bsdf(loader, inner, &out->nested[0]);
    if (!status)
        out->tangents = loader->scene->bsdfs[out->nested[0]].tangents;
    params_ignore_all(node);
    return status;
}

int parse_bsdf(struct loader *loader, struct xml_node *node, int *index) {
    struct bsdf bsdf = empty_bsdf(BSDF_DIFFUSE);
    if (node->index >= 0) {
        *index = node->index;
        return FEWRAY_OK;
    }
    if (node->busy)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "bsdf '%s' refers to itself",
                           find_id(node) ? find_id(node) : xml_attribute(node, "type"));
    if (loader->bsdf_depth == MAX_DEPTH)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "BSDFs are nested deeper than %d",
                           MAX_DEPTH);
    node->busy = true;
    loader->bsdf_depth++;
    int status = read_plugin(loader, node, &bsdf);
    if (status == FEWRAY_ERROR_UNSUPPORTED && loader->lenient)
        status = approximate(loader, node, &bsdf);
    loader->bsdf_depth--;
    node->busy = false;
    if (!status)
        status = add_bsdf(loader, bsdf, &node->index);
    *index = node->index;
    return status;
}
