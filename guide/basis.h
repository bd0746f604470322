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

/* Local direction with density cos(theta) / pi (solid angle). */
static inline struct vec3 cosine_hemisphere(const float u[2]) {
    float r = sqrtf(u[0]), phi = 2 * PI_F * u[1];
    return vec(r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(0, 1 - u[0])));
}

/* Local direction with density 1 / (2 pi) (solid angle). */
static inline struct vec3 uniform_hemisphere(const float u[2]) {
    float z = 1 - u[0], r = sqrtf(fmaxf(0, 1 - z * z)), phi = 2 * PI_F * u[1];
    return vec(r * cosf(phi), r * sinf(phi), z);
}

/* Direction with density 1 / (4 pi) (solid angle). */
static inline struct vec3 uniform_sphere(const float u[2]) {
    float z = 1 - 2 * u[0], r = sqrtf(fmaxf(0, 1 - z * z)), phi = 2 * PI_F * u[1];
    return vec(r * cosf(phi), r * sinf(phi), z);
}

/* Local direction with density 1 / (2 pi cone) (solid angle); cone = 1 - cos of its half angle. */
static inline struct vec3 uniform_cone(float cone, const float u[2]) {
    float below = u[0] * cone, phi = 2 * PI_F * u[1];
    float sine = sqrtf(fmaxf(0, below * (2 - below)));
    return vec(sine * cosf(phi), sine * sinf(phi), 1 - below);
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
