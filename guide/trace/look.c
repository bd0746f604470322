/* SPDX-License-Identifier: Apache-2.0 */
/* The first look: paths whose first bounce is spread evenly over the hemisphere and remembered. */

#include <stdlib.h>

#include "features/pages.h"
#include "guide/trace/state.h"
#include "guide/trace/team.h"
#include "guide/trace/tile_paths.h"
#include "guide/trace/tiles.h"

#define STREAM_LOOK 0x6c6f6f6bu /* keeps the look's random numbers apart from the rest's */

struct look_job {
    const struct fewray_render_settings *settings;
    struct integrator integrator;
    struct fewray_film *film;
    struct fewray_look *look;
    const struct bundle_tracer *bundles;
    uint32_t seed;
};

uint32_t look_seed(uint64_t seed) {
    return hash_combine((uint32_t)seed ^ STREAM_LOOK, (uint32_t)(seed >> 32));
}

/* Interleaves the bits of two numbers below 16. */
static uint32_t morton16(uint32_t x, uint32_t y) {
    x = (x | (x << 2)) & 0x33u;
    x = (x | (x << 1)) & 0x55u;
    y = (y | (y << 2)) & 0x33u;
    y = (y | (y << 1)) & 0x55u;
    return x | (y << 1);
}

void look_square(uint32_t seed, int x, int y, int sample, float u[2]) {
    uint32_t tile = hash_combine(hash_combine(seed, (uint32_t)x / 16), (uint32_t)y / 16);
    sobol_point(morton16((uint32_t)x & 15, (uint32_t)y & 15) + 256 * (uint32_t)sample, tile, u);
}

static void look_tile(void *user, int x0, int y0, int x1, int y1,
                      struct fewray_render_stats *stats) {
    struct look_job *job = user;
    int n = job->look->samples;
    struct tile_paths paths = {.integrator = &job->integrator,
                               .film = job->film,
                               .stats = stats,
                               .trace = job->bundles->looks,
                               .group = GROUP_LOOK};
    for (uint32_t k = 0; k < TILE_SIZE * TILE_SIZE; k++) {
        int x = x0 + (int)tile_morton_x(k), y = y0 + (int)tile_morton_x(k >> 1);
        if (x >= x1 || y >= y1 || is_cancelled(job->settings))
            continue;
        size_t pixel = (size_t)y * (size_t)job->film->width + (size_t)x;
        for (int s = 0; s < n; s++) {
            size_t i = pixel * (size_t)n + (size_t)s;
            struct bundle_start start = {
                x, y,
                sampler_start(pixel_seed(job->settings, x, y), sample_index(job->settings, s)),
                .record = &job->look->records[i],
                .second = job->look->seconds ? &job->look->seconds[i] : NULL};
            look_square(job->seed, x, y, job->settings->part * n + s, start.direction);
            tile_paths_add(&paths, &start);
        }
    }
    tile_paths_end(&paths);
}

int look_create(int width, int height, int samples, bool seconds, struct fewray_look **out,
                struct fewray_error *error) {
    struct fewray_look *look = calloc(1, sizeof(*look));
    if (look) {
        size_t n = (size_t)width * (size_t)height * (size_t)samples;
        *look = (struct fewray_look){width, height, samples, NULL, NULL};
        look->records = pages_create(n * sizeof(*look->records));
        if (seconds)
            look->seconds = pages_create(n * sizeof(*look->seconds));
        if (!look->records || (seconds && !look->seconds))
            fewray_look_destroy(&look);
    }
    *out = look;
    return look ? FEWRAY_OK
                : fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                              "no memory for the records of the guide");
}

int look_exchange(struct fewray_look *look, const struct fewray_team *team,
                  struct fewray_error *error) {
    size_t n = (size_t)look->samples;
    int status = team_share_pixels(team, look->records, n * sizeof(*look->records), look->width,
                                   look->height, error);
    if (!status && look->seconds)
        status = team_share_pixels(team, look->seconds, n * sizeof(*look->seconds), look->width,
                                   look->height, error);
    return status;
}

/* A look that nobody has begun, or the one that was read with the state. */
static int begin_look(const struct fewray_render_settings *settings, const struct fewray_film *film,
                      struct fewray_look **look, struct fewray_error *error) {
    struct fewray_state *state = settings->state;
    int status = FEWRAY_OK;
    if (state_resumes(state, STATE_LOOK)) {
        *look = state->read_look;
        state->read_look = NULL;
    } else {
        status = look_create(film->width, film->height, settings->initial, settings->probes, look,
                             error);
    }
    if (state) {
        state->look = *look;
        state->look_samples = settings->initial;
        state_enter(state, STATE_LOOK, 0, 0);
    }
    return status;
}

int fewray_trace_look(const struct fewray_world *world,
                      const struct fewray_render_settings *settings, struct fewray_film *film,
                      struct fewray_look **out, struct fewray_render_stats *stats,
                      struct fewray_error *error) {
    struct fewray_look *look;
    int status = begin_look(settings, film, &look, error);
    status = fewray_team_agree(settings->team, status, error);
    if (!status) {
        struct look_job job = {settings,
                               film_integrator(world, film, settings),
                               film,
                               look,
                               bundle_tracer_get(),
                               look_seed(settings->seed)};
        status = tiles_run(film->width, film->height, settings, "first look", look_tile, &job,
                           stats, error);
    }
    if (!status)
        status = look_exchange(look, settings->team, error);
    *out = look;
    return status;
}

void fewray_look_destroy(struct fewray_look **look) {
    if (!*look)
        return;
    const size_t n = (size_t)(*look)->width * (size_t)(*look)->height * (size_t)(*look)->samples;
    pages_destroy((*look)->records, n * sizeof(*(*look)->records));
    pages_destroy((*look)->seconds, n * sizeof(*(*look)->seconds));
    free(*look);
    *look = NULL;
}
