/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_THINGS_H
#define FEWRAY_TRAIN_THINGS_H

/* Things of mixed scenes: round bodies, glass, mirrors, foliage, fences. A place's origin is on the
 * floor under the thing's middle. */

#include "guide/train/scenes/stage.h"

/* A small thing for tables and floors, about `size` metres high. */
void build_ware(struct stage *stage, struct xform place, float size);
/* Thick or thin, whole: a vase, bottle or bowl of revolution. */
void build_vessel(struct stage *stage, struct xform place, float height, int material);
/* A plant of hundreds of leaves; returns the radius of its footprint. */
float build_foliage(struct stage *stage, struct xform place);
/* Each returns the radius of its footprint in metres. */
float build_fence(struct stage *stage, struct xform place);
float build_column(struct stage *stage, struct xform place);
float build_glass_case(struct stage *stage, struct xform place);
/* A mirror hanging at the place's origin, facing z. */
void build_mirror(struct stage *stage, struct xform place);
/* Books that stand from x0 to x1 at height y, each with its own cover. */
void build_library(struct stage *stage, struct xform place, float x0, float x1, float y, float room,
                   float depth);
/* One of the above that stands freely. */
float build_thing(struct stage *stage, struct xform place);

#endif
