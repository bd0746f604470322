/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_TEXTURE_H
#define FEWRAY_GUIDE_TEXTURE_H

#include "guide/scene/scene.h"

/* Linear RGB at a surface's uv; bitmaps repeat and, as in Mitsuba, v = 0 is the picture's top row.
 */
struct vec3 texture_value(const struct texture *texture, float u, float v);

#endif
