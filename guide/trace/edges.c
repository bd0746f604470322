/* SPDX-License-Identifier: Apache-2.0 */
/* What the camera sees at edges, from more camera rays than paths: the outline of a bright window
 * or of a thin frame is noise that neither a guide nor a denoiser can remove, and a camera ray
 * costs a fraction of a path. */

#include "guide/basis.h"
#include "guide/trace/bundle.h"
#include "guide/trace/team.h"
#include "guide/trace/tiles.h"

#define EMISSION_CONTRAST 0.25f /* of the brightest neighbour: less isn't worth the rays */
#define ALBEDO_CONTRAST   0.1f
#define NORMAL_CONTRAST   0.3f  /* along an axis */
#define DEPTH_CONTRAST    0.05f /* of the farthest neighbour */
#define STREAM_EDGE       0x65646765u

enum { EMISSION, ALBEDO = 3, NORMAL = 6, DEPTH = 9, FEATURES = 10 };
#define BORDERED (TILE_SIZE + 2)

struct edge_job {
    const struct fewray_render_settings *settings;
    struct integrator integrator;
    struct fewray_film *film;
    const struct bundle_tracer *bundles;
    uint32_t seed;
};

/* The features of a tile and of the pixels around it, means over the samples; NaN beyond the
 * picture, which comparisons pass over: a pixel of the border must not stand in for its
 * own neighbour. */
struct edge_tile {
    float features[BORDERED][BORDERED][FEATURES];
};

static void features_at(const struct fewray_film *film, int x, int y, float f[FEATURES]) {
    const size_t pixel = (size_t)y * (size_t)film->width + (size_t)x;
    const int n = film->group[GROUP_LOOK][pixel].count + film->group[GROUP_REST][pixel].count;
    for (int i = 0; i < FEATURES; i++)
        f[i] = 0;
    for (int k = 0; k < GROUP_COUNT && n > 0; k++) {
        const struct pixel_group *g = &film->group[k][pixel];
        const float share = (float)g->count / (float)n;
        for (int c = 0; c < 3; c++) {
            f[EMISSION + c] += share * g->emission[c];
            f[ALBEDO + c] += share * g->albedo[c];
            f[NORMAL + c] += share * g->normal[c];
        }
        f[DEPTH] += share * g->depth;
    }
}

static void read_tile(const struct fewray_film *film, int x0, int y0, struct edge_tile *tile) {
    for (int j = 0; j < BORDERED; j++)
        for (int i = 0; i < BORDERED; i++) {
            int x = x0 + i - 1, y = y0 + j - 1;
            float *f = tile->features[j][i];
            if (x >= 0 && y >= 0 && x < film->width && y < film->height)
                features_at(film, x, y, f);
            else
                for (int k = 0; k < FEATURES; k++)
                    f[k] = NAN;
        }
}

/* Camera rays that a pixel needs: all at edges of what shines, where errors are largest, a
 * quarter at others. Judged by the eight neighbours alone: a choice that looked at the pixel's own
 * samples would bias it. (x, y) within the tile, border included. */
static int rays_at(const struct edge_tile *tile, int x, int y, int camera_rays) {
    float low[FEATURES], high[FEATURES];
    for (int i = 0; i < FEATURES; i++) {
        low[i] = INFINITY;
        high[i] = -INFINITY;
    }
    for (int k = 0; k < 9; k++) {
        const float *f = tile->features[y + k / 3 - 1][x + k % 3 - 1];
        for (int i = 0; i < FEATURES && k != 4; i++) { /* no NaN is less or more */
            low[i] = f[i] < low[i] ? f[i] : low[i];
            high[i] = f[i] > high[i] ? f[i] : high[i];
        }
    }
    bool bright = false, edge = high[DEPTH] - low[DEPTH] > DEPTH_CONTRAST * high[DEPTH];
    for (int c = 0; c < 3; c++) {
        bright |= high[EMISSION + c] - low[EMISSION + c] > EMISSION_CONTRAST * high[EMISSION + c];
        edge |= high[ALBEDO + c] - low[ALBEDO + c] > ALBEDO_CONTRAST ||
                high[NORMAL + c] - low[NORMAL + c] > NORMAL_CONTRAST;
    }
    return bright ? camera_rays : edge ? (camera_rays + 3) / 4 : 0;
}

/* A pixel whose sums are open, and the camera rays on their way to them. */
struct edge_rays {
    struct edge_job *job;
    int count;
    struct bundle_start starts[BUNDLE_LANES];
    float x[BUNDLE_LANES], y[BUNDLE_LANES];
    int pixel_x, pixel_y, used;
    double sum[FEATURES];
};

