/* SPDX-License-Identifier: Apache-2.0 */
/* Directly seen emission at its edges, from more camera rays than paths: a bright window's outline
 * is noise that neither a guide nor a denoiser can remove, and a camera ray costs a fraction of a
 * path. */

#include "guide/trace/basis.h"
#include "guide/trace/tiles.h"

#define EDGE_RAYS     32    /* a pixel */
#define EDGE_CONTRAST 0.25f /* of the brightest neighbour: a smaller step isn't worth the rays */
#define STREAM_EDGE   0x65646765u

struct edge_job {
    const struct fewray_render_settings *settings;
    struct integrator integrator;
    struct fewray_film *film;
    uint32_t seed;
};

static float emission_at(const struct fewray_film *film, int x, int y) {
    const struct pixel_group *g =
        &film->groups[((size_t)y * (size_t)film->width + (size_t)x) * GROUP_COUNT];
    int n = g[GROUP_LOOK].count + g[GROUP_REST].count;
    float sum = 0;
    for (int k = 0; k < GROUP_COUNT && n > 0; k++)
        sum +=
            (float)g[k].count / (float)n * (g[k].emission[0] + g[k].emission[1] + g[k].emission[2]);
    return sum;
}

/* Judged by the eight neighbours alone: a choice that looked at the pixel's own samples would bias
 * it. */
static bool is_edge(const struct fewray_film *film, int x, int y) {
    float low = INFINITY, high = 0;
    for (int j = y - 1; j <= y + 1; j++)
        for (int i = x - 1; i <= x + 1; i++) {
            if ((i == x && j == y) || i < 0 || j < 0 || i >= film->width || j >= film->height)
                continue;
            float e = emission_at(film, i, j);
            low = fminf(low, e);
            high = fmaxf(high, e);
        }
    return high - low > EDGE_CONTRAST * high;
}

static void edge_tile(void *user, int x0, int y0, int x1, int y1,
                      struct fewray_render_stats *stats) {
    struct edge_job *job = user;
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++) {
            if (is_cancelled(job->settings) || !is_edge(job->film, x, y))
                continue;
            uint32_t seed = hash_combine(hash_combine(job->seed, (uint32_t)x), (uint32_t)y);
            double sum[3] = {0};
            for (int s = 0; s < EDGE_RAYS; s++) {
                float u[2];
                sobol_point((uint32_t)s, seed, u);
                struct vec3 e = trace_emission(&job->integrator, (float)x + u[0], (float)y + u[1]);
                sum[0] += e.x;
                sum[1] += e.y;
                sum[2] += e.z;
            }
            struct pixel_edge *edge =
                &job->film->edges[(size_t)y * (size_t)job->film->width + (size_t)x];
            edge->refined = true;
            for (int c = 0; c < 3; c++)
                edge->emission[c] = (float)(sum[c] / EDGE_RAYS);
            stats->rays += EDGE_RAYS;
            stats->edge_pixels++;
        }
}

int fewray_trace_edges(const struct fewray_world *world,
                       const struct fewray_render_settings *settings, struct fewray_film *film,
                       struct fewray_render_stats *stats, struct fewray_error *error) {
    if (settings->spp >= EDGE_RAYS) /* the samples themselves know the edges better */
        return FEWRAY_OK;
    struct edge_job job = {
        settings, film_integrator(world, film, settings), film,
        hash_combine((uint32_t)settings->seed ^ STREAM_EDGE, (uint32_t)(settings->seed >> 32))};
    return tiles_run(film->width, film->height, settings, "edges", edge_tile, &job, stats, error);
}
