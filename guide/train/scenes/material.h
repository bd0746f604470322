/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_MATERIAL_H
#define FEWRAY_TRAIN_MATERIAL_H

/* What a surface is made of: Mitsuba's BSDFs with the parameters that the generator varies. */

#include <stdbool.h>

#include "guide/vec.h"

enum material_kind {
    MATERIAL_DIFFUSE,
    MATERIAL_PLASTIC,
    MATERIAL_ROUGH_PLASTIC,
    MATERIAL_CONDUCTOR,
    MATERIAL_ROUGH_CONDUCTOR,
    MATERIAL_PRINCIPLED,
    /* From here on they transmit: for closed shapes, but the thin pane. */
    MATERIAL_DIELECTRIC,
    MATERIAL_ROUGH_DIELECTRIC,
    MATERIAL_THIN
};

struct material {
    enum material_kind kind;
    struct vec3 color0, color1; /* a checkerboard where they differ; of glass and metals: a tint */
    float scale_u, scale_v;     /* periods of checkers or picture over the shape's uv range 0..1 */
    int picture;                /* index of the colours' picture, or -1: the two colours alone */
    float alpha;                /* roughness (plastic, conductor, dielectric, principled) */
    bool ggx, nonlinear;        /* microfacets (else Beckmann); plastic: colour shifts inside */
    float ior;                  /* plastic and glass: interior index of refraction */
    const char *metal;          /* conductor: Mitsuba's name of it, static */
    float metallic, specular, clearcoat, sheen; /* principled */
};

static inline bool material_transmits(const struct material *material) {
    return material->kind >= MATERIAL_DIELECTRIC;
}

#endif
