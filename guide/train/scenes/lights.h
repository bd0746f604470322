/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_LIGHTS_H
#define FEWRAY_TRAIN_LIGHTS_H

/* Electric lights of a room that stands on y = 0 about its place's origin. Each brings `share` of
 * mean irradiance. */

#include "guide/train/scenes/stage.h"

struct room_size {
    float width, depth, height; /* metres: x, z, y */
};

void light_ceiling(struct stage *stage, struct xform place, struct room_size size, float share);
/* Strips behind a ledge under the ceiling, shining up. */
void light_cove(struct stage *stage, struct xform place, struct room_size size, float share);
/* A panel that shines at a wall from behind a board. */
void light_hidden(struct stage *stage, struct xform place, struct room_size size, float share);
/* Many small bulbs or spots. */
void light_many(struct stage *stage, struct xform place, struct room_size size, float share);
/* A glowing thing in a wall: a screen, a fire, a lamp box. */
void light_glow(struct stage *stage, struct xform place, struct room_size size, float share);
/* A lamp with a shade, standing or hanging, at a random spot. */
void light_lamp(struct stage *stage, struct xform place, struct room_size size, float share);

/* bulbs.c, for mixed stages: */
void light_swarm(struct stage *stage, struct xform place, struct room_size size, float share);
void light_bare(struct stage *stage, struct xform place, struct room_size size, float share);
void light_tubes(struct stage *stage, struct xform place, struct room_size size, float share);
void light_points(struct stage *stage, struct xform place, struct room_size size, float share);

#endif
