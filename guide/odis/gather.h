/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_GATHER_H
#define FEWRAY_GUIDE_GATHER_H

/* The first look around a grid point, binned over the sphere: the network's input. */

#include <stdbool.h>

#include "guide/odis/look.h"
#include "guide/odis/sphere_grid.h"

/* Input planes (paper, section 4.1, "Input features", and the root of the second moment). Bins
 * without samples are 0. */
enum gather_plane {
    GATHER_RADIANCE,      /* range-compressed mean radiance / scale */
    GATHER_DEPTH,         /* mean first-hit depth / the grid point's */
    GATHER_NORMAL,        /* 3 planes: mean first-hit normal */
    GATHER_DISTANCE = 5,  /* log(1 + mean second-hit distance / the grid point's depth) */
    GATHER_SECOND_NORMAL, /* 3 planes: mean second-hit normal */
    GATHER_MOMENT = 9,    /* range-compressed root of the second moment / scale */
    GATHER_PLANES
};

struct gathered {
    bool
        valid; /* the grid point lies on a surface that light reaches as far as the look can tell */
    struct vec3 position, normal;
    float scale; /* mean radiance over the filled bins; radiance in all planes is relative to it */
    struct vec3 tint; /* colour of the gathered light, mean of RGB 1 */
    float planes[GATHER_PLANES][SPHERE_BINS];
    float mask[SPHERE_BINS];   /* 1 where the bin got samples and lies above the horizon, else 0 */
    float cosine[SPHERE_BINS]; /* of the bin's centre to the normal; 0 below the horizon */
    float fill[SPHERE_BINS];   /* log of the root of the second moment / scale, holes filled from
                                  coarser bins */
};

/* The paper's eq. 3 with mu = 5000, and its inverse. */
float range_compress(float radiance);
float range_expand(float compressed);

/* Bins the records of a window of 21 x 21 pixels (11 x 11 from 8 samples a pixel on, paper
 * section 4.3) around pixel (x, y). */
void gather(const struct fewray_look *look, int x, int y, struct gathered *out);

#endif
