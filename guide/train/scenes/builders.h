/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_BUILDERS_H
#define FEWRAY_TRAIN_BUILDERS_H

/* The kinds of scenes. Each fills an empty stage but for its camera. */

#include "guide/train/scenes/stage.h"

/* The share of rooms among all scenes; a room's plan is below it. */
#define ROOMS 0.8f

/* room.c: a furnished room lit through openings, by lamps, or both. */
void build_room(struct stage *stage);
/* outdoor.c: objects on a plane under a sky. */
void build_outdoor(struct stage *stage);
/* outdoor.c: a closed room, evenly lit by large surfaces: guiding can't pay there. */
void build_even_room(struct stage *stage);

/* daylight.c: a sky whose mean radiance is `strength`: a picture, a constant, or a constant and a
 * distant disk as sun. */
void build_sky(struct stage *stage, float strength);
/* daylight.c: ground, houses and trees around a room of this radius (metres) that stands at height
 * 0. */
void build_surroundings(struct stage *stage, float radius, float ground_y);

#endif
