/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_MAPS_H
#define FEWRAY_GUIDE_MAPS_H

/* Sampling maps: a density over the sphere at each grid point, and its interpolation at any surface
 * point. */

#include <stdbool.h>

#include "fewray/guide.h"
#include "guide/odis/look.h"
#include "guide/odis/sphere_grid.h"
#include "guide/odis/voxel_table.h"
#include "guide/vec.h"

/* Least share of the samples that the BSDF draws unless a caller says otherwise: what a map
 * overlooks weighs ten times at most. The network would have less, which lowers the mean noise by a
 * few percent but doubles what the worst pixels add. */
#define MAP_LEAST_FRACTION 0.1f

struct block_range {
    int i0, j0, i1, j1; /* columns i0 <= i < i1, rows j0 <= j < j1 */
};

/* 4.3 KB; a picture without flat surfaces has one for each 64 pixels: 68 bytes a pixel, less than a
 * record of the look. */
struct map {
    struct vec3 position, normal; /* of the grid point's surface, world space */
    struct vec3 irradiance;       /* integral of radiance * cos over the hemisphere / pi */
    float confidence;             /* in the irradiance: I^2 / (I^2 + its expected variance), 0..1 */
    float bsdf_fraction;          /* of the samples here that should come from the BSDF, 0..1 */
    /* Second moments that samples of the look and of the map are expected to have, over that of
     * samples of the BSDF. */
    float look_moment, map_moment;
    struct block_range blocks; /* that it stands for */
    float row_cdf[SPHERE_ROWS + 1];
    float density[SPHERE_BINS]; /* pdf (solid angle), constant within a bin; integrates to 1 over
                                   the sphere */
};

/* Grid points stand at the centres of blocks of BLOCK_SIZE pixels (paper, section 5.3.2: every 8);
 * where surfaces are flat, four blocks share one map. */
struct fewray_maps {
    int columns, rows; /* blocks */
    int width, height; /* picture, pixels */
    int count;
    int merge;        /* bins a side that share one density; 0, 1: each has its own */
    struct map *maps; /* (count) */
    int32_t *index;   /* (rows, columns): each block's map, -1 = none */
    float
        *look_noise; /* (rows, columns): of the maps around, but those that saw the block's look */
    struct probes *probes;     /* NULL: none */
    struct voxel_table places; /* voxels that hold a map's surface; empty without probes */
    int32_t *place_maps;       /* (places.count): the map nearest to a voxel's middle */
    bool fixed_fraction; /* the BSDF fractions are the caller's: they don't fall by learning */
    struct map_sums
        *sums; /* (count) what maps_learn() adds up; NULL: the budget is too small for it */
};

/* The maps around a surface point with their shares, which sum to 1. */
struct map_mixture {
    int count; /* 0: none fits */
    const struct map *maps[4];
    float share[4];
    float bsdf_fraction; /* of the maps, by share; those left out for theirs count as 1 */
};

/* Bilinear shares of the four maps around pixel (x, y), lowered where a map's surface has another
 * normal or lies off the point's tangent plane; equal maps are one. Maps that would get less than a
 * twentieth of the samples are left out. normal: unit. */
struct map_mixture maps_at(const struct fewray_maps *maps, int x, int y, struct vec3 position,
                           struct vec3 normal);
/* Draws a unit direction from the mixture. */
struct vec3 map_mixture_sample(const struct map_mixture *mixture, const float u[2]);
/* Density (solid angle) of map_mixture_sample(). */
float map_mixture_pdf(const struct map_mixture *mixture, struct vec3 direction);

/* Irradiance / pi at pixel (x, y) for a surface of this mean normal; zero where no map fits. */
struct vec3 maps_irradiance(const struct fewray_maps *maps, int x, int y, struct vec3 normal,
                            float *confidence);

/* Sorts the maps into voxels of the world (maps->probes must be there); false without memory. */
bool maps_find_places(struct fewray_maps *maps);
/* The map of a surface near the point that the camera sees, NULL where there is none: for vertices
 * after the first. normal: unit, towards the path. */
const struct map *maps_near(const struct fewray_maps *maps, struct vec3 position,
                            struct vec3 normal);

/* How much noisier (second moments' ratio) a sample of pixel (x, y)'s look is than a guided one, as
 * far as maps that didn't see that look can tell. */
float maps_look_noise(const struct fewray_maps *maps, int x, int y);

/* Makes a density of values (pdf up to a factor, a value a bin); false where density_build() can't.
 */
bool map_set_density(struct map *map, const float values[SPHERE_BINS]);
/* Makes a map's density of what it is wanted to be in proportion to, before the cosine to its
 * normal (cosine: sphere_cosines()). wanted is overwritten. Without a share for the BSDF the
 * density also covers bins that the horizon cuts, and thinly all others, which other points around
 * see. */
bool maps_set(const struct fewray_maps *maps, struct map *map, const float cosine[SPHERE_BINS],
              float wanted[SPHERE_BINS]);

/* Maps learn where the budget exceeds this many samples a pixel, at 4, 16, 64, ... of them. */
#define MAPS_LEARN_SPP 4

/* NULL without memory; owned by the caller (free()). */
struct map_sums *map_sums_create(int maps);
size_t map_sums_bytes(void); /* of one map's */
/* wanted: as odis_network_run() gives it for map m; unit: radiance that is 1 there. */
void map_sums_start(struct fewray_maps *maps, int m, const float wanted[SPHERE_BINS], float unit);
/* Adds a sample of pixel (x, y) to its map's sums. Not for two threads at once in the same 16 x 16
 * pixels, which may share a map. */
void maps_learn(struct fewray_maps *maps, int x, int y, const struct look_record *record);
/* Gives each process of a team (may be NULL) all maps. A map's blocks lie in one tile, whose
 * process makes it and has its sums. */
int maps_exchange(struct fewray_maps *maps, const struct fewray_team *team,
                  struct fewray_error *error);
/* Makes new densities of all sums so far, with the network's as prior. */
void maps_refine(struct fewray_maps *maps, int threads);

#endif
