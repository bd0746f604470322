/* SPDX-License-Identifier: Apache-2.0 */
/* BSDFs: diffuse and twosided; others of Mitsuba's as the diffuse one that comes nearest. */

#include <string.h>

#include "guide/scene/memory.h"
#include "guide/scene/params.h"

static int add_bsdf(struct loader *loader, struct bsdf bsdf, int *index) {
    struct fewray_scene *scene = loader->scene;
    if (!array_reserve((void **)&scene->bsdfs, &loader->bsdf_capacity,
                       (size_t)scene->bsdf_count + 1, sizeof(*scene->bsdfs)))
        return loader_fail_memory(loader);
    *index = scene->bsdf_count++;
    scene->bsdfs[*index] = bsdf;
    return FEWRAY_OK;
}

int make_grey_bsdf(struct loader *loader, float reflectance, int *index) {
    struct bsdf bsdf = {0};
    struct xml_node none = {.tag = (char *)"bsdf"};
    int status = parse_reflectance(loader, &none, "reflectance",
                                   vec(reflectance, reflectance, reflectance), &bsdf.reflectance);
    return status ? status : add_bsdf(loader, bsdf, index);
}

static int read_bsdf(struct loader *loader, struct xml_node *node, struct bsdf *out);

/* The first BSDF among the children that no one has used yet, or NULL. */
static int next_nested(struct loader *loader, struct xml_node *node, struct xml_node **nested) {
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
    int status =
        parse_reflectance(loader, node, "reflectance", vec(0.5f, 0.5f, 0.5f), &out->reflectance);
    return status ? status : params_finish(loader, node);
}

static int parse_twosided(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    struct xml_node *front, *back;
    int status = next_nested(loader, node, &front);
    if (status)
        return status;
    if (!front)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "twosided has no BSDF inside");
    status = read_bsdf(loader, front, out);
    if (!status)
        status = next_nested(loader, node, &back);
    if (!status && back)
        status = loader_warn(loader, node, "twosided with two BSDFs: the first is on both sides");
    if (status)
        return status;
    out->twosided = true;
    return params_finish(loader, node);
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

/* The id of the BSDF, or of the one around it. */
static const char *find_id(const struct xml_node *node) {
    for (; node && node->tag && !strcmp(node->tag, "bsdf"); node = node->parent)
        if (xml_attribute(node, "id"))
            return xml_attribute(node, "id");
    return NULL;
}

/* Shiny, transparent and layered BSDFs become twosided diffuse ones. */
static int parse_other(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    struct xml_node *nested;
    const char *id = find_id(node);
    int status =
        loader_warn(loader, node, "bsdf '%s'%s%s%s is rendered as diffuse",
                    xml_attribute(node, "type"), id ? " (id '" : "", id ? id : "", id ? "')" : "");
    if (!status)
        status = next_nested(loader, node, &nested);
    if (status)
        return status;
    status = nested ? read_bsdf(loader, nested, out)
                    : parse_reflectance(loader, node, reflectance_name(node), vec(0.5f, 0.5f, 0.5f),
                                        &out->reflectance);
    out->twosided = true;
    params_ignore_all(node);
    return status;
}

/* What a BSDF is, without a place of its own among the scene's. */
static int read_bsdf(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    const char *type = xml_attribute(node, "type");
    int status;
    if (node->index >= 0) {
        *out = loader->scene->bsdfs[node->index];
        return FEWRAY_OK;
    }
    if (node->busy)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "bsdf '%s' refers to itself",
                           find_id(node) ? find_id(node) : type);
    node->busy = true;
    if (!strcmp(type, "diffuse"))
        status = parse_diffuse(loader, node, out);
    else if (!strcmp(type, "twosided"))
        status = parse_twosided(loader, node, out);
    else
        status = parse_other(loader, node, out);
    node->busy = false;
    return status;
}

int parse_bsdf(struct loader *loader, struct xml_node *node, int *index) {
    struct bsdf bsdf = {0};
    int status = FEWRAY_OK;
    if (node->index < 0) {
        status = read_bsdf(loader, node, &bsdf);
        if (!status)
            status = add_bsdf(loader, bsdf, &node->index);
    }
    *index = node->index;
    return status;
}
