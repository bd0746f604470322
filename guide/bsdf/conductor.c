/* SPDX-License-Identifier: Apache-2.0 */
/* Metals and mirrors, smooth or of microfacets; black from below. */

#include "guide/bsdf/bsdf_local.h"
#include "guide/bsdf/fresnel.h"
#include "guide/bsdf/microfacet.h"

/* Roughness from which on a lobe is wide enough for a map of the light to guide it, and from which
 * on it is as wide as a diffuse one for that purpose. */
#define NARROW_ALPHA 0.15f
#define BROAD_ALPHA  0.5f

static bool is_smooth(const struct bsdf_local *b) {
    return b->bsdf->kind == BSDF_CONDUCTOR;
}

static struct microfacets microfacets_of(const struct bsdf_local *b) {
    return microfacets_make(b->bsdf->microfacets, b->alpha_u, b->alpha_v);
}

/* cos_i: between the light and the microfacet. */
static struct vec3 reflected(const struct bsdf_local *b, float cos_i) {
    return mul(b->specular_reflectance,
               fresnel_conductor_rgb(cos_i, b->bsdf->conductor_eta, b->bsdf->conductor_k));
}

static float breadth_of_alpha(float alpha) {
    float t = fminf(fmaxf((alpha - NARROW_ALPHA) / (BROAD_ALPHA - NARROW_ALPHA), 0), 1);
    return t * t * (3 - 2 * t);
}

void conductor_prepare(struct bsdf_local *b) {
    bool lit = b->outgoing.z > 0;
    b->delta_chance = lit && is_smooth(b) ? 1 : 0;
    b->breadth = is_smooth(b) ? 0 : breadth_of_alpha(fminf(b->alpha_u, b->alpha_v));
    b->albedo = lit ? reflected(b, b->outgoing.z) : vec(0, 0, 0);
}

/* False where nothing is reflected, else the microfacet that mirrors the one to the other. */
static bool half_vector(const struct bsdf_local *b, struct vec3 incident, struct vec3 *m) {
    *m = normalize(add(b->outgoing, incident));
    return !is_smooth(b) && b->outgoing.z > 0 && incident.z > 0 && dot(incident, *m) > 0;
}

/* Walter et al. 2007, eq. 20. */
struct vec3 conductor_eval(const struct bsdf_local *b, struct vec3 incident) {
    struct vec3 m;
    if (!half_vector(b, incident, &m))
        return vec(0, 0, 0);
    struct microfacets d = microfacets_of(b);
    float value =
        microfacet_d(&d, m) * microfacet_g(&d, b->outgoing, incident, m) / (4 * b->outgoing.z);
    return scale(reflected(b, dot(b->outgoing, m)), value);
}

float conductor_pdf(const struct bsdf_local *b, struct vec3 incident) {
    struct vec3 m;
    if (!half_vector(b, incident, &m))
        return 0;
    struct microfacets d = microfacets_of(b);
    return microfacet_pdf(&d, b->outgoing, m) / (4 * dot(incident, m));
}

static bool sample_mirror(const struct bsdf_local *b, struct bsdf_sample *out) {
    *out = (struct bsdf_sample){.direction = vec(-b->outgoing.x, -b->outgoing.y, b->outgoing.z),
                                .weight = reflected(b, b->outgoing.z),
                                .pdf = 1,
                                .delta = true,
                                .eta = 1};
    return true;
}

bool conductor_sample(const struct bsdf_local *b, float choice, const float u[2],
                      struct bsdf_sample *out) {
    (void)choice;
    if (!(b->outgoing.z > 0))
        return false;
    if (is_smooth(b))
        return sample_mirror(b, out);
    struct microfacets d = microfacets_of(b);
    struct vec3 m = microfacet_sample(&d, b->outgoing, u);
    struct vec3 incident = normalize(reflect_at(b->outgoing, m));
    float cos_i = dot(b->outgoing, m), pdf = microfacet_pdf(&d, b->outgoing, m) / (4 * cos_i);
    *out =
        (struct bsdf_sample){.direction = incident,
                             .weight = scale(reflected(b, cos_i), microfacet_g1(&d, incident, m)),
                             .pdf = pdf,
                             .eta = 1};
    return incident.z > 0 && cos_i > 0 && pdf > 0;
}
