/* SPDX-License-Identifier: Apache-2.0 */
/* The samples after the first look, guided where there are maps. */

#include "guide/trace/tiles.h"

#define STREAM_REST 0x72657374u

struct rest_job {
    const struct fewray_render_settings *settings;
    struct integrator integrator;
    struct fewray_film *film;
    int samples; /* a pixel */
    uint32_t seed;
};

static void rest_tile(void *user, int x0, int y0, int x1, int y1,
                      struct fewray_render_stats *stats) {
    struct rest_job *job = user;
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1 && !is_cancelled(job->settings); x++) {
            uint32_t seed = hash_combine(hash_combine(job->seed, (uint32_t)x), (uint32_t)y);
            struct pixel_sums sums = {0};
            bool guided = false;
            for (int s = 0; s < job->samples; s++) {
                struct sampler sampler = sampler_start(seed, (uint32_t)s);
                struct path_sample p = trace_path(&job->integrator, x, y, &sampler);
                pixel_sums_add(&sums, &p);
                stats->rays += p.rays;
                guided |= p.guided;
            }
            stats->paths += job->samples;
            stats->dropped += sums.dropped;
            stats->pixels_guided += guided;
            film_store(job->film, x, y, GROUP_REST, &sums);
        }
}

int fewray_trace_rest(const struct fewray_world *world, const struct fewray_maps *maps,
                      const struct fewray_render_settings *settings, struct fewray_film *film,
                      struct fewray_render_stats *stats, struct fewray_error *error) {
    int samples = settings->spp - (maps ? settings->initial : 0);
    if (samples <= 0)
        return FEWRAY_OK;
    struct rest_job job = {
        settings, film_integrator(world, film, maps, settings), film, samples,
        hash_combine((uint32_t)settings->seed ^ STREAM_REST, (uint32_t)(settings->seed >> 32))};
    return tiles_run(film->width, film->height, settings, "render", rest_tile, &job, stats, error);
}
