/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_GATHER_H
#define FEWRAY_GUIDE_GATHER_H

/* The first look around a grid point, binned over the sphere: the network's input. */

#include <stdbool.h>

#include "guide/odis/look.h"
#include "guide/odis/sphere_grid.h"

#define BLOCK_SIZE 8 /* pixels a side of the blocks that records are gathered by */

/* Input planes (paper, section 4.1, "Input features", and second moments). Bins without samples are
 * 0. "Pooled" is over the records whose second vertices are close (look_record.mean, .moment). */
enum gather_plane {
    GATHER_RADIANCE,      /* range-compressed pooled mean radiance / scale */
    GATHER_POOLED_MOMENT, /* range-compressed pooled root second moment / scale */
    GATHER_MOMENT,        /* range-compressed root second moment of the bin's own samples / scale */
    GATHER_COUNT,         /* log2(1 + samples in the bin) / 4 */
    GATHER_DEPTH,         /* mean first-hit depth / the grid point's, at most 4 */
    GATHER_NORMAL,        /* 3 planes: mean first-hit normal */
    GATHER_DISTANCE = 8,  /* log(1 + mean second-hit distance / the grid point's depth) */
    GATHER_SECOND_NORMAL, /* 3 planes: mean second-hit normal */
    GATHER_PLANES = 12
};

struct gathered {
    bool
        valid; /* the grid point lies on a surface that light reaches as far as the look can tell */
    struct vec3 position, normal;
    float scale; /* mean pooled radiance over the filled bins; radiance in all planes is relative to
                    it */

    float planes[GATHER_PLANES][SPHERE_BINS];
    float mask[SPHERE_BINS];   /* 1 where the bin got samples and lies above the horizon, else 0 */
    float cosine[SPHERE_BINS]; /* of the bin's centre to the normal; 0 below the horizon */
    float fill[SPHERE_BINS];   /* log of the pooled root second moment / scale, holes filled from
                                  coarser bins */
};

/* The paper's eq. 3 with mu = 5000, and its inverse. */
float range_compress(float radiance);
float range_expand(float compressed);

/* Bins the records of blocks i0 <= i < i1, j0 <= j < j1 (columns and rows, clamped to the picture)
 * as seen from the surface at pixel (x, y), which should lie inside. */
void gather(const struct fewray_look *look, int i0, int j0, int i1, int j1, int x, int y,
            struct gathered *out);

#endif
