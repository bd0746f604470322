/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_LIGHT_BOUNDS_H
#define FEWRAY_GUIDE_LIGHT_BOUNDS_H

/* Where lights are and into which directions they shine: Conty Estevez and Kulla 2018, "Importance
 * Sampling of Many Lights with Adaptive Tree Splitting", section 4. */

#include "guide/vec.h"

struct light_bounds {
    struct vec3 low, high; /* box around the lights */
    struct vec3 axis;      /* unit; of the cone of normals */
    float theta_o;         /* the normals' greatest angle to the axis, radians, 0..pi */
    float theta_e;         /* how far beyond its normal a light shines, radians, 0..pi/2 */
    float phi;             /* radiant intensity along the normal, sum of luminances; 0: no light */
};

struct light_bounds light_bounds_none(void);
struct light_bounds light_bounds_union(const struct light_bounds *a, const struct light_bounds *b);
struct vec3 light_bounds_centre(const struct light_bounds *b);
/* Radius of the sphere around the box. */
float light_bounds_radius(const struct light_bounds *b);
/* The cluster's cost, eq. 2 without the scene's constants: phi times the measure of its directions
 * times the area of the sphere around it. */
float light_bounds_cost(const struct light_bounds *b);

#endif
