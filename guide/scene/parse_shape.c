/* SPDX-License-Identifier: Apache-2.0 */
/* Shapes, with their BSDF and emitter. */

#include <string.h>

#include "guide/scene/memory.h"
#include "guide/scene/params.h"

static int parse_file_shape(struct loader *loader, struct xml_node *node, struct shape *shape) {
    const char *filename = NULL;
    bool is_obj = !strcmp(xml_attribute(node, "type"), "obj");
    shape->kind = SHAPE_FILE;
    shape->flip_v = is_obj; /* OBJ counts v from the image's bottom, Mitsuba from its top */
    int status = param_string(loader, node, "filename", &filename);
    if (!status)
        status = param_boolean(loader, node, "face_normals", &shape->face_normals);
    if (!status)
        status = param_boolean(loader, node, "flip_tex_coords", &shape->flip_v);
    if (status)
        return status;
    if (!filename || !*filename)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "the shape has no filename");
    shape->name = filename;
    return assets_add(loader, is_obj ? ASSET_OBJ : ASSET_PLY, filename, node, &shape->asset);
}

/* center and radius come before to_world. */
static int parse_sphere(struct loader *loader, struct xml_node *node, struct shape *shape) {
    double center[3] = {0, 0, 0}, radius = 1;
    int status = param_point(loader, node, "center", center);
    if (!status)
        status = param_float(loader, node, "radius", &radius);
    if (status)
        return status;
    if (!(radius > 0))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(node, "radius"),
                           "radius = %g must be positive", radius);
    const struct transform place = {
        {{radius, 0, 0, center[0]}, {0, radius, 0, center[1]}, {0, 0, radius, center[2]}}};
    shape->kind = SHAPE_SPHERE;
    shape->to_world = transform_multiply(&shape->to_world, &place);
    return FEWRAY_OK;
}

static int parse_geometry(struct loader *loader, struct xml_node *node, struct shape *shape) {
    const char *type = xml_attribute(node, "type");
    int status = param_transform(loader, node, "to_world", &shape->to_world);
    if (!status)
        status = param_boolean(loader, node, "flip_normals", &shape->flip_normals);
    if (status)
        return status;
    if (!strcmp(type, "obj") || !strcmp(type, "ply"))
        return parse_file_shape(loader, node, shape);
    if (!strcmp(type, "sphere"))
        return parse_sphere(loader, node, shape);
    if (!strcmp(type, "rectangle"))
        shape->kind = SHAPE_RECTANGLE;
    else if (!strcmp(type, "disk"))
        shape->kind = SHAPE_DISK;
    else if (!strcmp(type, "cube"))
        shape->kind = SHAPE_CUBE;
    else
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, node,
                           "shape '%s' is not supported yet: convert it to ply or obj", type);
    return FEWRAY_OK;
}

static int set_emitter(struct loader *loader, struct xml_node *emitter, struct shape *shape) {
    if (shape->emissive)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter, "the shape has two emitters");
    shape->emissive = true;
    return parse_area_emitter(loader, emitter, &shape->radiance);
}

static int set_bsdf(struct loader *loader, struct xml_node *bsdf, struct shape *shape) {
    if (shape->bsdf >= 0)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, bsdf, "the shape has two BSDFs");
    return parse_bsdf(loader, bsdf, &shape->bsdf);
}

/* The BSDF and the emitter among the children. */
static int parse_parts(struct loader *loader, struct xml_node *node, struct shape *shape) {
    int status = FEWRAY_OK;
    for (struct xml_node *child = node->first_child; child && !status; child = child->next) {
        struct xml_node *object;
        status = loader_resolve(loader, child, &object);
        if (status || !object)
            continue;
        if (!strcmp(object->tag, "bsdf"))
            status = set_bsdf(loader, object, shape);
        else if (!strcmp(object->tag, "emitter"))
            status = set_emitter(loader, object, shape);
        else if (!strcmp(object->tag, "medium"))
            status = loader_warn(loader, child, "media are left out");
        else
            continue;
        child->used = true;
    }
    return status;
}

/* A shape without a BSDF is a grey one, and a black one where it shines; as in Mitsuba. */
static int set_default_bsdf(struct loader *loader, struct shape *shape) {
    int *index = shape->emissive ? &loader->black_bsdf : &loader->default_bsdf;
    int status = *index < 0 ? make_grey_bsdf(loader, shape->emissive ? 0 : 0.5f, index) : FEWRAY_OK;
    shape->bsdf = *index;
    return status;
}

int parse_shape(struct loader *loader, struct xml_node *node) {
    struct shape shape = {.node = node, .name = xml_attribute(node, "type"), .bsdf = -1};
    int status = parse_geometry(loader, node, &shape);
    if (!status)
        status = parse_parts(loader, node, &shape);
    if (!status && shape.bsdf < 0)
        status = set_default_bsdf(loader, &shape);
    if (!status)
        status = params_finish(loader, node);
    if (status)
        return status;
    if (xml_attribute(node, "id"))
        shape.name = xml_attribute(node, "id");
    shape.emissive = shape.emissive && max_component(shape.radiance) > 0;
    if (!array_reserve((void **)&loader->shapes, &loader->shape_capacity, loader->shape_count + 1,
                       sizeof(*loader->shapes)))
        return loader_fail_memory(loader);
    loader->shapes[loader->shape_count++] = shape;
    return FEWRAY_OK;
}
