/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_TILE_PATHS_H
#define FEWRAY_GUIDE_TILE_PATHS_H

/* The paths of a tile on their way through bundles to the film. */

#include "guide/trace/bundle.h"
#include "guide/trace/film.h"

struct tile_paths {
    const struct integrator *integrator;
    struct fewray_film *film;
    struct fewray_render_stats *stats;
    void (*trace)(const struct integrator *in, int count, const struct bundle_start *starts,
                  struct path_sample *samples); /* of a bundle tracer */
    int group;                                  /* of the film */
    int count;                                  /* paths that wait for a whole bundle */
    struct bundle_start starts[BUNDLE_LANES];
    struct fewray_maps *learning;             /* maps that the paths teach; NULL: none */
    struct look_record records[BUNDLE_LANES]; /* for paths that teach but bring no record */
    bool guided;                              /* the pixel's sums have a guided sample */
    struct pixel_sums sums;
    int x, y; /* the pixel that they are of */
};

/* The next path of the tile; all of a pixel's in a row. It is traced when the bundle is full. */
void tile_paths_add(struct tile_paths *paths, const struct bundle_start *start);
/* Traces what still waits. */
void tile_paths_end(struct tile_paths *paths);

#endif
