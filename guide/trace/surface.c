/* SPDX-License-Identifier: Apache-2.0 */
/* Ray queries and the reconstruction of hit points. */

#include "guide/trace/surface.h"

#include "guide/basis.h"
#include "guide/trace/sphere.h"

static struct vec3 vertex(const float *data, uint32_t i) {
    return vec(data[3 * (size_t)i], data[3 * (size_t)i + 1], data[3 * (size_t)i + 2]);
}

static struct vec3 interpolate(struct vec3 a, struct vec3 b, struct vec3 c, float u, float v) {
    return add(scale(a, 1 - u - v), add(scale(b, u), scale(c, v)));
}

static void fill_triangle(const struct mesh *mesh, float u, float v, struct surface *out) {
    const uint32_t *corner = mesh->indices + 3 * (size_t)out->triangle;
    struct vec3 p0 = vertex(mesh->positions, corner[0]), p1 = vertex(mesh->positions, corner[1]),
                p2 = vertex(mesh->positions, corner[2]);
    out->position = interpolate(p0, p1, p2, u, v);
    out->geometric_normal = normalize(cross(sub(p1, p0), sub(p2, p0)));
    out->normal = out->geometric_normal;
    if (mesh->normals) {
        struct vec3 n =
            interpolate(vertex(mesh->normals, corner[0]), vertex(mesh->normals, corner[1]),
                        vertex(mesh->normals, corner[2]), u, v);
        float l = length(n);
        if (l > 0)
            out->normal = scale(n, 1 / l);
    }
    out->dp_du = out->dp_dv = vec(0, 0, 0);
    float uv[2];
    triangle_uv(mesh, out->triangle, u, v, uv);
    out->u = uv[0];
    out->v = uv[1];
}

/* Solves dp = dp_du du + dp_dv dv for the triangle's edges. Without uvs its barycentric coordinates
 * stand for them. */
static void fill_triangle_tangents(const struct mesh *mesh, struct surface *out) {
    const uint32_t *corner = mesh->indices + 3 * (size_t)out->triangle;
    struct vec3 p0 = vertex(mesh->positions, corner[0]);
    struct vec3 e1 = sub(vertex(mesh->positions, corner[1]), p0);
    struct vec3 e2 = sub(vertex(mesh->positions, corner[2]), p0);
    float du1 = 1, dv1 = 0, du2 = 0, dv2 = 1;
    if (mesh->uvs) {
        const float *a = mesh->uvs + 2 * (size_t)corner[0], *b = mesh->uvs + 2 * (size_t)corner[1],
                    *c = mesh->uvs + 2 * (size_t)corner[2];
        du1 = b[0] - a[0];
        dv1 = b[1] - a[1];
        du2 = c[0] - a[0];
        dv2 = c[1] - a[1];
    }
    float inverse = 1 / (du1 * dv2 - dv1 * du2);
    out->dp_du = scale(sub(scale(e1, dv2), scale(e2, dv1)), inverse);
    out->dp_dv = scale(sub(scale(e2, du1), scale(e1, du2)), inverse);
    if (!is_finite(out->dp_du) || !is_finite(out->dp_dv)) {
        struct basis basis = basis_around(out->geometric_normal);
        out->dp_du = basis.s;
        out->dp_dv = basis.t;
    }
}

static void fill_surface(const struct fewray_world *world, const struct RTCHit *hit,
                         struct surface *out) {
    const struct mesh *mesh = &world->scene->meshes[hit->geomID];
    bool tangents = world->scene->bsdfs[mesh->bsdf].tangents;
    out->mesh = mesh;
    out->mesh_index = hit->geomID;
    out->triangle = hit->primID;
    if (mesh->kind == MESH_SPHERE) {
        sphere_fill(mesh, vec(hit->Ng_x, hit->Ng_y, hit->Ng_z), out);
        if (tangents)
            sphere_fill_tangents(mesh, out);
    } else {
        fill_triangle(mesh, hit->u, hit->v, out);
        if (tangents)
            fill_triangle_tangents(mesh, out);
    }
}

/* --- instances */

static struct vec3 row(const float *m, int i) {
    return vec(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
}

static struct vec3 transform_vector(const float *m, struct vec3 v) {
    return vec(dot(row(m, 0), v), dot(row(m, 1), v), dot(row(m, 2), v));
}

/* From the group's space into the world's. Normals go by the inverse transpose, so that they stay
 * on their side of a surface that is mirrored. */
static void place_surface(const struct instance *instance, struct surface *s) {
    const float *m = instance->to_world;
    struct vec3 x = cross(row(m, 1), row(m, 2)), y = cross(row(m, 2), row(m, 0)),
                z = cross(row(m, 0), row(m, 1));
    float side = dot(row(m, 0), x) < 0 ? -1 : 1;
    struct vec3 *normals[] = {&s->geometric_normal, &s->normal};
    for (int i = 0; i < 2; i++) {
        struct vec3 n = *normals[i];
        *normals[i] = scale(normalize_short(vec(dot(x, n), dot(y, n), dot(z, n))), side);
    }
    s->position = add(transform_vector(m, s->position), vec(m[3], m[7], m[11]));
    s->dp_du = transform_vector(m, s->dp_du);
    s->dp_dv = transform_vector(m, s->dp_dv);
}

void surface_at_hit(const struct fewray_world *world, const struct RTCHit *hit, float distance,
                    struct surface *out) {
    out->distance = distance;
    fill_surface(world, hit, out);
    unsigned placed = hit->instID[0];
    if (placed != RTC_INVALID_GEOMETRY_ID)
        place_surface(&world->scene->instances[placed - (unsigned)world->scene->mesh_count], out);
}

bool surface_trace(const struct fewray_world *world, struct vec3 origin, struct vec3 direction,
                   bool coherent, struct surface *out) {
    struct RTCRayHit ray_hit = {.ray = embree_ray(origin, direction, INFINITY)};
    embree_intersect(world->embree, &ray_hit, coherent);
    if (ray_hit.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return false;
    surface_at_hit(world, &ray_hit.hit, ray_hit.ray.tfar, out);
    return true;
}

bool surface_trace_light(const struct fewray_world *world, struct vec3 origin,
                         struct vec3 direction, struct surface *out, bool *found) {
    struct RTCRayHit ray_hit = {.ray = embree_ray(origin, direction, INFINITY)};
    embree_intersect(world->emitters, &ray_hit, false);
    *found = ray_hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    if (!*found && !world->lights.has_sky)
        return false;
    if (embree_occluded(world->embree, origin, direction,
                        *found ? ray_hit.ray.tfar * LIGHT_REACH : INFINITY))
        return false;
    if (*found)
        surface_at_hit(world, &ray_hit.hit, ray_hit.ray.tfar, out);
    return true;
}

bool surface_blocked(const struct fewray_world *world, struct vec3 p, struct vec3 geometric_normal,
                     struct vec3 q) {
    struct vec3 origin = offset_origin(world->unit, p, geometric_normal, sub(q, p));
    return embree_occluded(world->embree, origin, sub(q, origin), SHADOW_REACH);
}

bool surface_blocked_to_sky(const struct fewray_world *world, struct vec3 p,
                            struct vec3 geometric_normal, struct vec3 direction) {
    return embree_occluded(world->embree,
                           offset_origin(world->unit, p, geometric_normal, direction), direction,
                           INFINITY);
}
