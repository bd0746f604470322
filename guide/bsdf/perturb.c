/* SPDX-License-Identifier: Apache-2.0 */
/* The frames of bump and normal maps. */

#include "guide/bsdf/perturb.h"

#include "guide/trace/texture.h"

/* The normal of the surface that is raised along its normal by the height (Blinn 1978). */
static struct vec3 bumped_normal(const struct texture *height, float bump_scale,
                                 const struct surface *surface, const struct basis *shading) {
    float gradient[2];
    texture_gradient(height, surface->u, surface->v, gradient);
    struct vec3 n = shading->n, du = surface->dp_du, dv = surface->dp_dv;
    du = add(du, scale(n, bump_scale * gradient[0] - dot(n, du)));
    dv = add(dv, scale(n, bump_scale * gradient[1] - dot(n, dv)));
    struct vec3 bumped = cross(normalize(du), normalize(dv));
    if (dot(bumped, surface->geometric_normal) < 0)
        bumped = negate(bumped);
    return vec(dot(bumped, shading->s), dot(bumped, shading->t), dot(bumped, n));
}

static struct vec3 mapped_normal(const struct texture *map, const struct surface *surface) {
    return sub(scale(texture_value(map, surface->u, surface->v), 2), vec(1, 1, 1));
}

struct basis perturbed_axes(const struct fewray_scene *scene, const struct bsdf *bsdf,
                            const struct surface *surface, const struct basis *shading,
                            struct vec3 outgoing) {
    const struct texture *texture = &scene->textures[bsdf->weight];
    struct vec3 n = bsdf->kind == BSDF_BUMP_MAP
                        ? bumped_normal(texture, bsdf->bump_scale, surface, shading)
                        : mapped_normal(texture, surface);
    float squared = dot(n, n);
    n = squared > 0 && squared < INFINITY ? normalize(n) : vec(0, 0, 1);
    if (bsdf->flip_invalid_normals && dot(n, outgoing) * outgoing.z <= 0)
        n = vec(-n.x, -n.y, n.z);
    struct vec3 s = sub(vec(1, 0, 0), scale(n, n.x));
    if (!(dot(s, s) > 1e-12f))
        return basis_around(n);
    s = normalize(s);
    return (struct basis){s, cross(n, s), n};
}

float terminator_alpha2(float cos_between_normals) {
    float c = fminf(fmaxf(fabsf(cos_between_normals), 1e-4f), 1);
    return fminf(0.125f * (1 - c * c) / (c * c), 1);
}

float terminator_shadowing(float alpha2, float cos_theta) {
    float cos2 = cos_theta * cos_theta;
    if (!(cos2 > 0))
        return 0;
    float tan2 = fmaxf(1 - cos2, 0) / cos2;
    return 2 / (1 + sqrtf(1 + alpha2 * tan2));
}
