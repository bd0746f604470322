/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_FRESNEL_H
#define FEWRAY_GUIDE_FRESNEL_H

/* What smooth boundaries reflect of unpolarized light, and where they bend it. */

#include "guide/vec.h"

struct fresnel {
    float reflectance;
    float cos_t; /* of the refracted direction: its sign is the opposite of cos_i's; 0 where
                    all is reflected */
    float eta_it, eta_ti; /* index of the transmitted side over the incident one's, and inverse */
};

/* Between dielectrics (Fresnel's equations, e.g. Walter et al. 2007, section 5.1, eq. 22).
 * eta: of the side with cos < 0 over that of the other; cos_i: of a direction on either side. */
static inline struct fresnel fresnel_dielectric(float cos_i, float eta) {
    struct fresnel f;
    float inverse = 1 / eta;
    f.eta_it = cos_i >= 0 ? eta : inverse;
    f.eta_ti = cos_i >= 0 ? inverse : eta;
    float cos_t2 = 1 - (1 - cos_i * cos_i) * f.eta_ti * f.eta_ti;
    float i = fabsf(cos_i), t = sqrtf(fmaxf(cos_t2, 0));
    f.cos_t = cos_i >= 0 ? -t : t;
    if (eta == 1 || !(i > 0)) {
        f.reflectance = eta == 1 ? 0 : 1;
        return f;
    }
    float s = (i - f.eta_it * t) / (i + f.eta_it * t);
    float p = (t - f.eta_it * i) / (t + f.eta_it * i);
    f.reflectance = 0.5f * (s * s + p * p);
    return f;
}

/* From a dielectric onto a conductor with the index eta + i k relative to it (Lazanyi and
 * Szirmay-Kalos 2005, section 2, spell the terms out). cos_i: in [0, 1]. A perfect mirror is eta 0,
 * k 1: exactly 1 at every angle. */
static inline float fresnel_conductor(float cos_i, float eta, float k) {
    float cos2 = cos_i * cos_i, sin2 = 1 - cos2;
    float d = eta * eta - k * k - sin2;
    float root = sqrtf(d * d + 4 * eta * eta * k * k); /* a^2 + b^2 */
    float a = sqrtf(fmaxf(0.5f * (root + d), 0));
    float sum = root + cos2, difference = 2 * a * cos_i;
    float sum_p = root * cos2 + sin2 * sin2, difference_p = difference * sin2;
    if (!(sum + difference > 0) || !(sum_p + difference_p > 0))
        return 1; /* grazing */
    float s = (sum - difference) / (sum + difference);
    float p = s * (sum_p - difference_p) / (sum_p + difference_p);
    return 0.5f * (s + p);
}

static inline struct vec3 fresnel_conductor_rgb(float cos_i, struct vec3 eta, struct vec3 k) {
    return vec(fresnel_conductor(cos_i, eta.x, k.x), fresnel_conductor(cos_i, eta.y, k.y),
               fresnel_conductor(cos_i, eta.z, k.z));
}

/* Share of even light from the thin side that a boundary reflects into it; n: > 1. Walsh 1926, as
 * in Duntley 1942, "The Optical Properties of Diffusing Materials". */
static inline double fresnel_diffuse_exact(double n) {
    double n2 = n * n, n4 = n2 * n2, sum = n2 + 1, difference = n2 - 1;
    return 0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) +
           n2 * difference * difference / (sum * sum * sum) * log((n - 1) / (n + 1)) -
           2 * n * n2 * (n2 + 2 * n - 1) / (sum * (n4 - 1)) +
           8 * n4 * (n4 + 1) / (sum * (n4 - 1) * (n4 - 1)) * log(n);
}

/* Share of even light from all sides that a dielectric boundary reflects; eta: of the far side over
 * the side of the light. The fits that Mitsuba 3 takes: Egan and Hilgeman 1973 below 1, d'Eon and
 * Irving 2011 above; but exact where they are off by more than a per cent, and would make light. */
static inline float fresnel_diffuse_reflectance(float eta) {
    float x = 1 / eta;
    if (eta > 2)
        return (float)fresnel_diffuse_exact((double)eta);
    if (eta < 0.5f)
        return (float)(1 - (1 - fresnel_diffuse_exact(1 / (double)eta)) * (double)(eta * eta));
    if (eta < 1)
        return 0.0636f * x + 0.6681f + eta * (0.7099f - 1.4399f * eta);
    return 0.919317f +
           x * (-3.4793f + x * (6.75335f + x * (-7.80989f + x * (4.98554f - 1.36881f * x))));
}

/* Mirrors v at the unit normal m. */
static inline struct vec3 reflect_at(struct vec3 v, struct vec3 m) {
    return sub(scale(m, 2 * dot(v, m)), v);
}

/* Where light goes on that arrives from the unit direction v at the unit normal m; f:
 * fresnel_dielectric(dot(v, m), eta). */
static inline struct vec3 refract_at(struct vec3 v, struct vec3 m, const struct fresnel *f) {
    return sub(scale(m, dot(v, m) * f->eta_ti + f->cos_t), scale(v, f->eta_ti));
}

#endif
