/* SPDX-License-Identifier: Apache-2.0 */
/* The generated scene's containers and the transforms that place its shapes. */

#include "guide/train/scenes/stage.h"

#include <stdlib.h>
#include <string.h>

struct xform xform_identity(void) {
    return xform_scale(1, 1, 1);
}

struct xform xform_translate(float x, float y, float z) {
    return (struct xform){{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
}

struct xform xform_scale(float x, float y, float z) {
    return (struct xform){{x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0}};
}

struct xform xform_rotate(struct vec3 a, float radians) {
    float c = cosf(radians), s = sinf(radians), k = 1 - c;
    return (struct xform){{c + a.x * a.x * k, a.x * a.y * k - a.z * s, a.x * a.z * k + a.y * s, 0,
                           a.y * a.x * k + a.z * s, c + a.y * a.y * k, a.y * a.z * k - a.x * s, 0,
                           a.z * a.x * k - a.y * s, a.z * a.y * k + a.x * s, c + a.z * a.z * k, 0}};
}

struct xform xform_multiply(struct xform a, struct xform b) {
    struct xform out;
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++) {
            const float *r = a.m + 4 * row;
            float sum = r[0] * b.m[column] + r[1] * b.m[4 + column] + r[2] * b.m[8 + column];
            out.m[4 * row + column] = column == 3 ? sum + r[3] : sum;
        }
    return out;
}

struct xform xform_inverse(struct xform a) {
    const float *m = a.m;
    struct vec3 x = vec(m[0], m[4], m[8]), y = vec(m[1], m[5], m[9]), z = vec(m[2], m[6], m[10]);
    struct vec3 rows[3] = {cross(y, z), cross(z, x), cross(x, y)};
    float scaling = 1 / dot(x, rows[0]);
    struct vec3 offset = vec(m[3], m[7], m[11]);
    struct xform out;
    for (int i = 0; i < 3; i++) {
        struct vec3 row = scale(rows[i], scaling);
        out.m[4 * i] = row.x, out.m[4 * i + 1] = row.y, out.m[4 * i + 2] = row.z;
        out.m[4 * i + 3] = -dot(row, offset);
    }
    return out;
}

struct vec3 xform_vector(const struct xform *a, struct vec3 v) {
    const float *m = a->m;
    return vec(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
               m[8] * v.x + m[9] * v.y + m[10] * v.z);
}

struct vec3 xform_point(const struct xform *a, struct vec3 p) {
    return add(xform_vector(a, p), vec(a->m[3], a->m[7], a->m[11]));
}

struct xform moved(struct xform place, float x, float y, float z, float yaw) {
    struct xform at = xform_multiply(place, xform_translate(x, y, z));
    return xform_multiply(at, xform_rotate(vec(0, 1, 0), yaw));
}

struct xform tumbled(struct random *r, struct xform place, struct vec3 at) {
    float z = uniform(r, -1, 1), azimuth = uniform(r, 0, 2 * PI_F), turn = uniform(r, 0, 2 * PI_F);
    float rho = sqrtf(fmaxf(0, 1 - z * z));
    struct vec3 axis = vec(rho * cosf(azimuth), z, rho * sinf(azimuth));
    struct xform here = xform_multiply(place, xform_translate(at.x, at.y, at.z));
    return xform_multiply(here, xform_rotate(axis, turn));
}

void stage_init(struct stage *stage, uint64_t seed, uint64_t index, uint64_t attempt) {
    memset(stage, 0, sizeof *stage);
    struct random plan = random_seed(seed, index);
    stage->plan = uniform(&plan, 0, 1);
    stage->random = random_seed(random_bits(&plan), attempt);
    stage->root = xform_identity();
    stage->surface = 1;
}

void stage_clear(struct stage *stage) {
    for (int i = 0; i < stage->mesh_count; i++)
        mesh_destroy(&stage->meshes[i]);
    free(stage->shapes);
    free(stage->materials);
    memset(stage, 0, sizeof *stage);
}

void stage_look_here(struct stage *stage, struct xform place, struct vec3 at) {
    if (stage->interest_count < STAGE_INTERESTS)
        stage->interest[stage->interest_count++] = xform_point(&place, at);
}

static bool grow(struct stage *stage, void **items, int count, int *capacity, size_t size) {
    if (count < *capacity)
        return true;
    int wanted = *capacity ? *capacity * 2 : 64;
    void *bigger = realloc(*items, (size_t)wanted * size);
    if (!bigger) {
        stage->failed = true;
        return false;
    }
    *items = bigger;
    *capacity = wanted;
    return true;
}

int stage_add_material(struct stage *stage, const struct material *material) {
    if (!grow(stage, (void **)&stage->materials, stage->material_count, &stage->material_capacity,
              sizeof *stage->materials))
        return 0;
    stage->materials[stage->material_count] = *material;
    return stage->material_count++;
}

int stage_checkerboard(struct stage *stage, struct vec3 color0, struct vec3 color1, float scale_u,
                       float scale_v) {
    struct material material = {.kind = MATERIAL_DIFFUSE,
                                .color0 = color0,
                                .color1 = color1,
                                .scale_u = scale_u,
                                .scale_v = scale_v,
                                .picture = -1};
    return stage_add_material(stage, &material);
}

int stage_material(struct stage *stage, struct vec3 color) {
    return stage_checkerboard(stage, color, color, 1, 1);
}

/* Of a shape's bounding sphere, as the unit shape's in its own space. */
static float bounding_radius(enum shape_kind kind, const struct xform *to_world) {
    const float *m = to_world->m;
    float x = length(vec(m[0], m[4], m[8])), y = length(vec(m[1], m[5], m[9])),
          z = length(vec(m[2], m[6], m[10]));
    switch (kind) {
    case SHAPE_SPHERE:
        return x;
    case SHAPE_DISK:
        return fmaxf(x, y);
    case SHAPE_CYLINDER:
        return sqrtf(x * x + z * z / 4);
    case SHAPE_CUBE:
        return sqrtf(x * x + y * y + z * z);
    default:
        return sqrtf(x * x + y * y);
    }
}

/* Adds a shape; returns its index (0 where memory is short). */
static int add_shape(struct stage *stage, enum shape_kind kind, struct xform to_world,
                     int material) {
    if (!grow(stage, (void **)&stage->shapes, stage->shape_count, &stage->shape_capacity,
              sizeof *stage->shapes))
        return 0;
    struct vec3 center = vec(0, 0, kind == SHAPE_CYLINDER ? 0.5f : 0);
    stage->shapes[stage->shape_count] = (struct shape){.kind = kind,
                                                       .to_world = to_world,
                                                       .to_local = xform_inverse(to_world),
                                                       .center = xform_point(&to_world, center),
                                                       .radius = bounding_radius(kind, &to_world),
                                                       .material = material};
    return stage->shape_count++;
}

int stage_box(struct stage *stage, struct xform place, struct vec3 center, struct vec3 half,
              int material) {
    struct xform at = xform_multiply(place, xform_translate(center.x, center.y, center.z));
    return add_shape(stage, SHAPE_CUBE, xform_multiply(at, xform_scale(half.x, half.y, half.z)),
                     material);
}

int stage_ball(struct stage *stage, struct xform place, struct vec3 center, float radius,
               int material) {
    /* Without the place's rotation: rounding would look like a shear to Mitsuba's sphere. */
    struct vec3 at = xform_point(&place, center);
    float r = radius * length(xform_vector(&place, vec(1, 0, 0)));
    return add_shape(stage, SHAPE_SPHERE,
                     (struct xform){{r, 0, 0, at.x, 0, r, 0, at.y, 0, 0, r, at.z}}, material);
}

int stage_panel(struct stage *stage, enum shape_kind kind, struct xform place, struct vec3 center,
                struct vec3 normal, float half_u, float half_v, int material) {
    struct vec3 n = normalize(normal);
    struct vec3 up = fabsf(n.y) < 0.9f ? vec(0, 1, 0) : vec(0, 0, 1);
    struct vec3 u = normalize(cross(up, n)), v = cross(n, u);
    struct xform frame = {
        {u.x, v.x, n.x, center.x, u.y, v.y, n.y, center.y, u.z, v.z, n.z, center.z}};
    struct xform local = xform_multiply(frame, xform_scale(half_u, half_v, 1));
    return add_shape(stage, kind, xform_multiply(place, local), material);
}

void stage_tube(struct stage *stage, struct xform place, struct vec3 center, float radius,
                float height, int sides, int material) {
    float half_side = radius * tanf(PI_F / (float)sides);
    for (int i = 0; i < sides; i++) {
        float angle = 2 * PI_F * (float)i / (float)sides;
        struct vec3 out = vec(cosf(angle), 0, sinf(angle));
        struct vec3 at = add(center, vec(out.x * radius, height / 2, out.z * radius));
        stage_panel(stage, SHAPE_RECTANGLE, place, at, out, half_side, height / 2, material);
    }
}

int stage_cylinder(struct stage *stage, struct xform place, struct vec3 from, struct vec3 to,
                   float radius, int material) {
    struct vec3 axis = sub(to, from), n = normalize(axis);
    struct vec3 u = normalize(cross(fabsf(n.y) < 0.9f ? vec(0, 1, 0) : vec(0, 0, 1), n)),
                v = cross(n, u);
    u = scale(u, radius), v = scale(v, radius);
    struct xform local = {
        {u.x, v.x, axis.x, from.x, u.y, v.y, axis.y, from.y, u.z, v.z, axis.z, from.z}};
    return add_shape(stage, SHAPE_CYLINDER, xform_multiply(place, local), material);
}

void stage_mesh(struct stage *stage, struct xform place, struct mesh *mesh, int material) {
    if (!mesh || mesh->triangle_count == 0 || stage->mesh_count == STAGE_MESHES) {
        mesh_destroy(&mesh);
        return;
    }
    int index = add_shape(stage, SHAPE_MESH, place, material);
    stage->meshes[stage->mesh_count++] = mesh;
    if (index >= stage->shape_count)
        return;
    struct shape *shape = &stage->shapes[index];
    struct vec3 center;
    float radius = mesh_bounds(mesh, &center);
    shape->mesh = stage->mesh_count - 1;
    shape->center = xform_point(&place, center);
    shape->radius = radius * length(xform_vector(&place, vec(1, 0, 0)));
}

float shape_area(const struct shape *shape) {
    const float *m = shape->to_world.m;
    float x = length(vec(m[0], m[4], m[8])), y = length(vec(m[1], m[5], m[9])),
          z = length(vec(m[2], m[6], m[10]));
    switch (shape->kind) {
    case SHAPE_RECTANGLE:
        return 4 * x * y;
    case SHAPE_DISK:
        return PI_F * x * y;
    case SHAPE_CUBE:
        return 8 * (x * y + y * z + z * x);
    case SHAPE_CYLINDER:
        return 2 * PI_F * x * z;
    default:
        return 4 * PI_F * x * x;
    }
}

void stage_light(struct stage *stage, int shape, struct vec3 tint, float share) {
    if (shape >= stage->shape_count)
        return;
    float strength = share * stage->surface / (PI_F * shape_area(&stage->shapes[shape]));
    stage->shapes[shape].radiance = scale(tint, strength / fmaxf(luminance(tint), 1e-3f));
}
