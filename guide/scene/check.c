/* SPDX-License-Identifier: Apache-2.0 */
/* Refuses elements, plugin types and values that Mitsuba 3 wouldn't take, before any of them is
 * used. */

#include <string.h>

#include "guide/scene/number.h"
#include "guide/scene/params.h"
#include "guide/scene/plugins.h"
#include "guide/scene/transform.h"

static int check_object(struct loader *loader, const struct xml_node *node) {
    const char *type = xml_attribute(node, "type");
    if (!type || !*type)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "<%s> has no type", node->tag);
    if (!plugin_is_known(node->tag, type))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node,
                           "unknown %s type '%s': Mitsuba 3 has no such plugin", node->tag, type);
    if (!strcmp(node->tag, "medium") && !loader->lenient)
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, node,
                           "medium '%s' is not supported yet (--lenient leaves it out)", type);
    return FEWRAY_OK;
}

static int check_name(struct loader *loader, const struct xml_node *node) {
    const char *name = xml_attribute(node, "name");
    if (!name || !*name)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "<%s> has no name", node->tag);
    return FEWRAY_OK;
}

/* Two parameters of the same name: Mitsuba refuses them too. */
static int check_duplicates(struct loader *loader, const struct xml_node *plugin) {
    for (const struct xml_node *a = plugin->first_child; a; a = a->next) {
        const char *name = xml_attribute(a, "name");
        if (!name || element_kind(a->tag) == ELEMENT_DEFAULT)
            continue;
        for (const struct xml_node *b = plugin->first_child; b != a; b = b->next) {
            const char *earlier = xml_attribute(b, "name");
            if (earlier && element_kind(b->tag) != ELEMENT_DEFAULT && !strcmp(name, earlier))
                return loader_fail(loader, FEWRAY_ERROR_FORMAT, a,
                                   "parameter %s is given twice (first in line %d)", name, b->line);
        }
    }
    return FEWRAY_OK;
}

/* Where an element stands: only transforms hold operations, and values hold nothing. */
static int check_place(struct loader *loader, const struct xml_node *node) {
    enum element_kind parent = element_kind(node->parent->tag), kind = element_kind(node->tag);
    bool in_transform = parent == ELEMENT_TRANSFORM;
    if (parent == ELEMENT_ANIMATION && kind == ELEMENT_TRANSFORM)
        return FEWRAY_OK;
    if (kind == ELEMENT_ANIMATION && strcmp(node->parent->tag, "sensor"))
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, node,
                           "only a sensor can be animated, by its to_world");
    bool in_object = xml_attribute(node->parent, "type") || node->parent == loader->document->root;
    if (kind != ELEMENT_DEFAULT &&
        ((kind == ELEMENT_OPERATION) != in_transform || !(in_transform || in_object)))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "<%s> can't stand within <%s>",
                           node->tag, node->parent->tag);
    return FEWRAY_OK;
}

static int check_node(struct loader *loader, const struct xml_node *node) {
    struct transform unused;
    double time;
    int status = check_place(loader, node);
    if (status)
        return status;
    switch (element_kind(node->tag)) {
    case ELEMENT_OBJECT:
        return check_object(loader, node);
    case ELEMENT_PROPERTY:
        status = check_name(loader, node);
        if (status)
            return status;
        /* A spectrum is a value or a plugin. */
        if (!strcmp(node->tag, "spectrum") && xml_attribute(node, "type"))
            return check_object(loader, node);
        return param_check(loader, node);
    case ELEMENT_ANIMATION:
        return check_name(loader, node);
    case ELEMENT_TRANSFORM:
        status = element_kind(node->parent->tag) == ELEMENT_ANIMATION
                     ? check_key_time(loader, node, &time)
                     : check_name(loader, node);
        return status ? status : transform_parse(loader, node, &unused);
    case ELEMENT_REFERENCE:
        if (!xml_attribute(node, "id"))
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "<ref> has no id");
        return FEWRAY_OK;
    case ELEMENT_UNKNOWN:
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "unknown element <%s>", node->tag);
    default:
        return FEWRAY_OK;
    }
}

static int check_children(struct loader *loader, const struct xml_node *node) {
    for (const struct xml_node *child = node->first_child; child; child = child->next) {
        int status = check_node(loader, child);
        if (!status && child->first_child)
            status = check_children(loader, child);
        if (status)
            return status;
    }
    /* The scene itself has no parameters, but may have thousands of children. */
    return node->parent ? check_duplicates(loader, node) : FEWRAY_OK;
}

int check_elements(struct loader *loader) {
    const struct xml_node *root = loader->document->root;
    const char *version = xml_attribute(root, "version");
    double number = 0;
    if (strcmp(root->tag, "scene"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, root,
                           "not a Mitsuba scene: it starts with <%s>", root->tag);
    if (!version)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, root, "<scene> has no version");
    if (!number_read(&version, &number) || (*version && *version != '.'))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, root,
                           "version '%s' is not a version number", xml_attribute(root, "version"));
    if (number < 3)
        return loader_fail(
            loader, FEWRAY_ERROR_UNSUPPORTED, root,
            "version %s: only Mitsuba 3 scenes are supported: convert it with Mitsuba 3",
            xml_attribute(root, "version"));
    return check_children(loader, root);
}
