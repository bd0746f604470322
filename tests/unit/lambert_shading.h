/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_LAMBERT_SHADING_H
#define FEWRAY_TESTS_LAMBERT_SHADING_H

#include "guide/bsdf/bsdf.h"

/* A white Lambertian surface point, seen from the side of its unit normal. */
static inline struct shading lambert_shading(struct vec3 normal) {
    static const struct bsdf diffuse = {.kind = BSDF_DIFFUSE};
    struct shading s = {.normal = normal, .geometric_normal = normal, .scatters = true, .count = 1};
    struct bsdf_local *b = &s.locals[0];
    *b = (struct bsdf_local){
        .bsdf = &diffuse, .weight = 1, .outgoing = {0, 0, 1}, .reflectance = {1, 1, 1}};
    b->frame.n = normal;
    diffuse_prepare(b);
    s.albedo = b->albedo;
    s.breadth = b->breadth;
    return s;
}

#endif
