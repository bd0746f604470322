/* SPDX-License-Identifier: Apache-2.0 */
/* Shapes, with their BSDF and emitter. */

#include <string.h>

#include "guide/scene/memory.h"
#include "guide/scene/params.h"

static int parse_file_shape(struct loader *loader, struct xml_node *node, enum asset_kind kind,
                            struct shape *shape) {
    const char *filename = NULL;
    int part = 0;
    shape->kind = SHAPE_FILE;
    /* OBJ counts v from the image's bottom, Mitsuba from its top. */
    shape->flip_v = kind == ASSET_OBJ;
    int status = param_string(loader, node, "filename", &filename);
    if (!status)
        status = param_boolean(loader, node, "face_normals", &shape->face_normals);
    if (!status)
        status = kind == ASSET_SERIALIZED
                     ? param_integer(loader, node, "shape_index", 0, &part)
                     : param_boolean(loader, node, "flip_tex_coords", &shape->flip_v);
    if (status)
        return status;
    if (!filename || !*filename)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "the shape has no filename");
    shape->name = filename;
    return assets_add_part(loader, kind, filename, part, node, &shape->asset);
}

static int param_radius(struct loader *loader, struct xml_node *node, double *radius) {
    *radius = 1;
    int status = param_float(loader, node, "radius", radius);
    if (!status && !(*radius > 0))
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(node, "radius"),
                             "radius = %g must be positive", *radius);
    return status;
}

/* center and radius come before to_world. */
static int parse_sphere(struct loader *loader, struct xml_node *node, struct shape *shape) {
    double center[3] = {0, 0, 0}, radius;
    int status = param_point(loader, node, "center", center);
    if (!status)
        status = param_radius(loader, node, &radius);
    if (status)
        return status;
    const struct transform place = {
        {{radius, 0, 0, center[0]}, {0, radius, 0, center[1]}, {0, 0, radius, center[2]}}};
    shape->kind = SHAPE_SPHERE;
    shape->to_world = transform_multiply(&shape->to_world, &place);
    return FEWRAY_OK;
}

/* The unit cylinder's x and y axes are across the line from p0 to p1 as Mitsuba has them: Duff et
 * al. 2017, "Building an Orthonormal Basis, Revisited". */
static int parse_cylinder(struct loader *loader, struct xml_node *node, struct shape *shape) {
    double p0[3] = {0, 0, 0}, p1[3] = {0, 0, 1}, radius, axis[3];
    int status = param_point(loader, node, "p0", p0);
    if (!status)
        status = param_point(loader, node, "p1", p1);
    if (!status)
        status = param_radius(loader, node, &radius);
    if (status)
        return status;
    for (int i = 0; i < 3; i++)
        axis[i] = p1[i] - p0[i];
    double l = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    if (!(l > 0))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node,
                           "p0 and p1 of the cylinder are the same point");
    double x = axis[0] / l, y = axis[1] / l, z = axis[2] / l;
    double sign = copysign(1, z), a = -1 / (sign + z), b = x * y * a;
    const double s[3] = {1 + sign * x * x * a, sign * b, -sign * x};
    const double t[3] = {b, sign + y * y * a, -y};
    struct transform place;
    for (int i = 0; i < 3; i++) {
        const double row[4] = {radius * s[i], radius * t[i], axis[i], p0[i]};
        memcpy(place.m[i], row, sizeof(row));
    }
    shape->kind = SHAPE_CYLINDER;
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
    if (!strcmp(type, "obj"))
        return parse_file_shape(loader, node, ASSET_OBJ, shape);
    if (!strcmp(type, "ply"))
        return parse_file_shape(loader, node, ASSET_PLY, shape);
    if (!strcmp(type, "serialized"))
        return parse_file_shape(loader, node, ASSET_SERIALIZED, shape);
    if (!strcmp(type, "sphere"))
        return parse_sphere(loader, node, shape);
    if (!strcmp(type, "cylinder"))
        return parse_cylinder(loader, node, shape);
    if (!strcmp(type, "rectangle"))
        shape->kind = SHAPE_RECTANGLE;
    else if (!strcmp(type, "disk"))
        shape->kind = SHAPE_DISK;
    else if (!strcmp(type, "cube"))
        shape->kind = SHAPE_CUBE;
    else
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, node,
                           "shape '%s' is not supported: convert it to ply or obj", type);
    return FEWRAY_OK;
}

static int set_emitter(struct loader *loader, struct xml_node *emitter, struct shape *shape) {
    if (shape->has_emitter)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter, "the shape has two emitters");
    if (shape->group >= 0)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter,
                           "a shape of a shapegroup can't shine: place it without an instance");
    shape->has_emitter = true;
    return parse_area_emitter(loader, emitter, &shape->emission);
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
    int *index = shape->has_emitter ? &loader->black_bsdf : &loader->default_bsdf;
    int status =
        *index < 0 ? make_grey_bsdf(loader, shape->has_emitter ? 0 : 0.5f, index) : FEWRAY_OK;
    shape->bsdf = *index;
    return status;
}

int parse_mesh_shape(struct loader *loader, struct xml_node *node, int group) {
    struct shape shape = {.node = node,
                          .name = xml_attribute(node, "type"),
                          .group = group,
                          .bsdf = -1,
                          .emission = -1};
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
    if (!array_reserve((void **)&loader->shapes, &loader->shape_capacity, loader->shape_count + 1,
                       sizeof(*loader->shapes)))
        return loader_fail_memory(loader);
    loader->shapes[loader->shape_count++] = shape;
    return FEWRAY_OK;
}

int parse_shape(struct loader *loader, struct xml_node *node) {
    const char *type = xml_attribute(node, "type");
    int group;
    if (!strcmp(type, "shapegroup"))
        return parse_group(loader, node, &group);
    if (!strcmp(type, "instance"))
        return parse_instance(loader, node);
    return parse_mesh_shape(loader, node, -1);
}
