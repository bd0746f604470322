/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_LIGHT_SOURCE_H
#define FEWRAY_GUIDE_LIGHT_SOURCE_H

/* One light within the scene: an emitting triangle or sphere, a point or spot light. */

#include "guide/light/light_bounds.h"
#include "guide/light/lights.h"

/* Mean luminance of a texture over [0, 1]^2, above 0 wherever it isn't black everywhere. */
float texture_mean_luminance(const struct texture *texture);

/* The source's bounds and its flux (W), both 0 where it is black. mean: of its texture, as above;
 * a triangle looks at its own part of it, too. */
struct light_bounds source_bounds(const struct fewray_scene *scene,
                                  const struct light_source *source, float mean, float *flux);
double source_area(const struct fewray_scene *scene, const struct light_source *source);

/* What `from` gets by one point of the source, without the chance of picking the source. */
struct light_sample source_sample(const struct fewray_scene *scene,
                                  const struct light_source *source, struct vec3 from,
                                  const float u[2]);
/* The density (solid angle) with which source_sample() draws a surface's point that a ray from
 * `from` hit. */
float source_pdf(const struct light_source *source, struct vec3 from, struct vec3 direction,
                 const struct surface *hit);

#endif
