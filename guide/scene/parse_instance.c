/* SPDX-License-Identifier: Apache-2.0 */
/* Groups of shapes, and the instances that place them, by Mitsuba's rules of what may nest. */

#include <float.h>
#include <string.h>

#include "guide/scene/memory.h"
#include "guide/scene/params.h"

static int parse_member(struct loader *loader, struct xml_node *child, int group) {
    char text[128];
    struct xml_node *object;
    int status = loader_resolve(loader, child, &object);
    if (status || !object)
        return status;
    child->used = true;
    const char *type = xml_attribute(object, "type");
    if (strcmp(object->tag, "shape"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, child,
                           "%s can't stand within a shapegroup: only shapes can",
                           loader_describe(object, text));
    if (!strcmp(type, "shapegroup") || !strcmp(type, "instance"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, child,
                           "%s can't stand within a shapegroup: instances don't nest",
                           loader_describe(object, text));
    return parse_mesh_shape(loader, object, group);
}

int parse_group(struct loader *loader, struct xml_node *node, int *group) {
    int status = FEWRAY_OK;
    if (node->index < 0) {
        node->index = loader->scene->group_count++;
        for (struct xml_node *child = node->first_child; child && !status; child = child->next)
            status = parse_member(loader, child, node->index);
        if (!status)
            status = params_finish(loader, node);
    }
    *group = node->index;
    return status;
}

/* The group among the instance's children. */
static int find_group(struct loader *loader, struct xml_node *node, int *group) {
    *group = -1;
    for (struct xml_node *child = node->first_child; child; child = child->next) {
        char text[128];
        struct xml_node *object;
        int status = loader_resolve(loader, child, &object);
        if (status)
            return status;
        if (!object)
            continue;
        child->used = true;
        if (strcmp(object->tag, "shape") || strcmp(xml_attribute(object, "type"), "shapegroup"))
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, child,
                               "%s can't stand within an instance: only a shapegroup can",
                               loader_describe(object, text));
        if (*group >= 0)
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, child,
                               "the instance has two shapegroups");
        status = parse_group(loader, object, group);
        if (status)
            return status;
    }
    if (*group < 0)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "the instance has no shapegroup");
    return FEWRAY_OK;
}

/* Rays go back by the inverse. */
static bool is_invertible(const struct transform *t) {
    double size = 0, determinant = fabs(transform_determinant(t));
    for (int i = 0; i < 9; i++)
        size = fmax(size, fabs(t->m[i / 3][i % 3]));
    return determinant > FLT_MIN && determinant > 1e-18 * size * size * size;
}

int parse_instance(struct loader *loader, struct xml_node *node) {
    struct fewray_scene *scene = loader->scene;
    struct instance instance;
    struct transform to_world;
    int status = param_transform(loader, node, "to_world", &to_world);
    if (!status && !is_invertible(&to_world))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(node, "to_world"),
                           "the instance's to_world can't be inverted");
    if (!status)
        status = find_group(loader, node, &instance.group);
    if (!status)
        status = params_finish(loader, node);
    if (status)
        return status;
    for (int i = 0; i < 12; i++)
        instance.to_world[i] = (float)to_world.m[i / 4][i % 4];
    if (!array_reserve((void **)&scene->instances, &loader->instance_capacity,
                       (size_t)scene->instance_count + 1, sizeof(*scene->instances)))
        return loader_fail_memory(loader);
    scene->instances[scene->instance_count++] = instance;
    return FEWRAY_OK;
}
