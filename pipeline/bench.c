/* SPDX-License-Identifier: Apache-2.0 */
/* The measuring: every method at every number of samples with every seed, least samples first, so
 * that an interrupted bench leaves whole curves' beginnings. */

#include "pipeline/bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "features/cancel.h"
#include "pipeline/layer_names.h"
#include "pipeline/peers.h"
#include "pipeline/stats.h"

enum { THROUGHPUT_SPP = 4, THROUGHPUT_RUNS = 3 };

const char *const BENCH_METHOD_NAMES[BENCH_METHODS] = {
    "PT", "guided", "PT+denoised", "guided+denoised", "PT+OIDN", "Mitsuba PT", "Mitsuba PT+OIDN",
};

const char *const BENCH_METHOD_LEGENDS[BENCH_METHODS] = {
    [BENCH_PT] = "fewray: path tracing",
    [BENCH_GUIDED] = "fewray: guided",
    [BENCH_PT_DENOISED] = "fewray: path tracing, denoised",
    [BENCH_GUIDED_DENOISED] = "fewray: guided, denoised",
    [BENCH_PT_OIDN] = "fewray: path tracing + OIDN",
    [BENCH_MITSUBA] = "Mitsuba 3: path tracing",
    [BENCH_MITSUBA_OIDN] = "Mitsuba 3: path tracing + OIDN",
};

/* What the steps of a bench share. */
struct work {
    struct bench *bench;
    const struct fewray_frame *reference;
    struct peers *peers;
    bool oidn;
    /* Progress in samples a pixel; the seconds of a job are about in proportion to them. */
    double done, job, all;
};

/* Samples a pixel that the fixed costs of a job are worth. */
static const double FIXED_COST = 2;

static void report_progress(const struct work *work, double fraction_of_job) {
    const struct fewray_render_settings *settings = &work->bench->settings.render;
    if (settings->progress)
        settings->progress(settings->progress_user, "bench",
                           (work->done + fraction_of_job * work->job) / work->all);
}

static void job_progress(void *user, const char *phase, double fraction) {
    if (!strcmp(phase, "render"))
        report_progress(user, fraction);
}

static void begin_job(struct work *work, double samples) {
    work->done += work->job;
    work->job = samples + FIXED_COST;
    report_progress(work, 0);
}

/* Planes of a frame under other names; owns nothing. */
struct view {
    struct fewray_frame frame;
    struct fewray_plane planes[9];
};

static void view_layer(struct view *view, const struct fewray_frame *from, enum fewray_layer layer,
                       enum fewray_layer as) {
    float *data[3];
    const char *const *names = fewray_layer_channels(as, &(int){0});
    if (!fewray_frame_layer(from, layer, data))
        return;
    for (int c = 0; c < 3; c++) {
        struct fewray_plane *plane = &view->planes[view->frame.plane_count++];
        snprintf(plane->name, sizeof plane->name, "%s", names[c]);
        plane->data = data[c];
    }
}

static void view_noisy(struct view *view, const struct fewray_frame *from, bool features) {
    *view = (struct view){.frame = {.width = from->width, .height = from->height}};
    view->frame.planes = view->planes;
    view_layer(view, from, FEWRAY_NOISY, FEWRAY_COLOR);
    if (features) {
        view_layer(view, from, FEWRAY_ALBEDO, FEWRAY_ALBEDO);
        view_layer(view, from, FEWRAY_NORMAL, FEWRAY_NORMAL);
    }
}

/* Judges the picture and adds the row, with work_s filled. */
static int add_row(struct work *work, const struct fewray_frame *picture, struct bench_row row,
                   struct fewray_error *error) {
    struct bench *bench = work->bench;
    const int status = fewray_compare(picture, work->reference, &row.metrics, error);
    if (status)
        return status;
    if (bench->row_count == bench->row_room) {
        const int room = bench->row_room ? 2 * bench->row_room : 64;
        struct bench_row *rows = realloc(bench->rows, (size_t)room * sizeof *rows);
        if (!rows)
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the rows");
        bench->rows = rows;
        bench->row_room = room;
    }
    row.work_s = row.initial_s + row.guide_s + row.render_s + row.denoise_s;
    bench->reference_noise = row.metrics.ref_mrse;
    bench->rows[bench->row_count++] = row;
    return bench_keep_picture(&bench->settings, &row, picture, error);
}

static const char *guide_of(const struct fewray_job *job, const struct fewray_run_stats *stats) {
    if (!job->guided)
        return "off";
    if (stats->guide_skipped)
        return "skipped by the pilot";
    return stats->first_look_was_all ? "first look is all" : "on";
}

static struct bench_row row_of(const struct fewray_job *job, const struct fewray_run_stats *stats) {
    return (struct bench_row){
        .method = job->guided ? BENCH_GUIDED_DENOISED : BENCH_PT_DENOISED,
        .spp = job->settings.spp,
        .seed = (int)job->settings.seed,
        .load_s = stats->load_s,
        .bvh_s = stats->bvh_s,
        .initial_s = stats->initial_s,
        .guide_s = stats->guide_s,
        .render_s = stats->render_s,
        .denoise_s = stats->denoise_s,
        .wall_s = stats->total_s,
        .paths = stats->counts.paths,
        .rays = stats->counts.rays,
        .guide = guide_of(job, stats),
    };
}

