/* SPDX-License-Identifier: Apache-2.0 */
/* Disney's principled BSDF as Mitsuba 3 has it: a diffuse base with sheen, or rough glass, below a
 * GGX specular lobe, or metal, and a clear coat (Burley 2012, "Physically Based Shading at
 * Disney"; Burley 2015, "Extending the Disney BRDF to a BSDF with Integrated Subsurface
 * Scattering"). */

#include "guide/bsdf/bsdf_local.h"

#include "guide/bsdf/fresnel.h"
#include "guide/bsdf/microfacet.h"

#define COAT_SHARE 0.25f /* of the clear coat's nominal strength */
#define COAT_F0    0.04f /* index of refraction 1.5 */
#define COAT_ALPHA 0.25f /* for its shadowing */

/* The point and the viewer. */
struct principled {
    const struct bsdf_local *b;
    bool front;     /* the viewer is outside */
    float eta_path; /* index of the far side over the viewer's */
    float metallic, roughness;
    float opaque, glass;    /* shares of the dielectric base that scatter, and that transmit */
    float coat, coat_alpha; /* strength, and roughness of GTR1 */
    struct microfacets facets;
    struct vec3 tint; /* the base colour at luminance 1 */
};

/* Chances of the lobes to be sampled. Which way the microfacet lobe goes depends on the
 * microfacet, but not how often it is taken. */
struct chances {
    float diffuse, coat, reflect, transmit;
};

static float lerp(float a, float b, float t) {
    return a + (b - a) * t;
}

static struct vec3 lerp_color(struct vec3 a, struct vec3 b, float t) {
    return add(a, scale(sub(b, a), t));
}

static struct principled describe(const struct bsdf_local *b) {
    const float *value = b->principled;
    struct principled p = {.b = b, .front = b->outgoing.z > 0};
    p.eta_path = p.front ? b->bsdf->eta : 1 / b->bsdf->eta;
    p.metallic = value[PRINCIPLED_METALLIC];
    p.roughness = value[PRINCIPLED_ROUGHNESS];
    p.opaque = (1 - p.metallic) * (1 - value[PRINCIPLED_SPEC_TRANS]);
    p.glass = (1 - p.metallic) * value[PRINCIPLED_SPEC_TRANS];
    p.coat = value[PRINCIPLED_CLEARCOAT] * COAT_SHARE;
    p.coat_alpha = lerp(0.1f, 0.001f, value[PRINCIPLED_CLEARCOAT_GLOSS]);
    /* Burley 2012, section 5.4 */
    float aspect = sqrtf(1 - 0.9f * value[PRINCIPLED_ANISOTROPIC]), alpha = square(p.roughness);
    p.facets = microfacets_make(MICROFACET_GGX, fmaxf(alpha / aspect, 1e-3f),
                                fmaxf(alpha * aspect, 1e-3f));
    float y = luminance(b->reflectance);
    p.tint = y > 0 ? scale(b->reflectance, 1 / y) : vec(1, 1, 1);
    return p;
}

/* (1 - cos)^5, Schlick 1994. */
static float schlick_weight(float cos_theta) {
    float x = fminf(fmaxf(1 - cos_theta, 0), 1);
    return square(square(x)) * x;
}

/* Schlick's weight by the angle on the thinner side (Burley 2015). cos_i: as for
 * fresnel_dielectric(). */
static float schlick_weight_between(float cos_i, float eta) {
    float eta_it = cos_i >= 0 ? eta : 1 / eta;
    if (eta_it > 1)
        return schlick_weight(fabsf(cos_i));
    return schlick_weight(sqrtf(fmaxf(1 - (1 - square(cos_i)) / square(eta_it), 0)));
}

/* What the specular lobe reflects: Fresnel's equations, Schlick's with the base colour for metal,
 * and Schlick's with the tint. fresnel: the dielectric's, at this cosine. */
static struct vec3 specular_color(const struct principled *p, float fresnel, float cos_i) {
    if (!p->front)
        return scale(vec(1, 1, 1), p->glass * fresnel);
    float eta = p->b->bsdf->eta, spec_tint = p->b->principled[PRINCIPLED_SPEC_TINT];
    float weight = schlick_weight_between(cos_i, eta), dielectric = 1 - p->metallic;
    const struct vec3 white = {1, 1, 1};
    struct vec3 metal = lerp_color(p->b->reflectance, white, weight);
    struct vec3 tinted = lerp_color(scale(p->tint, square((eta - 1) / (eta + 1))), white, weight);
    return add(scale(white, dielectric * (1 - spec_tint) * fresnel),
               add(scale(metal, p->metallic), scale(tinted, dielectric * spec_tint)));
}

/* Generalized Trowbridge and Reitz with the exponent 1 (Burley 2012, eq. 4). */
static float coat_d(float alpha, struct vec3 m) {
    float a2 = square(alpha), sin2 = square(m.x) + square(m.y);
    return (a2 - 1) / (PI_F * logf(a2) * (sin2 + a2 * square(m.z)));
}

