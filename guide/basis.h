/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_BASIS_H
#define FEWRAY_GUIDE_BASIS_H

/* Orthonormal bases and the usual warps of the unit square. */

#include "guide/vec.h"

struct basis {
    struct vec3 s, t, n;
};

/* Duff et al. 2017, "Building an Orthonormal Basis, Revisited". n has unit length. */
static inline struct basis basis_around(struct vec3 n) {
    float sign = copysignf(1, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    return (struct basis){vec(1 + sign * n.x * n.x * a, sign * b, -sign * n.x),
                          vec(b, sign + n.y * n.y * a, -n.y), n};
}

static inline struct vec3 to_world(const struct basis *b, struct vec3 v) {
    return add(add(scale(b->s, v.x), scale(b->t, v.y)), scale(b->n, v.z));
}

/* sin and cos of 2 pi u for u in [0, 1): to the nearest quarter turn and a polynomial (Taylor's,
 * whose error is below 2e-8 within an eighth of a turn). */
static inline void sin_cos_turns(float u, float *sine, float *cosine) {
    float quarter = floorf(4 * u + 0.5f);
    float a = (u - 0.25f * quarter) * (2 * PI_F), a2 = a * a;
    float s = a * (1 + a2 * (-1.f / 6 + a2 * (1.f / 120 + a2 * (-1.f / 5040 + a2 / 362880))));
    float c = 1 + a2 * (-0.5f + a2 * (1.f / 24 + a2 * (-1.f / 720 + a2 / 40320)));
    bool odd = quarter == 1 || quarter == 3;
    float first = odd ? c : s, second = odd ? s : c;
    *sine = quarter >= 2 && quarter < 4 ? -first : first;
    *cosine = quarter == 1 || quarter == 2 ? -second : second;
}

/* Local direction with density cos(theta) / pi (solid angle). */
static inline struct vec3 cosine_hemisphere(const float u[2]) {
    float r = sqrtf(u[0]), sine, cosine;
    sin_cos_turns(u[1], &sine, &cosine);
    return vec(r * cosine, r * sine, sqrtf(max_float(0, 1 - u[0])));
}

/* Local direction with density 1 / (2 pi) (solid angle). */
static inline struct vec3 uniform_hemisphere(const float u[2]) {
    float z = 1 - u[0], r = sqrtf(max_float(0, 1 - z * z)), sine, cosine;
    sin_cos_turns(u[1], &sine, &cosine);
    return vec(r * cosine, r * sine, z);
}

/* Direction with density 1 / (4 pi) (solid angle). */
static inline struct vec3 uniform_sphere(const float u[2]) {
    float z = 1 - 2 * u[0], r = sqrtf(max_float(0, 1 - z * z)), sine, cosine;
    sin_cos_turns(u[1], &sine, &cosine);
    return vec(r * cosine, r * sine, z);
}

/* Local direction with density 1 / (2 pi cone) (solid angle); cone = 1 - cos of its half angle. */
static inline struct vec3 uniform_cone(float cone, const float u[2]) {
    float below = u[0] * cone, r = sqrtf(max_float(0, below * (2 - below))), sine, cosine;
    sin_cos_turns(u[1], &sine, &cosine);
    return vec(r * cosine, r * sine, 1 - below);
}

/* Veach 1997, eq. 9.12 (power heuristic, beta = 2) for one sample of each of two techniques.
 * Divides first, so that no density overflows. */
static inline float power_heuristic(float pdf, float other_pdf) {
    if (!(pdf > 0))
        return 0;
    float r = other_pdf / pdf;
    return 1 / (1 + r * r);
}

#endif
