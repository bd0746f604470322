/* SPDX-License-Identifier: Apache-2.0 */
/* Pinhole and thin lens with Mitsuba's handedness and principal point. */

#include "guide/trace/camera.h"

/* The camera's direction or displacement (x, y, z) in world space. */
static struct vec3 rotate(const float m[12], float x, float y, float z) {
    return vec(m[0] * x + m[1] * y + m[2] * z, m[4] * x + m[5] * y + m[6] * z,
               m[8] * x + m[9] * y + m[10] * z);
}

void camera_ray(const struct camera *camera, int width, int height, float x, float y,
                const float lens[2], struct vec3 *origin, struct vec3 *direction) {
    const float *m = camera->to_world;
    float half = tanf(0.5f * camera->fov_x);
    /* +x of the camera points to the left of the picture. */
    float cx = (1 - 2 * (x / (float)width + camera->principal_x)) * half;
    float cy =
        (1 - 2 * (y / (float)height + camera->principal_y)) * half * (float)height / (float)width;
    *origin = vec(m[3], m[7], m[11]);
    if (camera->aperture_radius > 0 && camera->focus_distance > 0) {
        /* Through a point of the lens to where the pinhole's ray meets the plane of focus. */
        float r = camera->aperture_radius * sqrtf(lens[0]), phi = 2 * PI_F * lens[1];
        float ax = r * cosf(phi), ay = r * sinf(phi);
        *origin = add(*origin, rotate(m, ax, ay, 0));
        cx -= ax / camera->focus_distance;
        cy -= ay / camera->focus_distance;
    }
    *direction = normalize(rotate(m, cx, cy, 1));
}
