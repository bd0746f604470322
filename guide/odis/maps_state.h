/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_MAPS_STATE_H
#define FEWRAY_GUIDE_MAPS_STATE_H

/* Maps as a part of a render's state: see guide/trace/state.h. */

#include "guide/odis/maps.h"
#include "guide/trace/stream.h"

/* Moves the maps of a picture of this size with their probes and all that they have learnt. Where
 * they are read, *maps is made, and owned by the caller even on failure. */
bool maps_move(struct stream *stream, int width, int height, struct fewray_maps **maps);

#endif