static struct fewray_job make_job(const struct work *work, int spp, int seed) {
    const struct bench *bench = work->bench;
    struct fewray_job job;
    fewray_job_init(&job);
    const int initial = job.settings.initial;
    job.scene_path = bench->settings.scene_path;
    job.scene = bench->settings.scene;
    job.settings = bench->settings.render;
    job.settings.initial = initial;
    job.settings.width = bench->width;
    job.settings.height = bench->height;
    job.settings.spp = spp;
    job.settings.seed = (uint64_t)seed;
    job.settings.progress = job_progress;
    job.settings.progress_user = (void *)work;
    return job;
}

static int fail_cancelled(struct fewray_error *error) {
    return fewray_fail(error, FEWRAY_ERROR_CANCELLED, NULL, 0, "interrupted");
}

static bool cancelled(const struct work *work) {
    return cancel_wanted(work->bench->settings.render.cancel);
}

/* From the first peer that fails on, the bench goes on without them. */
static int drop_peers(struct work *work, int status, const struct fewray_error *why,
                      struct fewray_error *error) {
    const struct bench_settings *settings = &work->bench->settings;
    peers_close(&work->peers);
    if (status == FEWRAY_ERROR_CANCELLED || cancelled(work))
        return fail_cancelled(error);
    char reason[1100], text[1200];
    snprintf(text, sizeof text, "without Mitsuba and OIDN from here on: %s",
             fewray_error_text(why, reason, sizeof reason));
    if (settings->warn)
        settings->warn(settings->warn_user, text);
    return FEWRAY_OK;
}

/* Our noisy picture through OIDN; row is the not denoised one. */
static int peer_filter(struct work *work, const struct fewray_frame *noisy, struct bench_row row,
                       struct fewray_error *error) {
    struct fewray_frame *picture = NULL;
    struct fewray_error why;
    int status = peers_denoise(work->peers, noisy, &picture, &row.denoise_s, &why);
    if (status)
        return drop_peers(work, status, &why, error);
    row.method = BENCH_PT_OIDN;
    row.wall_s = NAN; /* there is no such program */
    status = add_row(work, picture, row, error);
    fewray_frame_destroy(&picture);
    return status;
}

/* One render, two rows: what the denoiser was given, and what it made of it; and OIDN's. */
static int measure_ours(struct work *work, bool guided, int spp, int seed,
                        struct fewray_error *error) {
    struct fewray_job job = make_job(work, spp, seed);
    struct fewray_frame *picture = NULL;
    struct fewray_run_stats stats;
    struct view noisy;
    job.guided = guided;
    begin_job(work, spp);
    int status = fewray_job_run(&job, &picture, &stats, error);
    if (!status) {
        const struct bench_row denoised = row_of(&job, &stats);
        struct bench_row plain = denoised;
        plain.method = guided ? BENCH_GUIDED : BENCH_PT;
        plain.denoise_s = 0;
        plain.wall_s -= stats.denoise_s;
        view_noisy(&noisy, picture, true);
        status = add_row(work, &noisy.frame, plain, error);
        if (!status)
            status = add_row(work, picture, denoised, error);
        if (!status && !guided && work->peers && work->oidn)
            status = peer_filter(work, &noisy.frame, plain, error);
    }
    fewray_frame_destroy(&picture);
    return status;
}

/* Mitsuba with or without the features that a denoiser wants; with them, also what OIDN makes of
 * it. */
static int measure_mitsuba(struct work *work, bool features, int spp, int seed,
                           struct fewray_error *error) {
    struct fewray_frame *picture = NULL, *denoised = NULL;
    struct fewray_error why;
    struct bench_row row = {.method = features ? BENCH_MITSUBA_OIDN : BENCH_MITSUBA,
                            .spp = spp,
                            .seed = seed,
                            .load_s = NAN,
                            .bvh_s = NAN,
                            .wall_s = NAN,
                            .paths = (long long)work->bench->width * work->bench->height * spp,
                            .guide = "off"};
    begin_job(work, spp);
    int status = peers_render(work->peers, spp, seed, features, &picture, &row.render_s, &why);
    if (!status && features)
        status = peers_denoise(work->peers, picture, &denoised, &row.denoise_s, &why);
    status = status ? drop_peers(work, status, &why, error)
                    : add_row(work, denoised ? denoised : picture, row, error);
    fewray_frame_destroy(&picture);
    fewray_frame_destroy(&denoised);
    return status;
}

static int measure_all(struct work *work, int spp, int seed, struct fewray_error *error) {
    int status = measure_ours(work, false, spp, seed, error);
    if (!status)
        status = measure_ours(work, true, spp, seed, error);
    for (int features = 0; features < 2 && !status && work->peers; features++)
        if (!features || work->oidn)
            status = measure_mitsuba(work, features, spp, seed, error);
    return status;
}

