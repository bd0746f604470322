/* SPDX-License-Identifier: Apache-2.0 */
/* Glass and the like: a smooth boundary, one of microfacets, and a thin sheet; seen from either
 * side. */

#include "guide/bsdf/bsdf_local.h"
#include "guide/bsdf/fresnel.h"
#include "guide/bsdf/microfacet.h"

static bool is_rough(const struct bsdf_local *b) {
    return b->bsdf->kind == BSDF_ROUGH_DIELECTRIC;
}

static struct microfacets microfacets_of(const struct bsdf_local *b) {
    return microfacets_make(b->bsdf->microfacets, b->alpha_u, b->alpha_v);
}

/* On the side of the viewer, above the surface. */
static struct vec3 outgoing_above(const struct bsdf_local *b) {
    return b->outgoing.z < 0 ? negate(b->outgoing) : b->outgoing;
}

/* Share that a smooth boundary reflects, and a sheet with all reflections between its sides (Born
 * and Wolf; a geometric series). */
static struct fresnel boundary(const struct bsdf_local *b) {
    bool thin = b->bsdf->kind == BSDF_THIN_DIELECTRIC;
    float cos_i = thin ? fabsf(b->outgoing.z) : b->outgoing.z;
    struct fresnel f = fresnel_dielectric(cos_i, b->bsdf->eta);
    if (thin)
        f.reflectance *= 2 / (1 + f.reflectance);
    return f;
}

void dielectric_prepare(struct bsdf_local *b) {
    float r = boundary(b).reflectance;
    b->delta_chance = is_rough(b) ? 0 : 1;
    b->breadth = 0;
    b->albedo = is_rough(b) ? add(scale(b->specular_reflectance, r),
                                  scale(b->specular_transmittance, 1 - r))
                            : b->specular_reflectance;
}

/* A microfacet that takes light from one direction to the other. */
struct facet {
    struct vec3 normal;    /* unit, above the surface */
    float cos_out, cos_in; /* of outgoing and incident with it */
    bool reflects;
    float eta, inverse_eta; /* of the far side of the viewer over the viewer's */
    float jacobian;         /* d normal / d incident: Walter et al. 2007, eq. 14 and 17 */
    struct fresnel fresnel;
};

static bool find_facet(const struct bsdf_local *b, struct vec3 incident, struct facet *f) {
    struct vec3 outgoing = b->outgoing;
    if (!is_rough(b) || outgoing.z == 0 || incident.z == 0)
        return false;
    f->reflects = outgoing.z * incident.z > 0;
    f->eta = outgoing.z > 0 ? b->bsdf->eta : 1 / b->bsdf->eta;
    f->inverse_eta = 1 / f->eta;
    struct vec3 m = normalize(add(outgoing, scale(incident, f->reflects ? 1 : f->eta)));
    f->normal = m.z < 0 ? negate(m) : m;
    f->cos_out = dot(outgoing, f->normal);
    f->cos_in = dot(incident, f->normal);
    if (!(f->cos_out * outgoing.z > 0 && f->cos_in * incident.z > 0))
        return false;
    float path = f->cos_out + f->eta * f->cos_in;
    f->jacobian =
        fabsf(f->reflects ? 1 / (4 * f->cos_in) : f->eta * f->eta * f->cos_in / (path * path));
    f->fresnel = fresnel_dielectric(f->cos_out, b->bsdf->eta);
    return isfinite(f->jacobian);
}

/* Walter et al. 2007, eq. 20 and 21. */
struct vec3 dielectric_eval(const struct bsdf_local *b, struct vec3 incident) {
    struct facet f;
    if (!find_facet(b, incident, &f))
        return vec(0, 0, 0);
    struct microfacets d = microfacets_of(b);
    float value = microfacet_d(&d, f.normal) * microfacet_g(&d, b->outgoing, incident, f.normal) *
                  f.jacobian * fabsf(f.cos_out / b->outgoing.z);
    if (f.reflects)
        return scale(b->specular_reflectance, value * f.fresnel.reflectance);
    return scale(b->specular_transmittance,
                 value * (1 - f.fresnel.reflectance) * f.inverse_eta * f.inverse_eta);
}

float dielectric_pdf(const struct bsdf_local *b, struct vec3 incident) {
    struct facet f;
    if (!find_facet(b, incident, &f))
        return 0;
    struct microfacets d = microfacets_of(b);
    float chance = f.reflects ? f.fresnel.reflectance : 1 - f.fresnel.reflectance;
    return chance * microfacet_pdf(&d, outgoing_above(b), f.normal) * f.jacobian;
}

/* Reflects or transmits at the normal m, by its chances. */
static void sample_side(const struct bsdf_local *b, struct vec3 m, const struct fresnel *f,
                        float choice, struct bsdf_sample *out) {
    bool reflects = choice < f->reflectance;
    float radiance_scale = f->eta_ti * f->eta_ti;
    *out = (struct bsdf_sample){
        .direction = reflects ? reflect_at(b->outgoing, m) : refract_at(b->outgoing, m, f),
        .weight =
            reflects ? b->specular_reflectance : scale(b->specular_transmittance, radiance_scale),
        .pdf = reflects ? f->reflectance : 1 - f->reflectance,
        .eta = reflects ? 1 : f->eta_it};
    out->direction = normalize(out->direction);
}

static bool sample_smooth(const struct bsdf_local *b, float choice, struct bsdf_sample *out) {
    struct fresnel f = boundary(b);
    if (b->bsdf->kind == BSDF_THIN_DIELECTRIC) { /* what gets through goes on straight */
        f.eta_it = f.eta_ti = 1;
        f.cos_t = -b->outgoing.z;
    }
    sample_side(b, vec(0, 0, 1), &f, choice, out);
    out->delta = true;
    return out->pdf > 0 && b->outgoing.z != 0;
}

bool dielectric_sample(const struct bsdf_local *b, float choice, const float u[2],
                       struct bsdf_sample *out) {
    if (!is_rough(b))
        return sample_smooth(b, choice, out);
    if (b->outgoing.z == 0)
        return false;
    struct microfacets d = microfacets_of(b);
    struct vec3 above = outgoing_above(b), m = microfacet_sample(&d, above, u);
    struct fresnel f = fresnel_dielectric(dot(b->outgoing, m), b->bsdf->eta);
    sample_side(b, m, &f, choice, out);
    float cos_out = dot(b->outgoing, m), cos_in = dot(out->direction, m);
    float path = cos_out + out->eta * cos_in;
    out->pdf *= microfacet_pdf(&d, above, m) *
                fabsf(cos_in * cos_out > 0 ? 1 / (4 * cos_in)
                                           : out->eta * out->eta * cos_in / (path * path));
    out->weight = scale(out->weight, microfacet_g1(&d, out->direction, m));
    return out->pdf > 0 && out->pdf < INFINITY && max_component(out->weight) > 0;
}
