/* SPDX-License-Identifier: Apache-2.0 */
/* Tiles over OpenMP threads. Every pixel's result depends on its own coordinates only, never on the
 * schedule. */

#include "guide/trace/tiles.h"

#include "guide/trace/state.h"
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

/* The tiles of one run, handed out in order. */
struct tile_queue {
    int width, height, columns, tiles;
    int next, done;
    bool cancelled;
    const struct fewray_render_settings *settings;
    const char *phase;
    tile_function work;
    void *user;
    struct team_deal deal;
    int rank;
    struct fewray_render_stats mine; /* of this process */
};

static void run_tile(struct tile_queue *queue, int t) {
    const struct fewray_render_settings *settings = queue->settings;
    int x0 = t % queue->columns * TILE_SIZE, y0 = t / queue->columns * TILE_SIZE;
    struct fewray_render_stats part = {0};
    queue->work(queue->user, x0, y0, min_int(x0 + TILE_SIZE, queue->width),
                min_int(y0 + TILE_SIZE, queue->height), &part);
#pragma omp critical(fewray_tiles)
    {
        stats_add(&queue->mine, &part);
        queue->done++;
        if (settings->progress)
            settings->progress(settings->progress_user, queue->phase,
                               fmin(1, (double)queue->done * queue->deal.size / queue->tiles));
    }
}

/* One thread's tiles until none is left or a pause is due; at least one, so that a pause without
 * end can't stop the work. */
static void run_tiles(struct tile_queue *queue) {
    const struct fewray_render_settings *settings = queue->settings;
    for (bool due = false; !due;) {
        int t;
#pragma omp atomic capture
        t = queue->next++;
        if (t >= queue->tiles)
            return;
        if (team_owner(queue->deal, t % queue->columns, t / queue->columns) != queue->rank)
            continue;
        bool cancelled = is_cancelled(settings);
        if (!cancelled)
            run_tile(queue, t);
        if (cancelled || is_cancelled(settings)) {
#pragma omp atomic write
            queue->cancelled = true;
            return;
        }
        due = settings->pause_due && settings->pause_due(settings->pause_user);
    }
}

/* A state that was read has done the first tiles already. */
static void begin_queue(struct tile_queue *queue) {
    struct fewray_state *state = queue->settings->state;
    if (!state)
        return;
    if (state->resumes) {
        queue->next = queue->done = state->next;
        queue->mine = state->counts;
    }
    state->resumes = false;
    state->tiles = queue->tiles;
}

/* Whole passes are no place within one; their counts are the caller's. */
static void end_queue(const struct tile_queue *queue) {
    struct fewray_state *state = queue->settings->state;
    if (!state || queue->cancelled)
        return;
    state->next = queue->tiles;
    state->counts = (struct fewray_render_stats){0};
}

/* No thread traces. */
static void pause(const struct tile_queue *queue) {
    struct fewray_state *state = queue->settings->state;
    if (state) {
        state->next = min_int(queue->next, queue->tiles);
        state->counts = queue->mine;
    }
    queue->settings->paused(queue->settings->pause_user, queue->next >= queue->tiles);
}

int tiles_run(int width, int height, const struct fewray_render_settings *settings,
              const char *phase, tile_function work, void *user, struct fewray_render_stats *stats,
              struct fewray_error *error) {
    int columns = (width + TILE_SIZE - 1) / TILE_SIZE, rows = (height + TILE_SIZE - 1) / TILE_SIZE;
    const struct fewray_team *team = settings->team;
    struct tile_queue queue = {.width = width,
                               .height = height,
                               .columns = columns,
                               .tiles = columns * rows,
                               .settings = settings,
                               .phase = phase,
                               .work = work,
                               .user = user,
                               .deal = team_deal(team),
                               .rank = team ? team->rank : 0};
    begin_queue(&queue);
    while (queue.next < queue.tiles && !queue.cancelled) {
#pragma omp parallel num_threads(film_threads(settings))
        run_tiles(&queue);
        if (settings->pause_due && !queue.cancelled)
            pause(&queue);
    }
    end_queue(&queue);
    int status = FEWRAY_OK;
    if (queue.cancelled)
        status = fewray_fail(error, FEWRAY_ERROR_CANCELLED, NULL, 0, "interrupted");
    status = fewray_team_agree(team, status, error);
    if (status && status != FEWRAY_ERROR_CANCELLED)
        return status;
    const int counted = team_add_stats(team, &queue.mine, stats, error);
    return counted ? counted : status;
}
