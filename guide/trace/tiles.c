/* SPDX-License-Identifier: Apache-2.0 */
/* Tiles over OpenMP threads. Every pixel's result depends on its own coordinates only, never on the
 * schedule. */

#include "guide/trace/tiles.h"

#include "guide/trace/team.h"

void stats_add(struct fewray_render_stats *sum, const struct fewray_render_stats *part) {
    sum->paths += part->paths;
    sum->rays += part->rays;
    sum->dropped += part->dropped;
    sum->grids += part->grids;
    sum->grids_inferred += part->grids_inferred;
    sum->grids_shared += part->grids_shared;
    sum->edge_pixels += part->edge_pixels;
    sum->pixels_guided += part->pixels_guided;
}

static int min_int(int a, int b) {
    return a < b ? a : b;
}

int tiles_run(int width, int height, const struct fewray_render_settings *settings,
              const char *phase, tile_function work, void *user, struct fewray_render_stats *stats,
              struct fewray_error *error) {
    int columns = (width + TILE_SIZE - 1) / TILE_SIZE, rows = (height + TILE_SIZE - 1) / TILE_SIZE;
    int tiles = columns * rows, done = 0;
    bool cancelled = false;
    struct fewray_render_stats mine = {0};
    const struct team_deal deal = team_deal(settings->team);
    const int rank = settings->team ? settings->team->rank : 0;
#pragma omp parallel for schedule(dynamic) num_threads(film_threads(settings))
    for (int t = 0; t < tiles; t++) {
        if (team_owner(deal, t % columns, t / columns) != rank)
            continue;
        if (is_cancelled(settings)) {
#pragma omp atomic write
            cancelled = true;
            continue;
        }
        int x0 = t % columns * TILE_SIZE, y0 = t / columns * TILE_SIZE;
        struct fewray_render_stats part = {0};
        work(user, x0, y0, min_int(x0 + TILE_SIZE, width), min_int(y0 + TILE_SIZE, height), &part);
        if (is_cancelled(settings)) {
#pragma omp atomic write
            cancelled = true;
        }
#pragma omp critical(fewray_tiles)
        {
            stats_add(&mine, &part);
            done++;
            if (settings->progress)
                settings->progress(settings->progress_user, phase,
                                   fmin(1, (double)done * deal.size / tiles));
        }
    }
    int status = FEWRAY_OK;
    if (cancelled)
        status = fewray_fail(error, FEWRAY_ERROR_CANCELLED, NULL, 0, "interrupted");
    status = fewray_team_agree(settings->team, status, error);
    if (status && status != FEWRAY_ERROR_CANCELLED)
        return status;
    const int counted = team_add_stats(settings->team, &mine, stats, error);
    return counted ? counted : status;
}
