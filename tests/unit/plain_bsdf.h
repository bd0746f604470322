/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_PLAIN_BSDF_H
#define FEWRAY_TESTS_PLAIN_BSDF_H

/* One BSDF whose parameters are constant textures, at a point in its own local space. */

#include "guide/bsdf/bsdf_local.h"

enum { PLAIN_REFLECTANCE, PLAIN_SPECULAR, PLAIN_ALPHA, PLAIN_PRINCIPLED };

struct plain_bsdf {
    struct texture textures[PLAIN_PRINCIPLED + PRINCIPLED_COUNT];
    struct bsdf bsdf;
    struct bsdf_table table;
};

/* values: principled's, or NULL. */
static inline void plain_bsdf_init(struct plain_bsdf *p, enum bsdf_kind kind, float eta,
                                   struct vec3 reflectance, float alpha, const float *values) {
    *p = (struct plain_bsdf){.bsdf = {.kind = kind,
                                      .eta = eta,
                                      .reflectance = PLAIN_REFLECTANCE,
                                      .specular_reflectance = PLAIN_SPECULAR,
                                      .alpha_u = PLAIN_ALPHA,
                                      .alpha_v = PLAIN_ALPHA}};
    p->textures[PLAIN_REFLECTANCE].color0 = reflectance;
    p->textures[PLAIN_SPECULAR].color0 = vec(1, 1, 1);
    p->textures[PLAIN_ALPHA].color0 = vec(alpha, alpha, alpha);
    for (int i = 0; i < PRINCIPLED_COUNT; i++) {
        float v = values ? values[i] : 0;
        p->bsdf.principled[i] = PLAIN_PRINCIPLED + i;
        p->textures[PLAIN_PRINCIPLED + i].color0 = vec(v, v, v);
    }
}

static inline void plain_bsdf_table(struct plain_bsdf *p) {
    const struct fewray_scene scene = {.textures = p->textures};
    bsdf_table_fill(&scene, &p->bsdf, &p->table);
}

/* Not prepared yet. */
static inline struct bsdf_local plain_bsdf_at(const struct plain_bsdf *p, struct vec3 outgoing) {
    struct bsdf_local b = {.bsdf = &p->bsdf,
                           .table = &p->table,
                           .weight = 1,
                           .outgoing = outgoing,
                           .reflectance = p->textures[PLAIN_REFLECTANCE].color0,
                           .specular_reflectance = p->textures[PLAIN_SPECULAR].color0,
                           .alpha_u = p->textures[PLAIN_ALPHA].color0.x,
                           .alpha_v = p->textures[PLAIN_ALPHA].color0.x};
    for (int i = 0; i < PRINCIPLED_COUNT; i++)
        b.principled[i] = p->textures[PLAIN_PRINCIPLED + i].color0.x;
    return b;
}

/* Unit, at this cosine to the normal and azimuth. */
static inline struct vec3 direction_at(float cos_theta, float phi) {
    float r = sqrtf(fmaxf(1 - cos_theta * cos_theta, 0));
    return vec(r * cosf(phi), r * sinf(phi), cos_theta);
}

#endif
