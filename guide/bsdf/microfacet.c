/* SPDX-License-Identifier: Apache-2.0 */
/* Beckmann and GGX microfacets: density, shadowing, and sampling of the visible ones. */

#include "guide/bsdf/microfacet.h"

#include <float.h>

#define ROOT_STEPS      16
#define INVERSE_SQRT_PI 0.564189584f

struct microfacets microfacets_make(enum microfacet_kind kind, float alpha_u, float alpha_v) {
    return (struct microfacets){kind, fmaxf(alpha_u, MICROFACET_MIN_ALPHA),
                                fmaxf(alpha_v, MICROFACET_MIN_ALPHA)};
}

/* Heitz 2014, eq. 78 (Beckmann) and 85 (GGX). */
float microfacet_d(const struct microfacets *d, struct vec3 m) {
    float area = PI_F * d->alpha_u * d->alpha_v, cos2 = m.z * m.z, value;
    float stretched = square(m.x / d->alpha_u) + square(m.y / d->alpha_v);
    if (d->kind == MICROFACET_BECKMANN)
        value = expf(-stretched / cos2) / (area * cos2 * cos2);
    else
        value = 1 / (area * square(stretched + cos2));
    return value * m.z > 1e-20f && value <= FLT_MAX ? value : 0;
}

float microfacet_g1(const struct microfacets *d, struct vec3 v, struct vec3 m) {
    if (!(dot(v, m) * v.z > 0))
        return 0;
    float stretched = square(d->alpha_u * v.x) + square(d->alpha_v * v.y);
    if (!(stretched > 0))
        return 1;
    float tan2 = stretched / (v.z * v.z);
    if (d->kind == MICROFACET_GGX)
        return 2 / (1 + sqrtf(1 + tan2));
    float a = 1 / sqrtf(tan2);
    return a >= 1.6f ? 1 : a * (3.535f + 2.181f * a) / (1 + a * (2.276f + 2.577f * a));
}

float microfacet_g(const struct microfacets *d, struct vec3 v, struct vec3 w, struct vec3 m) {
    return microfacet_g1(d, v, m) * microfacet_g1(d, w, m);
}

float microfacet_pdf(const struct microfacets *d, struct vec3 v, struct vec3 m) {
    if (!(v.z > 0))
        return 0;
    float pdf = microfacet_d(d, m) * microfacet_g1(d, v, m) * fabsf(dot(v, m)) / v.z;
    return pdf <= FLT_MAX ? pdf : 0;
}

/* Inverse error function; Giles 2010, "Approximating the erfinv function", single precision. */
static float erf_inverse(float x) {
    static const float middle[] = {2.81022636e-08f,  3.43273939e-07f, -3.5233877e-06f,
                                   -4.39150654e-06f, 0.00021858087f,  -0.00125372503f,
                                   -0.00417768164f,  0.246640727f,    1.50140941f};
    static const float tail[] = {-0.000200214257f, 0.000100950558f, 0.00134934322f,
                                 -0.00367342844f,  0.00573950773f,  -0.0076224613f,
                                 0.00943887047f,   1.00167406f,     2.83297682f};
    x = fminf(fmaxf(x, -1 + FLT_EPSILON / 2), 1 - FLT_EPSILON / 2);
    float w = -logf((1 - x) * (1 + x)), p = 0;
    const float *c = w < 5 ? middle : tail;
    w = w < 5 ? w - 2.5f : sqrtf(w) - 3;
    for (int i = 0; i < 9; i++)
        p = p * w + c[i];
    return p * x;
}

/* Slope of a microfacet of unit Beckmann roughness towards a viewer at this angle: the density of a
 * slope x is in proportion to (cos - x sin) exp(-x^2) where positive (Heitz and d'Eon 2014,
 * supplemental, section 2). Its distribution function is inverted over b = erf(x), as Jakob 2014
 * ("An Improved Visible Normal Sampling Routine for the Beckmann Distribution") does, because it is
 * concave there: Newton's steps come home from any start. Halley's are longer, so they are held to
 * twice Newton's. */
static float beckmann_slope(float cos_theta, float sin_theta, float u) {
    float steepest = sin_theta > 0 ? cos_theta / sin_theta : INFINITY, most = erff(steepest);
    float s = sin_theta * INVERSE_SQRT_PI;
    float target = u * (cos_theta * (1 + most) + s * expf(-steepest * steepest));
    float b = most - (1 + most) * sqrtf(1 - u), x = erf_inverse(b);
    for (int i = 0; i < ROOT_STEPS; i++) {
        float gauss = expf(-x * x), value = cos_theta * (1 + b) + s * gauss;
        float slope = fmaxf(cos_theta - x * sin_theta, 1e-6f);
        float newton = (target - value) / slope;
        float bend = 0.25f * sin_theta / (INVERSE_SQRT_PI * gauss * slope);
        float step = newton / fmaxf(1 - newton * bend, 0.5f);
        b = fminf(fmaxf(b + step, -1), most);
        x = erf_inverse(b);
        if (fabsf(step) < 1e-3f * (1 + b))
            break;
    }
    return x;
}

static struct vec3 sample_beckmann(struct vec3 stretched, const float u[2]) {
    float sin_theta = sqrtf(square(stretched.x) + square(stretched.y));
    float cos_phi = sin_theta > 0 ? stretched.x / sin_theta : 1;
    float sin_phi = sin_theta > 0 ? stretched.y / sin_theta : 0;
    float x = beckmann_slope(stretched.z, sin_theta, u[0]), y = erf_inverse(2 * u[1] - 1);
    return vec(sin_phi * y - cos_phi * x, -sin_phi * x - cos_phi * y, 1);
}

/* Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps", listing 3. */
static struct vec3 sample_ggx(struct vec3 stretched, const float u[2]) {
    float rest = (1 - u[0]) * (1 + stretched.z), z = rest - stretched.z;
    float r = sqrtf(fmaxf(1 - z * z, 0)), phi = 2 * PI_F * u[1];
    return vec(r * cosf(phi) + stretched.x, r * sinf(phi) + stretched.y, rest);
}

struct vec3 microfacet_sample(const struct microfacets *d, struct vec3 v, const float u[2]) {
    struct vec3 stretched = normalize(vec(d->alpha_u * v.x, d->alpha_v * v.y, v.z));
    struct vec3 m =
        d->kind == MICROFACET_BECKMANN ? sample_beckmann(stretched, u) : sample_ggx(stretched, u);
    return normalize(vec(d->alpha_u * m.x, d->alpha_v * m.y, m.z));
}