/* Keeps the lesser of *least and the seconds of plain path tracing on so many threads. */
static int time_plain(struct work *work, int threads, double *least, struct fewray_error *error) {
    struct fewray_job job = make_job(work, THROUGHPUT_SPP, 1);
    struct fewray_run_stats stats;
    job.guided = job.denoised = false;
    job.settings.camera_rays = 0; /* for features alone */
    job.settings.threads = threads;
    begin_job(work, THROUGHPUT_SPP);
    const int status = fewray_job_run(&job, NULL, &stats, error);
    if (!status)
        *least = fmin(*least, stats.render_s); /* NaN at first, which fmin() passes over */
    return status;
}

static int time_mitsuba(struct work *work, bool features, double *least,
                        struct fewray_error *error) {
    struct fewray_error why;
    double seconds;
    begin_job(work, THROUGHPUT_SPP);
    const int status = peers_render(work->peers, THROUGHPUT_SPP, 1, features, NULL, &seconds, &why);
    if (status)
        return drop_peers(work, status, &why, error);
    *least = fmin(*least, seconds);
    return FEWRAY_OK;
}

/* The least of several times, taken in turn: what else the machine does only adds. */
static int measure_throughput(struct work *work, struct fewray_error *error) {
    struct bench_throughput *throughput = &work->bench->throughput;
    int status = FEWRAY_OK;
    for (int run = 0; run < THROUGHPUT_RUNS && !status; run++) {
        status = time_plain(work, 1, &throughput->one_thread_s, error);
        if (!status)
            status = time_plain(work, throughput->threads, &throughput->all_threads_s, error);
        if (!status && work->peers)
            status = time_mitsuba(work, false, &throughput->mitsuba_s, error);
        if (!status && work->peers)
            status = time_mitsuba(work, true, &throughput->mitsuba_features_s, error);
    }
    return status;
}

static int open_peers(struct work *work, struct fewray_error *error) {
    struct bench *bench = work->bench;
    const struct bench_settings *settings = &bench->settings;
    const struct peers_settings wish = {
        .python = settings->python,
        .scene_path = settings->scene_path,
        .defines = settings->scene.defines,
        .define_count = settings->scene.define_count,
        .width = bench->width,
        .height = bench->height,
        .max_depth = settings->render.max_depth,
        .threads = bench->threads,
        .cancel = settings->render.cancel,
    };
    struct peers_info info;
    struct fewray_error why;
    const int status = peers_open(&wish, &work->peers, &info, &why);
    if (status)
        return drop_peers(work, status, &why, error);
    work->oidn = info.oidn;
    memcpy(bench->peers, info.names, sizeof bench->peers);
    bench->peers_load_s = info.load_s;
    bench->peers_compile_s = info.compile_s;
    if (!info.oidn && settings->warn)
        settings->warn(settings->warn_user,
                       "the peers' Python has no pyoidn: Mitsuba alone takes part");
    return FEWRAY_OK;
}

/* An estimate of all samples to come, for the progress. */
static double count_samples(const struct work *work) {
    const struct bench_settings *settings = &work->bench->settings;
    const int jobs = 2 + (work->peers ? 1 + work->oidn : 0);
    const int timed = 2 + (work->peers ? 1 : 0);
    double samples = timed * THROUGHPUT_RUNS * (THROUGHPUT_SPP + FIXED_COST);
    for (int i = 0; i < settings->spp_count; i++)
        samples += settings->seeds * jobs * (settings->spp[i] + FIXED_COST);
    return samples;
}

int bench_run(const struct bench_settings *settings, struct bench *bench,
              struct fewray_error *error) {
    struct fewray_frame *reference = NULL;
    *bench = (struct bench){.settings = *settings, .reference_noise = NAN};
    bench->threads = stats_threads(settings->render.threads);
    if (getloadavg(&bench->load_1min, 1) != 1)
        bench->load_1min = NAN;
    bench->throughput =
        (struct bench_throughput){THROUGHPUT_SPP, bench->threads, NAN, NAN, NAN, NAN};
    int status = read_picture(settings->reference_path, NAMING_AUTO, &reference, error);
    if (status)
        return status;
    bench->width = reference->width;
    bench->height = reference->height;

    struct work work = {.bench = bench, .reference = reference};
    status = bench_keep_reference(settings, reference, error);
    if (!status && settings->python)
        status = open_peers(&work, error);
    work.all = count_samples(&work);
    if (!status)
        status = measure_throughput(&work, error);
    for (int i = 0; i < settings->spp_count; i++)
        for (int seed = 1; seed <= settings->seeds && !status; seed++)
            status = measure_all(&work, settings->spp[i], seed, error);
    peers_close(&work.peers);
    fewray_frame_destroy(&reference);
    return status;
}

void bench_destroy(struct bench *bench) {
    free(bench->rows);
    bench->rows = NULL;
    bench->row_count = bench->row_room = 0;
}
