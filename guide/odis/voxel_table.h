/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_VOXEL_TABLE_H
#define FEWRAY_GUIDE_VOXEL_TABLE_H

/* Numbers for the voxels that points fall into, apart for the six main axes of their normals. */

#include <stdbool.h>
#include <stdint.h>

#include "guide/vec.h"

struct voxel_table {
    float side;       /* of a voxel, scene units; the origin lies in the middle of one */
    int count;        /* numbers given so far */
    uint32_t size;    /* power of 2; 0: nothing was added */
    uint64_t *keys;   /* (size) open addressing; voxel and axis, 0 = free */
    int32_t *numbers; /* (size) */
};

/* The number of a point's voxel, a new one where it has none; -1 without memory. */
int voxel_table_add(struct voxel_table *table, struct vec3 position, struct vec3 normal);
/* The number, or -1 where there is none. */
int voxel_table_find(const struct voxel_table *table, struct vec3 position, struct vec3 normal);
void voxel_table_clear(struct voxel_table *table);

#endif
