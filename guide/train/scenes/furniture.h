/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_FURNITURE_H
#define FEWRAY_TRAIN_FURNITURE_H

/* Things that stand in rooms. A place's origin is on the floor under the thing's middle, z towards
 * its front. */

#include "guide/train/scenes/stage.h"

/* furniture.c: each returns the radius of its footprint in metres. */
float build_table(struct stage *stage, struct xform place, bool laid);
float build_chair(struct stage *stage, struct xform place);
float build_shelf(struct stage *stage, struct xform place);
float build_sofa(struct stage *stage, struct xform place);
float build_bed(struct stage *stage, struct xform place);
float build_cabinet(struct stage *stage, struct xform place);

/* objects.c: smaller and stranger things. */
/* n small things on the rectangle of these half sizes at the place's y = 0. */
void build_clutter(struct stage *stage, struct xform place, float half_x, float half_z, float size,
                   int n);
float build_stack(struct stage *stage, struct xform place);
float build_plant(struct stage *stage, struct xform place);
float build_bars(struct stage *stage, struct xform place);
float build_partition(struct stage *stage, struct xform place);
float build_steps(struct stage *stage, struct xform place);
float build_boulder(struct stage *stage, struct xform place);
/* A picture hanging at the place's origin, facing z. */
void build_picture(struct stage *stage, struct xform place);
void build_rug(struct stage *stage, struct xform place);

/* One of all the above that stands freely. */
float build_something(struct stage *stage, struct xform place);

#endif
