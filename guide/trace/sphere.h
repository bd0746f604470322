/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SPHERE_H
#define FEWRAY_GUIDE_SPHERE_H

/* Analytic spheres: as a user geometry of Embree, and what a hit on one looks like. */

#include "guide/trace/surface.h"

/* A geometry of one primitive, the mesh, which must outlive it; to be committed and attached. NULL
 * without memory. */
RTCGeometry sphere_geometry(RTCDevice device, const struct mesh *mesh);

/* Texture coordinates of a point as Mitsuba's: azimuth and polar angle in the sphere's own axes,
 * both in 0..1. outward: unit, from the centre. */
void sphere_uv(const struct mesh *mesh, struct vec3 outward, float *u, float *v);
/* Fills all that depends on the place on the sphere, but the tangents. outward: from the centre to
 * the hit, of any length but 0. */
void sphere_fill(const struct mesh *mesh, struct vec3 outward, struct surface *out);
/* dp_du and dp_dv of a surface that sphere_fill() made; dp_du is 0 at the poles, as Mitsuba's. */
void sphere_fill_tangents(const struct mesh *mesh, struct surface *out);

#endif
