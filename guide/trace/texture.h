/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_TEXTURE_H
#define FEWRAY_GUIDE_TEXTURE_H

#include "guide/scene/scene.h"

/* Linear RGB at a surface's uv. As in Mitsuba, v = 0 is the picture's top row. Of a texture with a
 * `channel`, that channel thrice; an image without it gives 1 for alpha, else its last colour. */
struct vec3 texture_value(const struct texture *texture, float u, float v);

/* Derivatives of the value's luminance by u and v: those of the bilinear filter, 0 where nothing is
 * filtered. */
void texture_gradient(const struct texture *texture, float u, float v, float gradient[2]);

#endif
