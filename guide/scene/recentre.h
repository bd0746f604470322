/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_RECENTRE_H
#define FEWRAY_GUIDE_SCENE_RECENTRE_H

/* Scenes far from the origin. Floats resolve a position to 6e-8 of its distance from the origin,
 * and rays leave a surface by more than that: of a scene that is small against its distance
 * nothing would be left. */

#include "guide/scene/scene.h"

/* Moves the origin into the scene along the axes where the surfaces' middle is many times as far
 * away as they reach; scene->origin tells by how much. The differences are exact, so that only the
 * file's own positions are rounded. */
void scene_recentre(struct fewray_scene *scene, int threads);

#endif
