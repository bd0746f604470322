/* SPDX-License-Identifier: Apache-2.0 */
/* Rays against a stage's shapes, by brute force. */

#include "guide/train/scenes/preview.h"

static float plane_hit(enum shape_kind kind, struct vec3 o, struct vec3 d) {
    float t = -o.z / d.z;
    float x = o.x + t * d.x, y = o.y + t * d.y;
    bool inside = kind == SHAPE_DISK ? x * x + y * y <= 1 : fabsf(x) <= 1 && fabsf(y) <= 1;
    return inside && t > 0 ? t : -1;
}

static float cube_hit(struct vec3 o, struct vec3 d, float least) {
    float from[3] = {o.x, o.y, o.z}, along[3] = {d.x, d.y, d.z}, enter = -1e30f, leave = 1e30f;
    for (int i = 0; i < 3; i++) {
        float inverse = 1 / along[i], a = (-1 - from[i]) * inverse, b = (1 - from[i]) * inverse;
        enter = fmaxf(enter, fminf(a, b));
        leave = fminf(leave, fmaxf(a, b));
    }
    if (!(enter <= leave))
        return -1;
    return enter > least ? enter : leave;
}

static float sphere_hit(struct vec3 o, struct vec3 d, float least) {
    float a = dot(d, d), b = dot(o, d), c = dot(o, o) - 1, discriminant = b * b - a * c;
    if (discriminant < 0)
        return -1;
    float root = sqrtf(discriminant), first = (-b - root) / a;
    return first > least ? first : (-b + root) / a;
}

/* Of the infinite cylinder's two hits the first within z = 0..1. */
static float cylinder_hit(struct vec3 o, struct vec3 d, float least) {
    float a = d.x * d.x + d.y * d.y, b = o.x * d.x + o.y * d.y, c = o.x * o.x + o.y * o.y - 1;
    float discriminant = b * b - a * c;
    if (discriminant < 0 || a == 0)
        return -1;
    float root = sqrtf(discriminant);
    for (int side = -1; side <= 1; side += 2) {
        float t = (-b + (float)side * root) / a, z = o.z + t * d.z;
        if (t > least && z >= 0 && z <= 1)
            return t;
    }
    return -1;
}

struct vec3 preview_normal(const struct shape *shape, struct vec3 local) {
    struct vec3 n = vec(0, 0, 1);
    if (shape->kind == SHAPE_SPHERE)
        n = local;
    if (shape->kind == SHAPE_CYLINDER)
        n = vec(local.x, local.y, 0);
    if (shape->kind == SHAPE_CUBE) {
        float x = fabsf(local.x), y = fabsf(local.y), z = fabsf(local.z);
        n = x > y && x > z ? vec(local.x, 0, 0) : y > z ? vec(0, local.y, 0) : vec(0, 0, local.z);
    }
    return normalize(xform_vector(&shape->to_world, n));
}

static float shape_hit(const struct stage *stage, const struct shape *shape, struct vec3 o,
                       struct vec3 d, float least, struct vec3 *mesh_normal) {
    switch (shape->kind) {
    case SHAPE_CUBE:
        return cube_hit(o, d, least);
    case SHAPE_SPHERE:
        return sphere_hit(o, d, least);
    case SHAPE_CYLINDER:
        return cylinder_hit(o, d, least);
    case SHAPE_MESH:
        return mesh_hit(stage->meshes[shape->mesh], o, d, least, mesh_normal);
    default:
        return plane_hit(shape->kind, o, d);
    }
}

bool preview_hit(const struct stage *stage, struct vec3 origin, struct vec3 dir, float farthest,
                 bool see_glass, struct hit *hit) {
    float least = 1e-4f * (1 + fmaxf(fabsf(origin.x), fmaxf(fabsf(origin.y), fabsf(origin.z)))),
          nearest = farthest;
    int found = -1;
    struct vec3 triangle = vec(0, 1, 0), mesh_normal = triangle; /* of the nearest, of this */
    for (int i = 0; i < stage->shape_count; i++) {
        const struct shape *shape = &stage->shapes[i];
        struct vec3 to = sub(shape->center, origin);
        float along = dot(to, dir), reach = shape->radius;
        if (dot(to, to) - along * along > reach * reach || along + reach < 0 ||
            along - reach > nearest)
            continue;
        struct vec3 o = xform_point(&shape->to_local, origin),
                    d = xform_vector(&shape->to_local, dir);
        if (!see_glass && material_transmits(&stage->materials[shape->material]))
            continue;
        float t = shape_hit(stage, shape, o, d, least, &mesh_normal);
        if (t > least && t < nearest)
            nearest = t, found = i, triangle = mesh_normal;
    }
    if (found < 0)
        return false;
    if (hit) {
        const struct shape *shape = &stage->shapes[found];
        hit->distance = nearest;
        hit->position = add(origin, scale(dir, nearest));
        hit->shape = found;
        hit->normal = shape->kind == SHAPE_MESH
                          ? normalize(xform_vector(&shape->to_world, triangle))
                          : preview_normal(shape, xform_point(&shape->to_local, hit->position));
    }
    return true;
}
