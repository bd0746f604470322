/* SPDX-License-Identifier: Apache-2.0 */
/* The scene's children in the file's order, and the integrator. */

#include <string.h>

#include "guide/scene/params.h"

static bool is_one_of(const char *text, const char *const *names) {
    for (; *names; names++)
        if (!strcmp(text, *names))
            return true;
    return false;
}

static struct xml_node *find_nested_integrator(struct xml_node *node) {
    for (struct xml_node *child = node->first_child; child; child = child->next)
        if (!strcmp(child->tag, "integrator")) {
            child->used = true;
            return child;
        }
    return NULL;
}

static int parse_path_integrator(struct loader *loader, struct xml_node *integrator) {
    bool hide_emitters = false;
    int status = param_integer(loader, integrator, "max_depth", -1, &loader->scene->max_depth);
    if (!status)
        status = param_integer(loader, integrator, "rr_depth", 1, &loader->scene->rr_depth);
    if (!status && loader->scene->max_depth == 0)
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(integrator, "max_depth"),
                             "max_depth = 0 renders nothing: give -1 (no limit) or at least 1");
    if (!status)
        status = param_boolean(loader, integrator, "hide_emitters", &hide_emitters);
    if (!status && hide_emitters)
        status = loader_warn(loader, integrator, "hide_emitters is not supported yet: they show");
    return status ? status : params_finish(loader, integrator);
}

/* Direct light is a path of two segments. */
static int parse_direct_integrator(struct loader *loader, struct xml_node *integrator) {
    loader->scene->max_depth = 2;
    params_ignore_all(integrator);
    return FEWRAY_OK;
}

static int parse_integrator(struct loader *loader, struct xml_node *integrator) {
    static const char *const volume_paths[] = {"volpath", "volpathmis", NULL};
    static const char *const wrappers[] = {"aov", "moment", NULL};
    const char *type = xml_attribute(integrator, "type");
    if (!strcmp(type, "path"))
        return parse_path_integrator(loader, integrator);
    if (!strcmp(type, "direct"))
        return parse_direct_integrator(loader, integrator);
    /* Without media, which are refused or left out elsewhere, they are the same. */
    if (is_one_of(type, volume_paths))
        return parse_path_integrator(loader, integrator);
    if (is_one_of(type, wrappers) && loader->lenient) {
        struct xml_node *nested = find_nested_integrator(integrator);
        if (!nested)
            return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, integrator,
                               "integrator '%s' without one inside is not supported", type);
        int status =
            loader_warn(loader, integrator, "integrator '%s': its layers are not written", type);
        params_ignore_all(integrator);
        return status ? status : parse_integrator(loader, nested);
    }
    return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, integrator,
                       "integrator '%s' is not supported yet: use path%s", type,
                       is_one_of(type, wrappers) ? ", or --lenient for the one inside" : "");
}

/* Sensors and integrators count once: the first is taken, as in Mitsuba. */
static int parse_first(struct loader *loader, struct xml_node *node, struct xml_node **first,
                       int (*parse)(struct loader *, struct xml_node *)) {
    if (*first)
        return loader_warn(loader, node, "another %s: only the first is used", node->tag);
    *first = node;
    return parse(loader, node);
}

int parse_scene(struct loader *loader) {
    struct xml_node *sensor = NULL, *integrator = NULL, *root = loader->document->root;
    for (struct xml_node *child = root->first_child; child; child = child->next) {
        struct xml_node *object;
        int status = loader_resolve(loader, child, &object);
        if (status)
            return status;
        child->used = true;
        if (!object)
            child->used = !strcmp(child->tag, "default");
        else if (!strcmp(object->tag, "sensor"))
            status = parse_first(loader, object, &sensor, parse_sensor);
        else if (!strcmp(object->tag, "integrator"))
            status = parse_first(loader, object, &integrator, parse_integrator);
        else if (!strcmp(object->tag, "shape"))
            status = parse_shape(loader, object);
        else if (!strcmp(object->tag, "emitter"))
            status = parse_emitter(loader, object);
        else
            /* BSDFs and textures are read where a shape refers to them; unused ones cost nothing.
             */
            child->used = is_one_of(object->tag, (const char *const[]){"bsdf", "texture", "film",
                                                                       "sampler", "rfilter", NULL});
        if (status)
            return status;
        if (!child->used)
            status = loader_warn(loader, child, "element %s is not used", child->tag);
        if (status)
            return status;
    }
    if (!sensor)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, root, "the scene has no sensor");
    return FEWRAY_OK;
}
