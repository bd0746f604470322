/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_DIRECT_LIGHT_H
#define FEWRAY_GUIDE_DIRECT_LIGHT_H

/* Next-event estimation at a path's vertex. */

#include "guide/trace/integrator.h"

/* The normal by which lights are picked: none where light may come from below, too. */
static inline struct vec3 light_side(const struct shading *s) {
    return s->transmits ? vec(0, 0, 0) : s->normal;
}

/* What next-event estimation brings. */
struct direct {
    struct vec3 radiance;   /* towards the viewer */
    struct vec3 irradiance; /* over pi: what a white diffuse surface would reflect */
};

/* Next-event estimation, MIS-weighted against a bounce of density `bounce_pdf` > 0 (0: drawn from
 * `p`). Where a probe expects no light the shadow ray plays Russian roulette, whose chance counts
 * as part of the light's density. */
struct direct direct_light(const struct fewray_world *world, const struct shading *s,
                           struct sampler *sampler, const struct proposal *p, float bounce_pdf,
                           int *rays, struct look_second *second);

#endif
