/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_CAMERA_H
#define FEWRAY_GUIDE_CAMERA_H

#include "guide/scene/scene.h"

/* lens: in [0, 1), a point of the aperture, uniform over its disk; unused by a pinhole. Origin and
 * unit direction of the camera ray through (x, y), in pixels from the upper left corner of a
 * picture of width x height pixels. The field of view is the scene's, along the width. */
void camera_ray(const struct camera *camera, int width, int height, float x, float y,
                const float lens[2], struct vec3 *origin, struct vec3 *direction);

#endif
