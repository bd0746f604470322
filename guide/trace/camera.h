/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_CAMERA_H
#define FEWRAY_GUIDE_CAMERA_H

#include "guide/basis.h"
#include "guide/scene/scene.h"

/* What all rays of a picture have in common. */
struct camera_view {
    const struct camera *camera;
    float width, height; /* picture, pixels */
    float half;          /* tangent of half the horizontal field of view */
    bool has_lens;
};
struct camera_view camera_view(const struct camera *camera, int width, int height);

/* lens: in [0, 1), a point of the aperture, uniform over its disk; unused by a pinhole. Origin and
 * unit direction of the camera ray through (x, y), in pixels from the upper left corner of a
 * picture of width x height pixels. The field of view is the scene's, along the width. */
void camera_ray(const struct camera *camera, int width, int height, float x, float y,
                const float lens[2], struct vec3 *origin, struct vec3 *direction);

/* The camera's direction or displacement (x, y, z) in world space. */
static inline struct vec3 camera_rotate(const float m[12], float x, float y, float z) {
    return vec(m[0] * x + m[1] * y + m[2] * z, m[4] * x + m[5] * y + m[6] * z,
               m[8] * x + m[9] * y + m[10] * z);
}

/* camera_ray() of a view. */
static inline void camera_view_ray(const struct camera_view *view, float x, float y,
                                   const float lens[2], struct vec3 *origin,
                                   struct vec3 *direction) {
    const struct camera *camera = view->camera;
    const float *m = camera->to_world;
    /* +x of the camera points to the left of the picture. */
    float cx = (1 - 2 * (x / view->width + camera->principal_x)) * view->half;
    float cy = (1 - 2 * (y / view->height + camera->principal_y)) * view->half * view->height /
               view->width;
    *origin = vec(m[3], m[7], m[11]);
    if (view->has_lens) {
        /* Through a point of the lens to where the pinhole's ray meets the plane of focus. */
        float r = camera->aperture_radius * sqrtf(lens[0]), sine, cosine;
        sin_cos_turns(lens[1], &sine, &cosine);
        float ax = r * cosine, ay = r * sine;
        *origin = add(*origin, camera_rotate(m, ax, ay, 0));
        cx -= ax / camera->focus_distance;
        cy -= ay / camera->focus_distance;
    }
    *direction = normalize(camera_rotate(m, cx, cy, 1));
}

#endif
