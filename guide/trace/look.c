/* SPDX-License-Identifier: Apache-2.0 */
/* The first look: paths whose first bounce is spread evenly over the hemisphere and remembered. */

#include <stdlib.h>

#include "guide/trace/tiles.h"

#define STREAM_LOOK 0x6c6f6f6bu /* keeps the look's random numbers apart from the rest's */

struct look_job {
    const struct fewray_render_settings *settings;
    struct integrator integrator;
    struct fewray_film *film;
    struct fewray_look *look;
    uint32_t seed;
};

/* Interleaves the bits of two numbers below 16. */
static uint32_t morton16(uint32_t x, uint32_t y) {
    x = (x | (x << 2)) & 0x33u;
    x = (x | (x << 1)) & 0x55u;
    y = (y | (y << 2)) & 0x33u;
    y = (y | (y << 1)) & 0x55u;
    return x | (y << 1);
}

/* One (0,2)-sequence for the 256 pixels of a tile in Morton order: any small window of pixels has
 * its directions spread evenly, so that few bins of the window's grid stay empty. */
static void look_direction(uint32_t seed, int x, int y, int sample, float u[2]) {
    uint32_t tile = hash_combine(hash_combine(seed, (uint32_t)x / 16), (uint32_t)y / 16);
    sobol_point(morton16((uint32_t)x & 15, (uint32_t)y & 15) + 256 * (uint32_t)sample, tile, u);
}

static void look_tile(void *user, int x0, int y0, int x1, int y1,
                      struct fewray_render_stats *stats) {
    struct look_job *job = user;
    int n = job->look->samples;
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1 && !is_cancelled(job->settings); x++) {
            size_t pixel = (size_t)y * (size_t)job->film->width + (size_t)x;
            struct pixel_sums sums = {0};
            for (int s = 0; s < n; s++) {
                struct sampler sampler = sampler_start(
                    hash_combine(hash_combine(job->seed, (uint32_t)x), (uint32_t)y), (uint32_t)s);
                float u[2];
                look_direction(job->seed, x, y, s, u);
                struct path_sample p =
                    trace_look_path(&job->integrator, x, y, &sampler, u,
                                    &job->look->records[pixel * (size_t)n + (size_t)s]);
                pixel_sums_add(&sums, &p);
                stats->rays += p.rays;
            }
            stats->paths += n;
            stats->dropped += sums.dropped;
            film_store(job->film, x, y, GROUP_LOOK, &sums);
        }
}

int fewray_trace_look(const struct fewray_world *world,
                      const struct fewray_render_settings *settings, struct fewray_film *film,
                      struct fewray_look **out, struct fewray_render_stats *stats,
                      struct fewray_error *error) {
    *out = NULL;
    struct fewray_look *look = calloc(1, sizeof(*look));
    if (look) {
        *look = (struct fewray_look){film->width, film->height, settings->initial, NULL};
        look->records =
            calloc((size_t)film->width * (size_t)film->height * (size_t)settings->initial,
                   sizeof(*look->records));
    }
    if (!look || !look->records) {
        fewray_look_destroy(&look);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                           "no memory for the first look's records");
    }
    struct look_job job = {
        settings, film_integrator(world, film, NULL, settings), film, look,
        hash_combine((uint32_t)settings->seed ^ STREAM_LOOK, (uint32_t)(settings->seed >> 32))};
    int status =
        tiles_run(film->width, film->height, settings, "first look", look_tile, &job, stats, error);
    *out = look;
    return status;
}

void fewray_look_destroy(struct fewray_look **look) {
    if (!*look)
        return;
    free((*look)->records);
    free(*look);
    *look = NULL;
}