/* Burley 2012, appendix B. */
static struct vec3 coat_sample(float alpha, const float u[2]) {
    float a2 = square(alpha);
    float sin2 = fminf(fmaxf((powf(a2, 1 - u[0]) - a2) / (1 - a2), 0), 1), sin_h = sqrtf(sin2);
    float phi = 2 * PI_F * u[1];
    return vec(sin_h * cosf(phi), sin_h * sinf(phi), sqrtf(1 - sin2));
}

static float coat_eval(const struct principled *p, struct vec3 incident, struct vec3 m) {
    const struct microfacets shadowing = {MICROFACET_GGX, COAT_ALPHA, COAT_ALPHA};
    struct vec3 outgoing = p->b->outgoing;
    float weight = schlick_weight_between(dot(outgoing, m), p->b->bsdf->eta);
    return p->coat * lerp(COAT_F0, 1, weight) * coat_d(p->coat_alpha, m) *
           microfacet_g(&shadowing, outgoing, incident, m) * incident.z;
}

/* Diffuse base and sheen: f |cos(theta)|. Burley 2012, section 5.3; with retro-reflection apart,
 * and its flat variant: Burley 2015. */
static struct vec3 diffuse_lobe(const struct principled *p, struct vec3 incident, struct vec3 m) {
    const float *value = p->b->principled;
    float cos_o = p->b->outgoing.z, cos_i = incident.z, cos_d = dot(m, incident);
    float fo = schlick_weight(cos_o), fi = schlick_weight(cos_i);
    float retro90 = 2 * p->roughness * square(cos_d), flat90 = 0.5f * retro90;
    float lambert = (1 - 0.5f * fo) * (1 - 0.5f * fi);
    float retro = retro90 * (fo + fi + fo * fi * (retro90 - 1));
    float flat = lerp(1, flat90, fo) * lerp(1, flat90, fi);
    flat = 1.25f * (flat * (1 / (cos_o + cos_i) - 0.5f) + 0.5f);
    float base = lerp(lambert + retro, flat, value[PRINCIPLED_FLATNESS]);
    struct vec3 sheen = lerp_color(vec(1, 1, 1), p->tint, value[PRINCIPLED_SHEEN_TINT]);
    float strength =
        value[PRINCIPLED_SHEEN] * (1 - p->metallic) * schlick_weight(fabsf(cos_d)) * cos_i;
    return add(scale(p->b->reflectance, p->opaque * base * cos_i / PI_F), scale(sheen, strength));
}

/* The microfacet that leads light from one side to the other, or mirrors it; zero: none. */
static struct vec3 half_vector(const struct principled *p, struct vec3 incident) {
    struct vec3 outgoing = p->b->outgoing;
    float eta = outgoing.z * incident.z > 0 ? 1 : p->eta_path;
    struct vec3 m = normalize(add(outgoing, scale(incident, eta)));
    return m.z < 0 ? negate(m) : m;
}

/* Whether the microfacet's sides for both directions are the surface's. */
static bool compatible(struct vec3 outgoing, struct vec3 incident, struct vec3 m) {
    return dot(outgoing, m) * outgoing.z > 0 && dot(incident, m) * incident.z > 0;
}

/* Walter et al. 2007, eq. 21, with the radiance's scale by (eta_t / eta_i)^2. */
static struct vec3 transmit_lobe(const struct principled *p, struct vec3 incident, struct vec3 m,
                                 float fresnel, float dg) {
    float between_o = dot(p->b->outgoing, m), between_i = dot(incident, m);
    float denominator = square(between_o + p->eta_path * between_i);
    if (!(denominator > 0))
        return vec(0, 0, 0);
    float value = fabsf(p->glass * (1 - fresnel) * dg * between_o * between_i /
                        (p->b->outgoing.z * denominator));
    struct vec3 base = p->b->reflectance;
    return scale(vec(sqrtf(base.x), sqrtf(base.y), sqrtf(base.z)), value);
}

static bool silent(const struct principled *p) {
    return p->b->outgoing.z == 0 || (!p->front && !(p->glass > 0));
}

static bool all_finite(struct vec3 v) {
    return isfinite(v.x + v.y + v.z);
}

struct vec3 principled_eval(const struct bsdf_local *b, struct vec3 incident) {
    struct principled p = describe(b);
    struct vec3 sum = vec(0, 0, 0), outgoing = b->outgoing;
    if (silent(&p) || incident.z == 0)
        return sum;
    bool reflects = outgoing.z * incident.z > 0;
    struct vec3 m = half_vector(&p, incident);
    if (compatible(outgoing, incident, m)) {
        float cos_h = dot(outgoing, m);
        float fresnel = fresnel_dielectric(cos_h, b->bsdf->eta).reflectance;
        float dg = microfacet_d(&p.facets, m) * microfacet_g(&p.facets, outgoing, incident, m);
        if (!reflects)
            sum = transmit_lobe(&p, incident, m, fresnel, dg);
        else
            sum = scale(specular_color(&p, fresnel, cos_h), dg / (4 * fabsf(outgoing.z)));
        if (reflects && p.front && p.coat > 0)
            sum = add(sum, scale(vec(1, 1, 1), coat_eval(&p, incident, m)));
    }
    if (reflects && p.front)
        sum = add(sum, diffuse_lobe(&p, incident, m));
    return all_finite(sum) ? sum : vec(0, 0, 0);
}

