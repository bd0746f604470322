/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_CAMERA_PATH_H
#define FEWRAY_GUIDE_SCENE_CAMERA_PATH_H

/* How a camera moves: poses at some times, and those between them. */

#include "guide/scene/scene.h"
#include "guide/scene/transform.h"

/* The pose of a rigid transform, which may mirror. False where it scales or shears: its axes
 * should be orthogonal and of unit length within 1e-3. */
bool camera_key_make(const struct transform *to_world, double time, struct camera_key *out);

/* The pose at a time: positions go straight from key to key, rotations by the shortest arc at an
 * even speed (Shoemake 1985, "Animating rotation with quaternion curves"); before the first and
 * after the last key it rests. keys: in the order of their times, at least one. to_world: as in
 * struct camera. */
void camera_path_at(const struct camera_key *keys, int count, double time, float to_world[12]);

#endif
