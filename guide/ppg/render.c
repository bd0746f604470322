/* SPDX-License-Identifier: Apache-2.0 */
/* Path-guided rendering: passes of doubling length (Mueller, Gross, Novak 2017), their
 * pictures combined by inverse variance (Mueller 2019, "Practical Path Guiding in Production"). */

#include <stdlib.h>

#include "guide/ppg/ppg.h"
#include "guide/trace/tiles.h"

#define STREAM_PPG 0x70706775u

#define BUFFER_BYTES 200e6 /* of records, about, before they are splatted */
#define PATH_RECORDS 8     /* a path's, for the first pass's buffers */
#define CHUNK_TILES  4096
#define VARIANCE_MAX 1e4 /* of a pixel, in a picture's: one firefly must not decide (2019) */
#define PASSES_KEPT  4   /* the last ones; earlier ones can only harm (2019) */

struct ppg_job {
    const struct fewray_render_settings *settings;
    struct integrator integrator;
    struct fewray_film *film;
    struct ppg *ppg;
    struct ppg_buffer buffers[CHUNK_TILES];

    int columns, tiles; /* of the picture */
    int first_tile;     /* of the chunk */
    int samples;        /* a pixel, of the pass */
    bool last;          /* pass: nothing more is learnt */
    uint32_t seed;      /* of the pass */
    int done;           /* samples a pixel of the passes before */
    bool no_memory;
    double path_records; /* mean of the passes so far */
    int first_kept;      /* pass whose picture counts */
    double weight;       /* sum over the passes so far that count */
};

/* --- a pass, in chunks of tiles whose records fit into memory */

/* The pass's picture waits in GROUP_LOOK, which path guiding has no other use for. */
static void ppg_pixel(struct ppg_job *job, int x, int y, struct ppg_buffer *buffer,
                      struct fewray_render_stats *stats) {
    uint32_t seed = hash_combine(hash_combine(job->seed, (uint32_t)x), (uint32_t)y);
    struct pixel_sums sums = {0};
    struct vertex_log log;
    const struct path_notes notes = {.log = job->last ? NULL : &log};
    bool guided = false;
    for (int s = 0; s < job->samples; s++) {
        struct sampler sampler = sampler_start(seed, (uint32_t)s);
        struct path_sample p = trace_path(&job->integrator, x, y, &sampler, &notes);
        pixel_sums_add(&sums, &p);
        stats->rays += p.rays;
        guided |= p.guided;
        if (!job->last && !ppg_buffer_add(buffer, &log)) {
#pragma omp atomic write
            job->no_memory = true;
        }
    }
    stats->paths += job->samples;
    stats->dropped += sums.dropped;
    stats->pixels_guided += job->last && guided;
    film_add(job->film, x, y, GROUP_LOOK, &sums);
}

/* A chunk's tiles lie in one row as far as tiles_run() knows. */
static void ppg_tile(void *user, int x0, int y0, int x1, int y1,
                     struct fewray_render_stats *stats) {
    (void)y0, (void)x1, (void)y1;
    struct ppg_job *job = user;
    int index = x0 / TILE_SIZE, tile = job->first_tile + index;
    int left = tile % job->columns * TILE_SIZE, top = tile / job->columns * TILE_SIZE;
    for (int y = top; y < top + TILE_SIZE && y < job->film->height; y++)
        for (int x = left; x < left + TILE_SIZE && x < job->film->width; x++)
            if (!is_cancelled(job->settings))
                ppg_pixel(job, x, y, &job->buffers[index], stats);
}

static int chunk_tiles(const struct ppg_job *job) {
    if (job->last)
        return CHUNK_TILES;
    double tile_bytes =
        PPG_RECORD_BYTES * job->path_records * job->samples * (TILE_SIZE * TILE_SIZE);
    return (int)fmin(fmax(BUFFER_BYTES / tile_bytes, 1), CHUNK_TILES);
}

/* Progress of a chunk as that of the whole picture. */
static void report_progress(void *user, const char *phase, double fraction) {
    const struct ppg_job *job = user;
    int chunk = chunk_tiles(job), left = job->tiles - job->first_tile;
    double tiles = job->first_tile + fraction * (left < chunk ? left : chunk);
    job->settings->progress(job->settings->progress_user, phase,
                            (job->done + job->samples * tiles / job->tiles) / job->settings->spp);
}