/* In proportion to the lobes' strengths. cos_h: between the viewer and the microfacet. */
static struct chances lobe_chances(const struct principled *p, float cos_h) {
    float fresnel = fresnel_dielectric(cos_h, p->b->bsdf->eta).reflectance;
    struct chances c = {.reflect = fresnel};
    if (p->front)
        c = (struct chances){p->opaque, p->coat, 1 - p->glass * (1 - fresnel), 0};
    c.transmit = 1 - c.reflect;
    float scale_to_one = 1 / (c.diffuse + c.coat + 1);
    c.diffuse *= scale_to_one;
    c.coat *= scale_to_one;
    c.reflect *= scale_to_one;
    c.transmit *= scale_to_one;
    return c;
}

static struct vec3 above(struct vec3 v) {
    return v.z < 0 ? negate(v) : v;
}

static float density(const struct principled *p, struct vec3 incident) {
    struct vec3 outgoing = p->b->outgoing, m = half_vector(p, incident);
    bool reflects = outgoing.z * incident.z > 0;
    float between_o = dot(outgoing, m), between_i = dot(incident, m), pdf = 0;
    struct chances chance = lobe_chances(p, between_o);
    if (compatible(outgoing, incident, m)) {
        float facet = microfacet_pdf(&p->facets, above(outgoing), m);
        if (reflects) {
            float coat = chance.coat > 0 ? chance.coat * coat_d(p->coat_alpha, m) * m.z : 0;
            /* by the viewer's cosine, as in `facet`: a grazing one is rounded alike in both */
            pdf = (chance.reflect * facet + coat) / (4 * fabsf(between_o));
        } else { /* Walter et al. 2007, eq. 17 */
            float denominator = square(between_o + p->eta_path * between_i);
            if (denominator > 0)
                pdf =
                    chance.transmit * facet * square(p->eta_path) * fabsf(between_i) / denominator;
        }
    }
    if (reflects && p->front)
        pdf += chance.diffuse * incident.z / PI_F;
    return isfinite(pdf) ? pdf : 0;
}

float principled_pdf(const struct bsdf_local *b, struct vec3 incident) {
    struct principled p = describe(b);
    return silent(&p) || incident.z == 0 ? 0 : density(&p, incident);
}

/* *refracts: the direction is meant to lie on the other side of the surface. */
static struct vec3 draw_direction(const struct principled *p, float choice, const float u[2],
                                  bool *refracts) {
    struct vec3 outgoing = p->b->outgoing;
    struct chances chance = lobe_chances(p, outgoing.z);
    *refracts = false;
    if (choice < chance.diffuse)
        return cosine_hemisphere(u);
    choice -= chance.diffuse;
    if (choice < chance.coat)
        return reflect_at(outgoing, coat_sample(p->coat_alpha, u));
    choice -= chance.coat;
    struct vec3 m = microfacet_sample(&p->facets, above(outgoing), u);
    *refracts = choice >= lobe_chances(p, dot(outgoing, m)).reflect;
    if (!*refracts)
        return reflect_at(outgoing, m);
    struct fresnel f = fresnel_dielectric(dot(outgoing, m), p->b->bsdf->eta);
    return refract_at(outgoing, m, &f);
}

bool principled_sample(const struct bsdf_local *b, float choice, const float u[2],
                       struct bsdf_sample *out) {
    struct principled p = describe(b);
    bool refracts;
    if (silent(&p))
        return false;
    *out = (struct bsdf_sample){.direction = normalize(draw_direction(&p, choice, u, &refracts)),
                                .eta = 1};
    if (out->direction.z == 0 || refracts != (out->direction.z * b->outgoing.z < 0))
        return false;
    if (refracts)
        out->eta = p.eta_path;
    out->pdf = density(&p, out->direction);
    if (!(out->pdf > 0))
        return false;
    out->weight = scale(principled_eval(b, out->direction), 1 / out->pdf);
    return all_finite(out->weight);
}

void principled_prepare(struct bsdf_local *b) {
    struct principled p = describe(b);
    b->delta_chance = b->breadth = 0;
    b->albedo = vec(0, 0, 0);
    if (silent(&p))
        return;
    struct chances chance = lobe_chances(&p, b->outgoing.z);
    if (b->principled[PRINCIPLED_SPEC_TRANS] <= 0.5f)
        b->breadth = chance.diffuse +
                     chance.reflect * microfacet_breadth(fminf(p.facets.alpha_u, p.facets.alpha_v));
    float fresnel = fresnel_dielectric(b->outgoing.z, b->bsdf->eta).reflectance;
    struct vec3 base = b->reflectance, a = specular_color(&p, fresnel, b->outgoing.z);
    a = add(a, scale(vec(sqrtf(base.x), sqrtf(base.y), sqrtf(base.z)), p.glass * (1 - fresnel)));
    if (p.front)
        a = add(a, scale(base, p.opaque));
    b->albedo = vec(fminf(a.x, 1), fminf(a.y, 1), fminf(a.z, 1));
}
