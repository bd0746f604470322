/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_PREVIEW_H
#define FEWRAY_TRAIN_PREVIEW_H

/* A crude path tracer over a stage's shapes: enough to judge a camera and to set the exposure. */

#include "guide/train/scenes/stage.h"

struct hit {
    float distance;
    struct vec3 position, normal; /* world space; the normal is the shape's own */
    int shape;
};

/* Glass is passed by unless see_glass. */
bool preview_hit(const struct stage *stage, struct vec3 origin, struct vec3 dir, float farthest,
                 bool see_glass, struct hit *hit);
/* World space, at a point of the unit shape (no mesh). */
struct vec3 preview_normal(const struct shape *shape, struct vec3 local);
/* What a camera sees, from its first hits alone; depths in world units, the sky counts as far. */
struct view {
    float nearest, near_depth, median_depth; /* 0th, 5th and 50th percentile */
    int shapes;                              /* different shapes seen */
    float largest_share;                     /* of the picture that one shape fills */
    float sky_share;
};
struct view preview_view(const struct stage *stage, const struct camera_pose *camera, float aspect);

/* Luminance: means over the picture of reflected light (without the brightest 2 %) and of what is
 * seen directly, and the share of pixels that got light. */
struct exposure {
    float reflected, emitted, lit_share;
};
struct exposure preview_exposure(const struct stage *stage, const struct camera_pose *camera,
                                 float aspect, struct random *random);

#endif
