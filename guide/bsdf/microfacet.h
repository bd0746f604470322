/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_MICROFACET_H
#define FEWRAY_GUIDE_MICROFACET_H

/* Distributions of microfacets and their Smith shadowing, as Mitsuba 3 has them with its
 * `sample_visible` on (Walter et al. 2007; Heitz 2014). Directions are local and unit, z is the
 * shading normal; a microfacet's normal m has m.z >= 0. */

#include "guide/scene/scene.h"

#define MICROFACET_MIN_ALPHA 1e-4f

struct microfacets {
    enum microfacet_kind kind;
    float alpha_u, alpha_v; /* roughness along x and y, at least MICROFACET_MIN_ALPHA */
};

/* Clamps the alphas. */
struct microfacets microfacets_make(enum microfacet_kind kind, float alpha_u, float alpha_v);

/* Area of microfacets with normal m per solid angle and area of the surface: its integral against
 * m.z is 1. */
float microfacet_d(const struct microfacets *d, struct vec3 m);
/* Visible share of microfacets m from direction v on either side; 0 where v and m disagree on the
 * side. Beckmann: Walter et al.'s rational fit (eq. 27), 0.4% from exact. */
float microfacet_g1(const struct microfacets *d, struct vec3 v, struct vec3 m);
/* Both masked and shadowed, taken as independent. */
float microfacet_g(const struct microfacets *d, struct vec3 v, struct vec3 w, struct vec3 m);
/* Density (solid angle of m) of the normals that v (v.z > 0) sees: Heitz and d'Eon 2014, eq. 2. For
 * Beckmann its integral is as near to 1 as the fit of G1 is. */
float microfacet_pdf(const struct microfacets *d, struct vec3 v, struct vec3 m);
/* Draws a normal that v (v.z > 0) sees. u: in [0, 1). */
struct vec3 microfacet_sample(const struct microfacets *d, struct vec3 v, const float u[2]);

/* How much of struct shading's breadth a lobe of this roughness has: 0 where it is narrower than a
 * guide's bins resolve, 1 where it is nearly as wide as a diffuse one. */
static inline float microfacet_breadth(float alpha) {
    return fminf(fmaxf((alpha - 0.15f) / (0.5f - 0.15f), 0), 1);
}

#endif
