/* SPDX-License-Identifier: Apache-2.0 */
/* Maps by their place in the world: a path that comes back to a surface which the camera sees finds
 * what its first vertices are guided by. */

#include <stdlib.h>

#include "guide/odis/maps.h"
#include "guide/odis/probes.h"

#define VOXELS_A_PROBE 2 /* along a side of a probe's voxel */

static float squared_distance_to_centre(const struct voxel_table *voxels, struct vec3 p) {
    struct vec3 cell = scale(p, 1 / voxels->side);
    struct vec3 d = vec(cell.x - roundf(cell.x), cell.y - roundf(cell.y), cell.z - roundf(cell.z));
    return dot(d, d);
}

bool maps_find_places(struct fewray_maps *maps) {
    struct voxel_table *voxels = &maps->places;
    voxels->side = maps->probes->fine.voxels.side / VOXELS_A_PROBE;
    maps->place_maps = malloc(((size_t)maps->count + 1) * sizeof(*maps->place_maps));
    if (!maps->place_maps)
        return false;
    for (int k = 0; k < maps->columns * maps->rows; k++) {
        int m = maps->index[k];
        if (m < 0)
            continue;
        const struct map *map = &maps->maps[m];
        int known = voxels->count;
        int place = voxel_table_add(voxels, map->position, map->normal);
        if (place < 0)
            return false;
        if (place == known ||
            squared_distance_to_centre(voxels, map->position) <
                squared_distance_to_centre(voxels, maps->maps[maps->place_maps[place]].position))
            maps->place_maps[place] = m;
    }
    return true;
}

const struct map *maps_near(const struct fewray_maps *maps, struct vec3 position,
                            struct vec3 normal) {
    int place = voxel_table_find(&maps->places, position, normal);
    return place < 0 ? NULL : &maps->maps[maps->place_maps[place]];
}
