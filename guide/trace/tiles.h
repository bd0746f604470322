/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_TILES_H
#define FEWRAY_GUIDE_TILES_H

/* The picture in tiles over threads, with progress, pauses and cancelling. */

#include "features/cancel.h"
#include "guide/trace/film.h"

#define TILE_SIZE FEWRAY_TILE_SIZE

static inline int min_int(int a, int b) {
    return a < b ? a : b;
}

static inline bool is_cancelled(const struct fewray_render_settings *settings) {
    return cancel_wanted(settings->cancel);
}

/* Seed of a pixel's samples. */
static inline uint32_t pixel_seed(const struct fewray_render_settings *settings, int x, int y) {
    uint32_t seed = hash_combine((uint32_t)settings->seed, (uint32_t)(settings->seed >> 32));
    return hash_combine(hash_combine(seed, (uint32_t)x), (uint32_t)y);
}

/* Every second bit of a number below 256: of pixel k of a tile in Morton order, its x; of k >> 1,
 * its y. */
static inline uint32_t tile_morton_x(uint32_t k) {
    k &= 0x55u;
    k = (k | (k >> 1)) & 0x33u;
    return (k | (k >> 2)) & 0x0fu;
}

/* Index in the pixel's sequence of its sample s, the look's being the first. */
static inline uint32_t sample_index(const struct fewray_render_settings *settings, int s) {
    return (uint32_t)settings->part * (uint32_t)settings->spp + (uint32_t)s;
}

/* What one tile of pixels x0 <= x < x1, y0 <= y < y1 does; counts go to *stats, which no other tile
 * touches. */
typedef void (*tile_function)(void *user, int x0, int y0, int x1, int y1,
                              struct fewray_render_stats *stats);

void stats_add(struct fewray_render_stats *sum, const struct fewray_render_stats *part);

/* Calls `work` for each tile, and settings->paused between tiles where that is due; adds the counts
 * to *stats. FEWRAY_ERROR_CANCELLED where settings->cancel stopped it. In a team each process does
 * its own tiles, and all get the counts and the status of all. */
int tiles_run(int width, int height, const struct fewray_render_settings *settings,
              const char *phase, tile_function work, void *user, struct fewray_render_stats *stats,
              struct fewray_error *error);

#endif
