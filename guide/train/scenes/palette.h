/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_PALETTE_H
#define FEWRAY_TRAIN_PALETTE_H

/* Random colours and surfaces. Reflectances stay below 0.92. */

#include "guide/train/scenes/stage.h"

struct vec3 color_hsv(float hue, float saturation, float value);
struct vec3 color_any(struct random *r);
/* Of a light: luminance about 1, from candle to daylight, seldom coloured. */
struct vec3 color_light(struct random *r);

/* Surfaces; each adds one material and returns its index. */
int surface_wall(struct stage *stage);
int surface_floor(struct stage *stage);
int surface_wood(struct stage *stage);
int surface_any(struct stage *stage);

#endif