/* Means over the camera rays of a pixel. */
static void finish_pixel(struct edge_rays *r) {
    const struct fewray_film *film = r->job->film;
    struct pixel_edge *edge =
        &film->edges[(size_t)r->pixel_y * (size_t)film->width + (size_t)r->pixel_x];
    const int used = r->used;
    const double *sum = r->sum;
    edge->rays = used;
    for (int c = 0; c < 3 && used; c++) {
        edge->emission[c] = (float)(sum[EMISSION + c] / used);
        edge->albedo[c] = (float)(sum[ALBEDO + c] / used);
        edge->normal[c] = (float)(sum[NORMAL + c] / used);
    }
    edge->depth = used ? (float)(sum[DEPTH] / used) : 0;
    r->used = 0;
    for (int i = 0; i < FEATURES; i++)
        r->sum[i] = 0;
}

static void add_features(struct edge_rays *r, const struct path_sample *p) {
    const float f[FEATURES] = {p->emission.x, p->emission.y, p->emission.z, p->albedo.x,
                               p->albedo.y,   p->albedo.z,   p->normal.x,   p->normal.y,
                               p->normal.z,   p->depth};
    bool finite = true;
    for (int i = 0; i < FEATURES; i++)
        finite &= isfinite(f[i]);
    for (int i = 0; i < FEATURES && finite; i++)
        r->sum[i] += f[i];
    r->used += finite;
}

static void trace_edge_rays(struct edge_rays *r) {
    struct path_sample samples[BUNDLE_LANES];
    if (r->count)
        r->job->bundles->features(&r->job->integrator, r->count, r->x, r->y, r->starts, samples);
    for (int i = 0; i < r->count; i++) {
        if (r->starts[i].x != r->pixel_x || r->starts[i].y != r->pixel_y)
            finish_pixel(r);
        r->pixel_x = r->starts[i].x;
        r->pixel_y = r->starts[i].y;
        add_features(r, &samples[i]);
    }
    r->count = 0;
}

static void add_edge_ray(struct edge_rays *r, int x, int y, uint32_t sample) {
    float u[2];
    uint32_t seed = hash_combine(hash_combine(r->job->seed, (uint32_t)x), (uint32_t)y);
    sobol_point(sample, seed, u);
    r->starts[r->count] =
        (struct bundle_start){x, y, sampler_start(hash_u32(seed), sample), .second = NULL};
    r->x[r->count] = (float)x + u[0];
    r->y[r->count] = (float)y + u[1];
    if (++r->count == BUNDLE_LANES)
        trace_edge_rays(r);
}

static void edge_tile(void *user, int x0, int y0, int x1, int y1,
                      struct fewray_render_stats *stats) {
    struct edge_job *job = user;
    struct edge_tile tile;
    struct edge_rays rays = {.job = job, .pixel_x = x0, .pixel_y = y0};
    bool any = false;
    const uint32_t first = (uint32_t)job->settings->part * (uint32_t)job->settings->camera_rays;
    read_tile(job->film, x0, y0, &tile);
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++) {
            int n = rays_at(&tile, x - x0 + 1, y - y0 + 1, job->settings->camera_rays);
            if (is_cancelled(job->settings) || n <= job->settings->spp)
                continue;
            if (!any) { /* the first pixel whose sums are open */
                rays.pixel_x = x;
                rays.pixel_y = y;
                any = true;
            }
            for (int s = 0; s < n; s++)
                add_edge_ray(&rays, x, y, first + (uint32_t)s);
            stats->rays += n;
            stats->edge_pixels++;
        }
    trace_edge_rays(&rays);
    if (any)
        finish_pixel(&rays);
}

int fewray_trace_edges(const struct fewray_world *world,
                       const struct fewray_render_settings *settings, struct fewray_film *film,
                       struct fewray_render_stats *stats, struct fewray_error *error) {
    if (settings->spp >= settings->camera_rays) /* the samples themselves know the edges better */
        return FEWRAY_OK;
    struct edge_job job = {
        settings, film_integrator(world, film, settings), film, bundle_tracer_get(),
        hash_combine((uint32_t)settings->seed ^ STREAM_EDGE, (uint32_t)(settings->seed >> 32))};
    int status =
        tiles_run(film->width, film->height, settings, "edges", edge_tile, &job, stats, error);
    return status ? status
                  : team_share_pixels(settings->team, film->edges, sizeof(*film->edges),
                                      film->width, film->height, error);
}
