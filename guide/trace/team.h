/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_TEAM_H
#define FEWRAY_GUIDE_TEAM_H

/* Which process of a team (fewray/guide.h) has which tile, and how the others get its results. Tiles
 * are dealt out by their place alone, so that nobody needs to tell who did what; what stands on a
 * tile (pixels, sampling maps) belongs to the tile's process. */

#include "fewray/guide.h"

/* Tiles go round the processes along each row; `step` shifts the rows against each other. */
struct team_deal {
    int size; /* processes */
    int step;
};

struct team_deal team_deal(const struct fewray_team *team);

static inline int team_owner(struct team_deal deal, int tile_x, int tile_y) {
    return (tile_x + tile_y * deal.step) % deal.size;
}

/* The process that has an item. */
typedef int (*team_owner_function)(const void *user, struct team_deal deal, size_t item);

/* Gives each process all items, (count, item_bytes), of which it has made its own. A team of one or
 * none has nothing to do. */
int team_share(const struct fewray_team *team, void *items, size_t item_bytes, size_t count,
               team_owner_function owner, const void *user, struct fewray_error *error);

/* The same for a picture's pixels, (height, width, pixel_bytes). */
int team_share_pixels(const struct fewray_team *team, void *pixels, size_t pixel_bytes, int width,
                      int height, struct fewray_error *error);

/* Adds the counts of all processes to *sum. */
int team_add_stats(const struct fewray_team *team, const struct fewray_render_stats *mine,
                   struct fewray_render_stats *sum, struct fewray_error *error);

#endif
