/* SPDX-License-Identifier: Apache-2.0 */
/* Lambertian reflection, one- or two-sided. */

#include "guide/trace/bsdf.h"

#include "guide/trace/basis.h"
#include "guide/trace/texture.h"

static float clamp_unit(float x) {
    return x > 0 ? (x < 1 ? x : 1) : 0;
}

struct shading bsdf_at(const struct fewray_scene *scene, const struct surface *surface,
                       struct vec3 outgoing) {
    const struct bsdf *bsdf = &scene->bsdfs[surface->mesh->bsdf];
    struct vec3 c = texture_value(&scene->textures[bsdf->reflectance], surface->u, surface->v);
    struct shading s = {surface->position, surface->geometric_normal, surface->normal,
                        vec(clamp_unit(c.x), clamp_unit(c.y), clamp_unit(c.z)), true};
    if (dot(s.normal, outgoing) <= 0) {
        s.scatters = bsdf->twosided;
        if (bsdf->twosided)
            s.normal = negate(s.normal);
    }
    return s;
}

struct vec3 bsdf_times_cosine(const struct shading *s, struct vec3 incident) {
    float cos_theta = dot(s->normal, incident);
    return cos_theta > 0 && s->scatters ? scale(s->albedo, cos_theta / PI_F) : vec(0, 0, 0);
}

struct vec3 bsdf_sample(const struct shading *s, const float u[2]) {
    struct basis basis = basis_around(s->normal);
    return normalize(to_world(&basis, cosine_hemisphere(u)));
}

float bsdf_pdf(const struct shading *s, struct vec3 incident) {
    float cos_theta = dot(s->normal, incident);
    return cos_theta > 0 && s->scatters ? cos_theta / PI_F : 0;
}
