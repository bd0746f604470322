/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_HOST_H
#define FEWRAY_GUIDE_HOST_H

/* Another renderer's guide: its first look as our records, and what is made of them. */

#include <omp.h>

#include "fewray/guiding.h"
#include "guide/odis/look.h"
#include "guide/odis/maps.h"

struct fewray_guide {
    struct fewray_maps *maps;
    int threads; /* of the functions on arrays */
    int samples; /* of the look, a pixel */
    bool learns;
};

static inline struct vec3 host_load(const float v[3]) {
    return vec(v[0], v[1], v[2]);
}

static inline void host_store(struct vec3 v, float out[3]) {
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

/* Within what another renderer's rounding leaves. */
static inline bool host_is_unit(struct vec3 v) {
    return fabsf(dot(v, v) - 1) <= 1e-3f;
}

static inline bool host_is_radiance(struct vec3 v) {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && mean_component(v) <= LOOK_RADIANCE_MAX;
}

/* Checks the arrays, leaves bad records out and counts them in stats. *out is owned by the caller:
 * fewray_look_destroy(). */
int host_look_create(const struct fewray_guide_look *look, int threads, struct fewray_look **out,
                     struct fewray_guide_stats *stats, struct fewray_error *error);

#endif
