/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_BENCH_H
#define FEWRAY_PIPELINE_BENCH_H

/* Error against time: renders a scene by every method at several samples a pixel and with several
 * seeds, and judges each picture by a reference. What `fewray bench` does, step by step:
 *
 *     bench_run()          scene, reference -> rows, one for each picture
 *     bench_summarize()    rows -> points: medians over the seeds, least times
 *     bench_write_csv(), bench_write_json(), bench_plot(), bench_print()
 */

#include "fewray/pipeline.h"

enum bench_method {
    BENCH_PT,
    BENCH_GUIDED,
    BENCH_PT_DENOISED,
    BENCH_GUIDED_DENOISED,
    BENCH_PT_OIDN, /* our picture through Open Image Denoise; this and the next ones: peers */
    BENCH_MITSUBA,
    BENCH_MITSUBA_OIDN,
    BENCH_METHODS
};
extern const char *const BENCH_METHOD_NAMES[BENCH_METHODS];
extern const char *const BENCH_METHOD_LEGENDS[BENCH_METHODS]; /* longer, for people */

enum bench_metric {
    BENCH_MRSE,
    BENCH_MRSE_TRIMMED,
    BENCH_MRSE_NET, /* NaN where the reference doesn't tell its noise */
    BENCH_SSIM_LOSS,
    BENCH_FLIP,
    BENCH_METRICS
};
extern const char *const BENCH_METRIC_NAMES[BENCH_METRICS];

enum { BENCH_SPP_MAX = 24 };

struct bench_settings {
    const char *scene_path, *reference_path;
    struct fewray_scene_options scene;
    struct fewray_render_settings render; /* its threads, depth, progress and cancel hold */
    int spp[BENCH_SPP_MAX], spp_count;    /* samples a pixel, ascending */
    int seeds;                            /* 1..seeds */
    int keep_spp;            /* of the first seed, pictures of so many samples are kept; 0: none */
    const char *keep_folder; /* ... here, as EXR with their seconds as JSON, and the reference */
    const char *python;      /* NULL: without peers */
    void (*warn)(void *user, const char *text);
    void *warn_user;
};

/* One picture judged. Seconds are of wall time; NaN: not known. */
struct bench_row {
    enum bench_method method;
    int spp, seed;
    /* of this picture alone, as struct fewray_run_stats; work_s is the sum from initial_s to
     * denoise_s, wall_s the whole run from file to finished picture */
    double load_s, bvh_s, initial_s, guide_s, render_s, denoise_s, work_s, wall_s;
    long long paths, rays; /* 0: not known */
    const char *guide;     /* what became of the guide; static */
    struct fewray_metrics metrics;
};

/* Median, least and most over the seeds. */
struct bench_spread {
    double median, least, most;
};

/* One method at one number of samples a pixel. */
struct bench_point {
    enum bench_method method;
    int spp, rows;
    double work_s, wall_s; /* least of the seeds */
    const char *guide;     /* of the first seed */
    struct bench_spread errors[BENCH_METRICS];
};

/* Paths a second of plain path tracing. Ours always makes albedo, normal, depth and variance, too;
 * without the extra camera rays at edges. */
struct bench_throughput {
    int spp;
    int threads;                        /* all that the run uses */
    double one_thread_s, all_threads_s; /* least seconds of rendering */
    double mitsuba_s;                   /* its picture alone, on all threads; NaN without peers */
    double mitsuba_features_s;          /* with albedo and normal */
};

struct bench {
    struct bench_settings settings;
    int width, height, threads;
    struct bench_row *rows; /* owned */
    int row_count, row_room;
    struct bench_throughput throughput;
    double reference_noise; /* ref_mrse; NaN */
    double load_1min;       /* of the machine, before the bench; NaN */
    char peers[256];        /* "Mitsuba 3.9.1 llvm_ad_rgb, OIDN 2.5.1"; empty: none took part */
    double peers_load_s, peers_compile_s; /* Mitsuba's scene and kernels; not in any row */
    struct bench_point points[BENCH_METHODS * BENCH_SPP_MAX]; /* by method, then spp */
    int point_count;
};

/* Renders and judges. The bench is to be destroyed also after an error: it holds the rows that were
 * done, FEWRAY_ERROR_CANCELLED among the errors. Peers that can't be had or that fail are a
 * warning. */
int bench_run(const struct bench_settings *settings, struct bench *bench,
              struct fewray_error *error);
void bench_destroy(struct bench *bench);

/* Writes METHOD-4spp.exr and .json into the folder, as `fewray report` takes them. */
int bench_keep_picture(const struct bench_settings *settings, const struct bench_row *row,
                       const struct fewray_frame *picture, struct fewray_error *error);
/* Writes reference.exr there, unless the reference is that file. */
int bench_keep_reference(const struct bench_settings *settings,
                         const struct fewray_frame *reference, struct fewray_error *error);

/* Fills the points. */
void bench_summarize(struct bench *bench);
bool bench_has_points(const struct bench *bench, enum bench_method method);
/* Error against work_s of one method; empty where it has no points. */
struct curve;
void bench_curve(const struct bench *bench, enum bench_method method, enum bench_metric metric,
                 struct curve *curve);
/* The metric that time is judged by: mrse_net, or mrse_trimmed without the reference's noise. */
enum bench_metric bench_main_metric(const struct bench *bench);

/* Each writes a file whole or not at all. */
int bench_write_csv(const struct bench *bench, const char *path, struct fewray_error *error);
int bench_write_json(const struct bench *bench, const char *path, struct fewray_error *error);
int bench_plot(const struct bench *bench, const char *path, struct fewray_error *error);
/* Medians, times to errors and errors at the same time, for people, on stdout. */
void bench_print(const struct bench *bench);

#endif
