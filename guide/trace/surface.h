/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SURFACE_H
#define FEWRAY_GUIDE_SURFACE_H

/* What a ray hit, and where rays leave from. */

#include "guide/trace/world.h"

struct surface {
    const struct mesh *mesh;
    uint32_t mesh_index, triangle;
    float distance; /* along the ray, scene units */
    struct vec3 position;
    struct vec3 geometric_normal,
        normal; /* unit, world space; normal is for shading; as the mesh has them, not turned */
    float u, v; /* texture coordinates */
    struct vec3 dp_du, dp_dv; /* world space, per unit of u and v; only where the BSDF has
                                 `tangents`, else 0 */
};

/* The nearest surface along a unit direction; false where there is none. */
bool surface_trace(const struct fewray_world *world, struct vec3 origin, struct vec3 direction,
                   bool coherent, struct surface *out);

/* Of a ray whose end can't scatter: false where what it meets first doesn't shine. *found: it meets
 * a surface, *out, whose mesh shines; else it leaves the scene. */
bool surface_trace_light(const struct fewray_world *world, struct vec3 origin,
                         struct vec3 direction, struct surface *out, bool *found);
/* What Embree found at a distance along a ray. */
void surface_at_hit(const struct fewray_world *world, const struct RTCHit *hit, float distance,
                    struct surface *out);
/* Texture coordinates at barycentric (u, v) of a triangle; those themselves where the mesh has
 * none. */
static inline void triangle_uv(const struct mesh *mesh, uint32_t triangle, float u, float v,
                               float out[2]) {
    out[0] = u;
    out[1] = v;
    if (!mesh->uvs)
        return;
    const uint32_t *corner = mesh->indices + 3 * (size_t)triangle;
    const float *a = mesh->uvs + 2 * (size_t)corner[0], *b = mesh->uvs + 2 * (size_t)corner[1],
                *c = mesh->uvs + 2 * (size_t)corner[2];
    for (int k = 0; k < 2; k++)
        out[k] = (1 - u - v) * a[k] + u * b[k] + v * c[k];
}

/* Shares of the way to a light that must be free: a light doesn't hide itself. */
#define SHADOW_REACH (1 - 9e-4f)
#define LIGHT_REACH  (1 - 1e-5f) /* where a ray has found the light's own surface */

/* Of a vector so short that its square may underflow; zero stays zero. */
static inline struct vec3 normalize_short(struct vec3 a) {
    float largest = fmaxf(fabsf(a.x), fmaxf(fabsf(a.y), fabsf(a.z)));
    return largest > 0 ? normalize(vec(a.x / largest, a.y / largest, a.z / largest)) : a;
}

/* Start of a ray that leaves p towards `towards`, off the surface by an epsilon of the position's
 * size, and of the world's unit. */
static inline struct vec3 offset_origin(float unit, struct vec3 p, struct vec3 geometric_normal,
                                        struct vec3 towards) {
    float size = max_float(max_float(fabsf(p.x), fabsf(p.y)), fabsf(p.z));
    float epsilon = (unit + size) * 9e-5f;
    return add(p, scale(geometric_normal, dot(geometric_normal, towards) < 0 ? -epsilon : epsilon));
}

/* True where something blocks the segment from p to q (both on surfaces). */
bool surface_blocked(const struct fewray_world *world, struct vec3 p, struct vec3 geometric_normal,
                     struct vec3 q);
/* True where something blocks the ray from p to infinity. */
bool surface_blocked_to_sky(const struct fewray_world *world, struct vec3 p,
                            struct vec3 geometric_normal, struct vec3 direction);

#endif
