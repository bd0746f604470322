/* SPDX-License-Identifier: Apache-2.0 */
/* Pinhole camera with Mitsuba's handedness. */

#include "guide/trace/camera.h"

void camera_ray(const struct camera *camera, int width, int height, float x, float y,
                struct vec3 *origin, struct vec3 *direction) {
    const float *m = camera->to_world;
    float half = tanf(0.5f * camera->fov_x);
    /* +x of the camera points to the left of the picture. */
    float cx = (1 - 2 * x / (float)width) * half;
    float cy = (1 - 2 * y / (float)height) * half * (float)height / (float)width;
    struct vec3 d = vec(m[0] * cx + m[1] * cy + m[2], m[4] * cx + m[5] * cy + m[6],
                        m[8] * cx + m[9] * cy + m[10]);
    *origin = vec(m[3], m[7], m[11]);
    *direction = normalize(d);
}
