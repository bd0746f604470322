/* SPDX-License-Identifier: Apache-2.0 */
/* The motion of still surfaces between two frames, from the cameras of both. */

#include "guide/trace/camera.h"

static struct camera pinhole(const struct fewray_view *view) {
    struct camera camera = {
        .fov_x = view->fov_x, .principal_x = view->principal_x, .principal_y = view->principal_y};
    for (int i = 0; i < 12; i++)
        camera.to_world[i] = view->to_world[i];
    return camera;
}

/* Where the camera sees a point, in pixels from the upper left corner; the inverse of camera_ray().
 * Returns its distance, 0 where it is behind the camera. */
static float project(const struct camera *camera, int width, int height, struct vec3 point,
                     float pixel[2]) {
    const float *m = camera->to_world;
    const struct vec3 d = sub(point, vec(m[3], m[7], m[11]));
    const float half = tanf(0.5f * camera->fov_x);
    const float z = dot(d, vec(m[2], m[6], m[10]));
    if (!(z > 0))
        return 0;
    const float cx = dot(d, vec(m[0], m[4], m[8])) / (z * half);
    const float cy = dot(d, vec(m[1], m[5], m[9])) / (z * half) * (float)width / (float)height;
    pixel[0] = (0.5f * (1 - cx) - camera->principal_x) * (float)width;
    pixel[1] = (0.5f * (1 - cy) - camera->principal_y) * (float)height;
    return length(d);
}

void fewray_view_motion(const struct fewray_view *now, const struct fewray_view *before, int width,
                        int height, const float *depth, float *motion_x, float *motion_y,
                        float *previous_depth) {
    static const float lens[2] = {0, 0};
    const struct camera here = pinhole(now), there = pinhole(before);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            const float px = (float)x + 0.5f, py = (float)y + 0.5f;
            float pixel[2] = {px, py};
            struct vec3 origin, direction;
            camera_ray(&here, width, height, px, py, lens, &origin, &direction);
            previous_depth[i] = 0;
            if (depth[i] > 0)
                previous_depth[i] =
                    project(&there, width, height, add(origin, scale(direction, depth[i])), pixel);
            motion_x[i] = pixel[0] - px;
            motion_y[i] = pixel[1] - py;
        }
}
