/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_PERTURB_H
#define FEWRAY_GUIDE_PERTURB_H

/* Bump and normal maps: they turn the frame in which a BSDF scatters. After Mitsuba 3's `bumpmap`
 * and `normalmap`. */

#include "guide/basis.h"
#include "guide/trace/surface.h"

/* The axes of a BSDF_BUMP_MAP's or BSDF_NORMAL_MAP's frame in the coordinates of `shading`, the
 * frame of the surface as the mesh has it: n its shading normal, s along dp/du. outgoing: towards
 * the viewer, in local coordinates, z > 0 in front. */
struct basis perturbed_axes(const struct fewray_scene *scene, const struct bsdf *bsdf,
                            const struct surface *surface, const struct basis *shading,
                            struct vec3 outgoing);

/* Estevez, Lecocq and Stein 2019, "A Microfacet-Based Shadowing Function to Solve the Bump
 * Terminator Problem": squared roughness (section 3, from the angle between both normals), and the
 * share of the light left from a direction with cosine `cos_theta` to the unperturbed normal. */
float terminator_alpha2(float cos_between_normals);
float terminator_shadowing(float alpha2, float cos_theta);

#endif
