/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_DRESS_H
#define FEWRAY_TRAIN_DRESS_H

/* From a diffuse surface's colours to a real material, in mixed stages. */

#include "guide/train/scenes/stage.h"

enum dress_role { ROLE_WALL, ROLE_FLOOR, ROLE_WOOD, ROLE_ANY };

/* Changes the stage's material `index`, maybe, to what suits the role; returns index. Nothing
 * happens on a diffuse stage. */
int dress(struct stage *stage, int index, enum dress_role role);

/* Each adds one material and returns its index. */
int surface_glass(struct stage *stage); /* for closed shapes */
int surface_pane(struct stage *stage);  /* thin: for single sheets */
int surface_metal(struct stage *stage);
int surface_mirror(struct stage *stage);
int surface_print(struct stage *stage); /* a poster, a book's cover: a picture seen once */
int surface_leaf(struct stage *stage);

#endif
