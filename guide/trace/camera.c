/* SPDX-License-Identifier: Apache-2.0 */
/* Pinhole and thin lens with Mitsuba's handedness and principal point. */

#include "guide/trace/camera.h"

struct camera_view camera_view(const struct camera *camera, int width, int height) {
    struct camera_view view = {.camera = camera,
                               .width = (float)width,
                               .height = (float)height,
                               .half = tanf(0.5f * camera->fov_x)};
    view.has_lens = camera->aperture_radius > 0 && camera->focus_distance > 0;
    return view;
}

void camera_ray(const struct camera *camera, int width, int height, float x, float y,
                const float lens[2], struct vec3 *origin, struct vec3 *direction) {
    const struct camera_view view = camera_view(camera, width, height);
    camera_view_ray(&view, x, y, lens, origin, direction);
}
