/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_BSDF_H
#define FEWRAY_GUIDE_BSDF_H

/* Scattering at a surface point, after Mitsuba 3's definitions. Radiance is what is transported
 * towards the viewer: it is scaled by (eta_t / eta_i)^2 where it enters another medium (Veach 1997,
 * section 5.2). */

#include "guide/bsdf/bsdf_local.h"
#include "guide/trace/surface.h"

/* A surface point as its material looks from one side: a weighted sum of plain BSDFs. */
struct shading {
    struct vec3 position, geometric_normal;
    struct vec3 normal; /* unit shading normal, on the side of the viewer where the material has one
                         */
    struct vec3 albedo; /* share of even light from all sides that comes back from the smooth parts,
                           0..1: what the denoiser divides by */
    float delta_chance; /* of bsdf_sample() to draw a perfectly specular direction, or to pass */
    float breadth;      /* 0..1: share of the rest that scatters over the hemisphere of the normal
                           widely enough for a map of the light to guide it */
    bool scatters;      /* false: black from this side */
    bool transmits;     /* light from below may count, too; breadth is 0 then */
    int count;
    struct bsdf_local locals[SHADING_LOCALS];
};

/* outgoing: unit direction towards the viewer. */
void bsdf_at(const struct fewray_world *world, const struct surface *surface, struct vec3 outgoing,
             struct shading *out);
/* A single Lambertian BSDF: bsdf_sample() ignores `choice`. */
static inline bool bsdf_is_diffuse(const struct shading *s) {
    return s->count == 1 && s->locals[0].bsdf->kind == BSDF_DIFFUSE;
}
/* f * |cos(theta)| for light from the unit direction `incident`; without the perfectly specular
 * parts. */
struct vec3 bsdf_times_cosine(const struct shading *shading, struct vec3 incident);
/* Density (solid angle) with which bsdf_sample() draws a direction; its integral is 1 -
 * delta_chance, or less where some samples fail. */
float bsdf_pdf(const struct shading *shading, struct vec3 incident);
/* Draws an incident direction, a perfectly specular one where choice < delta_chance. choice, u: in
 * [0, 1). False: the sample carries nothing. */
bool bsdf_sample(const struct shading *shading, float choice, const float u[2],
                 struct bsdf_sample *out);

#endif
