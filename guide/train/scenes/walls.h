/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_WALLS_H
#define FEWRAY_TRAIN_WALLS_H

/* Walls with openings, and what fills the openings. A wall's place: x along its length, y up, z
 * into the room; it fills z from -thickness to 0. */

#include "guide/train/scenes/stage.h"

#define WALL_OPENINGS 4

struct opening {
    float x0, x1, y0, y1;
};

struct wall {
    struct xform place;
    float length, height, thickness;
    int material;
    int opening_count; /* in order of x, apart from each other */
    struct opening openings[WALL_OPENINGS];
};

void build_wall(struct stage *stage, const struct wall *wall);

/* Frame, mullions, bars, blinds, shutters or curtains; all of them leave light a way. */
void build_window(struct stage *stage, const struct wall *wall, const struct opening *opening);
/* panes.c: a sheet of glass, a fine grid, or nothing; for mixed stages. */
void build_glazing(struct stage *stage, const struct wall *wall, const struct opening *opening);
/* Frame and a leaf that stands ajar. */
void build_door(struct stage *stage, const struct wall *wall, const struct opening *opening);
/* A closed, lit room behind an opening; share: the irradiance that its lights would bring to the
 * stage. */
void build_neighbour(struct stage *stage, const struct wall *wall, const struct opening *opening,
                     float share);

#endif