static int trace_pass(struct ppg_job *job, struct fewray_render_stats *stats,
                      struct fewray_error *error) {
    struct fewray_render_settings chunk_settings = *job->settings;
    if (chunk_settings.progress)
        chunk_settings.progress = report_progress;
    chunk_settings.progress_user = job;
    int threads = film_threads(job->settings), chunk = chunk_tiles(job);
    double records = 0;
    for (job->first_tile = 0; job->first_tile < job->tiles; job->first_tile += chunk) {
        int left = job->tiles - job->first_tile, n = left < chunk ? left : chunk;
        int status = tiles_run(n * TILE_SIZE, TILE_SIZE, &chunk_settings, "render", ppg_tile, job,
                               stats, error);
        if (status)
            return status;
        if (job->no_memory)
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                               "no memory for path guiding's records");
        for (int i = 0; i < n; i++)
            records += (double)job->buffers[i].count;
        status = ppg_splat(job->ppg, job->buffers, n, threads, error);
        if (status)
            return status;
    }
    if (job->last)
        return FEWRAY_OK;
    job->path_records =
        fmax(records / ((double)job->film->width * job->film->height * job->samples), 0.1);
    return ppg_end_pass(job->ppg, job->samples, threads, error);
}

/* --- the passes' pictures combined */

/* Variance of the pixel's mean, channels averaged; 0 for a single sample. */
static double pass_variance(const struct pixel_group *pass) {
    double n = pass->count;
    double deviation = (double)pass->deviation[0] + pass->deviation[1] + pass->deviation[2];
    return n > 1 ? deviation / (3 * n * (n - 1)) : 0;
}

struct pass_spread {
    double own;    /* variance of the pass's picture, mean over the pixels */
    double before; /* of the picture so far, by its squared distance from the pass's */
};

static struct pass_spread measure_spread(const struct fewray_film *film) {
    size_t pixels = (size_t)film->width * (size_t)film->height;
    struct pass_spread sum = {0, 0};
    for (size_t i = 0; i < pixels; i++) {
        const struct pixel_group *pass = &film->group[GROUP_LOOK][i];
        const struct pixel_group *so_far = &film->group[GROUP_REST][i];
        double distance = 0;
        for (int c = 0; c < 3; c++) {
            double d = (double)pass->radiance[c] - so_far->radiance[c];
            distance += d * d / 3;
        }
        sum.own += fmin(pass_variance(pass), VARIANCE_MAX);
        sum.before += fmin(distance, VARIANCE_MAX);
    }
    return (struct pass_spread){sum.own / (double)pixels, (sum.before - sum.own) / (double)pixels};
}

/* Moves a picture's pixel towards the pass's by `share`. The deviation holds the variance of the
 * mean until finish_film(). single: variance of a one-sample picture over the pass's, where the
 * picture so far is one. indirect: the pixel's part of struct fewray_film's. */
static void combine_pixel(struct pixel_group *sum, const struct pixel_group *pass,
                          float (*indirect)[3], float share, float single) {
    if (!pass->count)
        return;
    float a = sum->count ? share : 1, n = (float)pass->count;
    for (int c = 0; c < 3; c++) {
        float distance = pass->radiance[c] - sum->radiance[c];
        float variance = pass->count > 1 ? pass->deviation[c] / (n * (n - 1))
                         : sum->count    ? 0.5f * distance * distance
                                         : 0;
        float before = single > 0 ? single * variance : sum->deviation[c];
        sum->deviation[c] = (1 - a) * (1 - a) * before + a * a * variance;
        sum->radiance[c] += a * distance;
        sum->emission[c] += a * (pass->emission[c] - sum->emission[c]);
        sum->albedo[c] += a * (pass->albedo[c] - sum->albedo[c]);
        sum->normal[c] += a * (pass->normal[c] - sum->normal[c]);
    }
    for (int c = 0; indirect && c < 3; c++)
        indirect[GROUP_REST][c] += a * (indirect[GROUP_LOOK][c] - indirect[GROUP_REST][c]);
    sum->depth += a * (pass->depth - sum->depth);
    sum->alpha += a * (pass->alpha - sum->alpha);
    sum->count += pass->count;
}

static void clear_pass(struct fewray_film *film, size_t pixel) {
    film->group[GROUP_LOOK][pixel] = (struct pixel_group){.count = 0};
    for (int c = 0; film->indirect && c < 3; c++)
        film->indirect[pixel * GROUP_COUNT + GROUP_LOOK][c] = 0;
}

/* Takes the pass's picture from GROUP_LOOK into the mean in GROUP_REST. A first pass of one sample
 * has no variance of its own: it gets what its distance from the second leaves, but never more
 * weight a sample than that, as the second is guided. */
