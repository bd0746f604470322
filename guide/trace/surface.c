/* SPDX-License-Identifier: Apache-2.0 */
/* Ray queries and the reconstruction of hit points. */

#include "guide/trace/surface.h"

static struct vec3 vertex(const float *data, uint32_t i) {
    return vec(data[3 * (size_t)i], data[3 * (size_t)i + 1], data[3 * (size_t)i + 2]);
}

static struct vec3 interpolate(struct vec3 a, struct vec3 b, struct vec3 c, float u, float v) {
    return add(scale(a, 1 - u - v), add(scale(b, u), scale(c, v)));
}

static void fill_surface(const struct mesh *mesh, float u, float v, struct surface *out) {
    const uint32_t *corner = mesh->indices + 3 * (size_t)out->triangle;
    struct vec3 p0 = vertex(mesh->positions, corner[0]), p1 = vertex(mesh->positions, corner[1]),
                p2 = vertex(mesh->positions, corner[2]);
    out->mesh = mesh;
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
    out->u = u;
    out->v = v;
    if (mesh->uvs) {
        const float *a = mesh->uvs + 2 * (size_t)corner[0], *b = mesh->uvs + 2 * (size_t)corner[1],
                    *c = mesh->uvs + 2 * (size_t)corner[2];
        out->u = (1 - u - v) * a[0] + u * b[0] + v * c[0];
        out->v = (1 - u - v) * a[1] + u * b[1] + v * c[1];
    }
}

bool surface_trace(const struct fewray_world *world, struct vec3 origin, struct vec3 direction,
                   bool coherent, struct surface *out) {
    struct RTCRayHit ray_hit = {.ray = embree_ray(origin, direction, INFINITY)};
    embree_intersect(world->embree, &ray_hit, coherent);
    if (ray_hit.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return false;
    out->mesh_index = ray_hit.hit.geomID;
    out->triangle = ray_hit.hit.primID;
    out->distance = ray_hit.ray.tfar;
    fill_surface(&world->scene->meshes[ray_hit.hit.geomID], ray_hit.hit.u, ray_hit.hit.v, out);
    return true;
}

bool surface_blocked(const struct fewray_world *world, struct vec3 p, struct vec3 geometric_normal,
                     struct vec3 q) {
    struct vec3 origin = offset_origin(p, geometric_normal, sub(q, p));
    return embree_occluded(world->embree, origin, sub(q, origin), 1 - 9e-4f);
}

bool surface_blocked_to_sky(const struct fewray_world *world, struct vec3 p,
                            struct vec3 geometric_normal, struct vec3 direction) {
    return embree_occluded(world->embree, offset_origin(p, geometric_normal, direction), direction,
                           INFINITY);
}
