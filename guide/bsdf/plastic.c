/* SPDX-License-Identifier: Apache-2.0 */
/* A diffuse base below a dielectric coat, smooth (`plastic`) or of microfacets (`roughplastic`).
 * Light that the base scatters against the coat from inside goes on until it leaves; the sum over
 * all its bounces is the geometric series that divides by 1 - internal reflectance. */

#include "guide/bsdf/bsdf_local.h"

#include "guide/bsdf/fresnel.h"
#include "guide/bsdf/microfacet.h"

static bool is_rough(const struct bsdf_local *b) {
    return b->bsdf->kind == BSDF_ROUGH_PLASTIC;
}

static float look_up(const float table[BSDF_TRANSMITTANCE_SIZE], float cos_theta) {
    float x = fminf(fmaxf(cos_theta, 0), 1) * (BSDF_TRANSMITTANCE_SIZE - 1);
    int i = (int)x < BSDF_TRANSMITTANCE_SIZE - 2 ? (int)x : BSDF_TRANSMITTANCE_SIZE - 2;
    return table[i] + (table[i + 1] - table[i]) * (x - (float)i);
}

/* Share of light that passes the coat at this angle to the normal. */
static float transmittance(const struct bsdf_local *b, float cos_theta) {
    return is_rough(b) ? look_up(b->table->transmittance, cos_theta)
                       : 1 - fresnel_dielectric(cos_theta, b->bsdf->eta).reflectance;
}

/* Chance to sample the coat. */
static float coat_chance(const struct bsdf_local *b) {
    float t = transmittance(b, b->outgoing.z), s = b->table->specular_sampling_weight;
    float coat = (1 - t) * s, base = t * (1 - s);
    return coat + base > 0 ? coat / (coat + base) : 1;
}

static float series(float reflectance, float internal, bool nonlinear) {
    float rest = 1 - internal * (nonlinear ? reflectance : 1);
    return rest > 0 ? reflectance / rest : 0;
}

/* What the base reflects of light that has passed the coat, of all bounces together, before it
 * passes again. */
static struct vec3 base_reflectance(const struct bsdf_local *b) {
    float internal = b->table->internal_reflectance;
    bool nonlinear = b->bsdf->nonlinear;
    return vec(series(b->reflectance.x, internal, nonlinear),
               series(b->reflectance.y, internal, nonlinear),
               series(b->reflectance.z, internal, nonlinear));
}

void plastic_prepare(struct bsdf_local *b) {
    b->delta_chance = b->breadth = 0;
    b->albedo = vec(0, 0, 0);
    if (!(b->outgoing.z > 0))
        return;
    float t = transmittance(b, b->outgoing.z), coat = coat_chance(b), eta = b->bsdf->eta;
    b->albedo = scale(base_reflectance(b), t * b->table->mean_transmittance / (eta * eta));
    if (is_rough(b)) {
        b->breadth = 1 - coat + coat * microfacet_breadth(b->alpha_u);
        b->albedo = add(b->albedo, scale(b->specular_reflectance,
                                         look_up(b->table->coat_albedo, b->outgoing.z)));
    } else {
        b->delta_chance = coat;
        b->breadth = 1;
    }
    b->albedo = vec(fminf(b->albedo.x, 1), fminf(b->albedo.y, 1), fminf(b->albedo.z, 1));
}

/* f |cos(theta)| of the base. */
static struct vec3 base_eval(const struct bsdf_local *b, struct vec3 incident) {
    float eta = b->bsdf->eta;
    float both = transmittance(b, b->outgoing.z) * transmittance(b, incident.z);
    return scale(base_reflectance(b), both * incident.z / (PI_F * eta * eta));
}

static struct microfacets coat_of(const struct bsdf_local *b) {
    return microfacets_make(b->bsdf->microfacets, b->alpha_u, b->alpha_u);
}

struct vec3 plastic_eval(const struct bsdf_local *b, struct vec3 incident) {
    if (!(b->outgoing.z > 0 && incident.z > 0))
        return vec(0, 0, 0);
    struct vec3 value = base_eval(b, incident);
    if (is_rough(b)) {
        struct microfacets d = coat_of(b);
        struct vec3 m = normalize(add(b->outgoing, incident));
        float fresnel = fresnel_dielectric(dot(b->outgoing, m), b->bsdf->eta).reflectance;
        /* Walter et al. 2007, eq. 20, without the cosine of the incident direction */
        float coat = fresnel * microfacet_d(&d, m) * microfacet_g(&d, b->outgoing, incident, m) /
                     (4 * b->outgoing.z);
        value = add(value, scale(b->specular_reflectance, coat));
    }
    return value;
}

float plastic_pdf(const struct bsdf_local *b, struct vec3 incident) {
    if (!(b->outgoing.z > 0 && incident.z > 0))
        return 0;
    float coat = coat_chance(b), pdf = (1 - coat) * incident.z / PI_F;
    if (is_rough(b)) {
        struct microfacets d = coat_of(b);
        struct vec3 m = normalize(add(b->outgoing, incident));
        float between = dot(b->outgoing, m);
        if (between > 0)
            pdf += coat * microfacet_pdf(&d, b->outgoing, m) / (4 * between);
    }
    return pdf;
}

static bool sample_smooth_coat(const struct bsdf_local *b, struct bsdf_sample *out) {
    float fresnel = fresnel_dielectric(b->outgoing.z, b->bsdf->eta).reflectance;
    *out = (struct bsdf_sample){.direction = vec(-b->outgoing.x, -b->outgoing.y, b->outgoing.z),
                                .weight = scale(b->specular_reflectance, fresnel / b->delta_chance),
                                .pdf = b->delta_chance,
                                .delta = true,
                                .eta = 1};
    return true;
}

bool plastic_sample(const struct bsdf_local *b, float choice, const float u[2],
                    struct bsdf_sample *out) {
    if (!(b->outgoing.z > 0))
        return false;
    if (choice < b->delta_chance)
        return sample_smooth_coat(b, out);
    *out = (struct bsdf_sample){.eta = 1};
    if (is_rough(b) && choice < coat_chance(b)) {
        struct microfacets d = coat_of(b);
        out->direction = reflect_at(b->outgoing, microfacet_sample(&d, b->outgoing, u));
    } else {
        out->direction = cosine_hemisphere(u);
    }
    out->direction = normalize(out->direction);
    out->pdf = plastic_pdf(b, out->direction);
    if (!(out->pdf > 0))
        return false;
    out->weight = scale(plastic_eval(b, out->direction), 1 / out->pdf);
    return true;
}