static void combine_pass(struct ppg_job *job, int pass) {
    struct fewray_film *film = job->film;
    struct pass_spread spread = measure_spread(film);
    double variance = fmax(spread.own, 1e-30), single = 0;
    if (pass == 1) {
        single = fmax(spread.before / variance, job->samples);
        if (job->samples == 1)
            single = 1;
        job->weight = job->first_kept == 0 ? 1 / (single * variance) : 0;
    }
    double weight = 1 / variance;
    double share = job->weight > 0 ? weight / (job->weight + weight) : 1;
    job->weight = pass > 0 && pass >= job->first_kept ? job->weight + weight : 0;
    size_t pixels = (size_t)film->width * (size_t)film->height;
    for (size_t i = 0; i < pixels; i++) {
        float(*indirect)[3] = film->indirect ? &film->indirect[i * GROUP_COUNT] : NULL;
        combine_pixel(&film->group[GROUP_REST][i], &film->group[GROUP_LOOK][i], indirect,
                      (float)share, (float)single);
        clear_pass(film, i);
    }
}

/* The film wants sums of squared deviations: those of as many samples that give the same variance
 * of the mean. A pass that was broken off may still lie in GROUP_LOOK. */
static void finish_film(struct fewray_film *film) {
    size_t pixels = (size_t)film->width * (size_t)film->height;
    for (size_t i = 0; i < pixels; i++) {
        struct pixel_group *g = &film->group[GROUP_REST][i];
        clear_pass(film, i);
        for (int c = 0; c < 3; c++)
            g->deviation[c] *= (float)g->count * (float)(g->count - 1);
    }
}

/* --- all passes */

/* Samples of a pass that starts with `left` to do: twice the pass before, or all where too few
 * would remain to double once more. */
static int pass_samples(int pass, int before, int left) {
    if (pass == 0)
        return 1;
    return left / 6 < before ? left : 2 * before;
}

static int pass_count(int spp) {
    int passes = 0;
    for (int before = 0; spp > 0; passes++) {
        before = pass_samples(passes, before, spp);
        spp -= before;
    }
    return passes;
}

static int run_passes(struct ppg_job *job, uint32_t seed, struct fewray_render_stats *stats,
                      struct fewray_error *error) {
    int passes = pass_count(job->settings->spp), status = FEWRAY_OK;
    job->first_kept = passes > PASSES_KEPT ? passes - PASSES_KEPT : 0;
    for (int pass = 0; pass < passes && !status; pass++) {
        job->samples = pass_samples(pass, job->samples, job->settings->spp - job->done);
        job->last = pass == passes - 1;
        /* Each pass has points of its own: the rest of a stratified sequence would depend on those
         * that the guide was learnt from. */
        job->seed = hash_combine(seed, (uint32_t)pass);
        status = trace_pass(job, stats, error);
        if (!status || pass == 0) /* a broken-off pass is no picture, but the first beats none */
            combine_pass(job, pass);
        job->done += job->samples;
    }
    return status;
}

int fewray_trace_ppg(const struct fewray_world *world,
                     const struct fewray_render_settings *settings, struct fewray_film *film,
                     struct fewray_render_stats *stats, struct fewray_error *error) {
    struct ppg_job *job = calloc(1, sizeof(*job));
    if (!job)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for path guiding");
    job->settings = settings;
    job->integrator = film_integrator(world, film, settings);
    job->film = film;
    job->columns = (film->width + TILE_SIZE - 1) / TILE_SIZE;
    job->tiles = job->columns * ((film->height + TILE_SIZE - 1) / TILE_SIZE);
    job->path_records = PATH_RECORDS;
    struct RTCBounds b;
    embree.rtcGetSceneBounds(world->embree, &b);
    int status =
        ppg_create(vec(b.lower_x, b.lower_y, b.lower_z), vec(b.upper_x, b.upper_y, b.upper_z),
                   (long long)film->width * film->height, &job->ppg, error);
    job->integrator.guides.ppg = job->ppg;
    if (!status)
        status = run_passes(
            job,
            hash_combine((uint32_t)settings->seed ^ STREAM_PPG, (uint32_t)(settings->seed >> 32)),
            stats, error);
    finish_film(film);
    for (int i = 0; i < CHUNK_TILES; i++)
        ppg_buffer_free(&job->buffers[i]);
    ppg_destroy(&job->ppg);
    free(job);
    return status;
}
