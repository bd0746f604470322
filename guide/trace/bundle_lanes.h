/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_BUNDLE_LANES_H
#define FEWRAY_GUIDE_BUNDLE_LANES_H

/* Sixteen values side by side. Loops over them are written so that the compiler turns each into
 * vector instructions: no calls that it can't see through, choices between values alone. */

#include "guide/basis.h"
#include "guide/trace/bundle.h"

#define LANES           BUNDLE_LANES
#define EACH_LANE(i)    for (int i = 0; i < LANES; i++)
#define LANES_ALIGNMENT __attribute__((aligned(64)))

struct vec3_lanes {
    float x[LANES], y[LANES], z[LANES];
} LANES_ALIGNMENT;

static inline struct vec3 lane_get(const struct vec3_lanes *v, int i) {
    return vec(v->x[i], v->y[i], v->z[i]);
}

static inline void lane_set(struct vec3_lanes *v, int i, struct vec3 a) {
    v->x[i] = a.x;
    v->y[i] = a.y;
    v->z[i] = a.z;
}

/* The sampler's next point for each lane; see sampler_2d(). */
static inline void lanes_2d(const uint32_t seed[LANES], const uint32_t index[LANES],
                            uint32_t dimension[LANES], float u[2][LANES]) {
    EACH_LANE(i) {
        float point[2];
        sobol_point(index[i], hash_combine(seed[i], dimension[i]), point);
        u[0][i] = point[0];
        u[1][i] = point[1];
        dimension[i]++;
    }
}

#endif
