/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_MAPS_H
#define FEWRAY_GUIDE_MAPS_H

/* Sampling maps: a density over the sphere at each grid point, and its interpolation at any surface
 * point. */

#include <stdbool.h>

#include "guide/guide.h"
#include "guide/odis/sphere_grid.h"
#include "guide/vec.h"

#define MAP_STRIDE 8 /* pixels between grid points (paper, section 5.3.2) */

struct map {
    bool valid;
    struct vec3 position, normal; /* of the grid point's surface, world space */
    struct vec3 irradiance;       /* integral of radiance * cos over the hemisphere / pi */
    float row_cdf[SPHERE_ROWS + 1];
    float density[SPHERE_BINS]; /* pdf (solid angle), constant within a bin; integrates to 1 over
                                   the sphere */
};

struct fewray_maps {
    int columns, rows; /* grid points; point (i, j) lies at pixel (8 i, 8 j), the last ones at the
                          picture's edge */
    int width, height; /* picture, pixels */
    struct map *maps;  /* (rows, columns) */
};

/* The maps around a surface point with their shares, which sum to 1. */
struct map_mixture {
    int count; /* 0: none fits */
    const struct map *maps[4];
    float share[4];
};

/* The pixel that grid point i of an axis stands on. */
static inline int map_pixel(int i, int size) {
    int p = i * MAP_STRIDE;
    return p < size ? p : size - 1;
}

/* Bilinear shares of the four maps around pixel (x, y), lowered where a map's surface has another
 * normal or lies off the point's tangent plane. */
struct map_mixture maps_at(const struct fewray_maps *maps, int x, int y, struct vec3 position,
                           struct vec3 normal);
/* Draws a unit direction from the mixture. */
struct vec3 map_mixture_sample(const struct map_mixture *mixture, const float u[2]);
/* Density (solid angle) of map_mixture_sample(). */
float map_mixture_pdf(const struct map_mixture *mixture, struct vec3 direction);

/* Irradiance / pi at pixel (x, y) for a surface of this mean normal; zero where no map fits. */
struct vec3 maps_irradiance(const struct fewray_maps *maps, int x, int y, struct vec3 normal);

/* Makes a density of non-negative values (pdf up to a factor, a value a bin); false where all are
 * zero or one isn't finite. */
bool map_set_density(struct map *map, const float values[SPHERE_BINS]);

#endif
