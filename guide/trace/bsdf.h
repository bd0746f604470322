/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_BSDF_H
#define FEWRAY_GUIDE_BSDF_H

/* Scattering at a surface point. */

#include "guide/trace/surface.h"

/* A surface point as one BSDF sees it from one side. */
struct shading {
    struct vec3 position, geometric_normal;
    struct vec3
        normal; /* unit shading normal, on the side of the viewer where the material has one */
    struct vec3 albedo; /* diffuse reflectance, 0..1 */
    bool scatters;      /* false: black from this side */
};

/* outgoing: unit direction towards the viewer. */
struct shading bsdf_at(const struct fewray_scene *scene, const struct surface *surface,
                       struct vec3 outgoing);
/* Lambert: f * cos(theta) for light from the unit direction `incident`. */
struct vec3 bsdf_times_cosine(const struct shading *shading, struct vec3 incident);
/* Draws an incident direction with density bsdf_pdf() (solid angle). */
struct vec3 bsdf_sample(const struct shading *shading, const float u[2]);
float bsdf_pdf(const struct shading *shading, struct vec3 incident);

#endif
