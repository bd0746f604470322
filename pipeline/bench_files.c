/* SPDX-License-Identifier: Apache-2.0 */
/* A bench as CSV, a line for each picture, and as JSON, for what is made of them. */

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pipeline/bench.h"
#include "pipeline/curve.h"
#include "pipeline/origin.h"

static const char CSV_HEAD[] =
    "method,spp,seed,guide,load_s,bvh_s,initial_s,guide_s,render_s,denoise_s,work_s,wall_s,"
    "paths,rays,mrse,mrse_trimmed,mrse_top1,mrse_net,ref_mrse,mse_radiance2,mape,l1_radiance,"
    "ssim_loss,flip,psnr_dB,nonfinite_pixels\n";

/* What isn't known is left empty. */
static void put_number(FILE *file, double value, int digits) {
    fputc(',', file);
    if (!isnan(value))
        fprintf(file, "%.*g", digits, value);
}

static void put_count(FILE *file, long long count) {
    fputc(',', file);
    if (count > 0)
        fprintf(file, "%lld", count);
}

static void put_row(FILE *file, const struct bench_row *row) {
    const struct fewray_metrics *m = &row->metrics;
    const double seconds[] = {row->load_s,   row->bvh_s,     row->initial_s, row->guide_s,
                              row->render_s, row->denoise_s, row->work_s,    row->wall_s};
    const double errors[] = {m->mrse,      m->mrse_trimmed, m->mrse_top1, m->mrse_net,
                             m->ref_mrse,  m->mse,          m->mape,      m->l1,
                             m->ssim_loss, m->flip,         m->psnr};
    fprintf(file, "%s,%d,%d,%s", BENCH_METHOD_NAMES[row->method], row->spp, row->seed, row->guide);
    for (size_t i = 0; i < sizeof seconds / sizeof *seconds; i++)
        put_number(file, seconds[i], 6);
    put_count(file, row->paths);
    put_count(file, row->rays);
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++)
        put_number(file, errors[i], 9);
    fprintf(file, ",%lld\n", m->n_nonfinite);
}

static bool put_csv(FILE *file, const void *data) {
    const struct bench *bench = data;
    fputs(CSV_HEAD, file);
    for (int i = 0; i < bench->row_count; i++)
        put_row(file, &bench->rows[i]);
    return true;
}

/* Puts the text together in memory, so that only its writing can fail by the disk. */
static int write_whole(const char *path, bool (*put)(FILE *file, const void *data),
                       const void *data, struct fewray_error *error) {
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    bool made = file && put(file, data);
    if (file) {
        made = !ferror(file) && made;
        made = !fclose(file) && made;
    }
    const int status =
        made ? fewray_write_file(path, text, size, error)
             : fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for the file's text");
    free(text);
    return status;
}

int bench_write_csv(const struct bench *bench, const char *path, struct fewray_error *error) {
    return write_whole(path, put_csv, bench, error);
}

/* --- JSON */

/* JSON has no infinity and no NaN: null. */
static json_t *number(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *spread_json(const struct bench_spread *spread) {
    return json_pack("{s:o, s:o, s:o}", "median", number(spread->median), "least",
                     number(spread->least), "most", number(spread->most));
}

static json_t *points_json(const struct bench *bench, int method) {
    json_t *points = json_array();
    for (int i = 0; i < bench->point_count; i++) {
        const struct bench_point *point = &bench->points[i];
        if ((int)point->method != method)
            continue;
        json_t *object = json_pack("{s:i, s:i, s:s, s:o, s:o}", "spp", point->spp, "seeds",
                                   point->rows, "guide", point->guide, "work_s",
                                   number(point->work_s), "wall_s", number(point->wall_s));
        for (int m = 0; m < BENCH_METRICS; m++)
            json_object_set_new(object, BENCH_METRIC_NAMES[m], spread_json(&point->errors[m]));
        json_array_append_new(points, object);
    }
    return points;
}

static json_t *methods_json(const struct bench *bench) {
    json_t *methods = json_array();
    for (int method = 0; method < BENCH_METHODS; method++) {
        json_t *points = points_json(bench, method);
        if (json_array_size(points) > 0)
            json_array_append_new(methods, json_pack("{s:s, s:O}", "method",
                                                     BENCH_METHOD_NAMES[method], "points", points));
        json_decref(points);
    }
    return methods;
}

/* Error of Mitsuba + OIDN over ours after the same seconds of work, at our points. */
static json_t *same_time_json(const struct bench *bench) {
    json_t *list = json_array();
    for (int m = 0; m < BENCH_METRICS; m++) {
        struct curve peer;
        bench_curve(bench, BENCH_MITSUBA_OIDN, (enum bench_metric)m, &peer);
        for (int i = 0; i < bench->point_count && peer.count > 0; i++) {
            const struct bench_point *point = &bench->points[i];
            const double ratio = curve_error_at(&peer, point->work_s) / point->errors[m].median;
            if (point->method >= BENCH_PT_OIDN || !(ratio > 0))
                continue;
            json_array_append_new(
                list, json_pack("{s:s, s:s, s:i, s:f, s:f}", "metric", BENCH_METRIC_NAMES[m],
                                "method", BENCH_METHOD_NAMES[point->method], "spp", point->spp,
                                "work_s", point->work_s, "peer_error_over_ours", ratio));
        }
    }
    return list;
}

static json_t *throughput_json(const struct bench *bench) {
    const struct bench_throughput *t = &bench->throughput;
    const double paths = (double)bench->width * bench->height * t->spp;
    return json_pack("{s:i, s:i, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "spp", t->spp, "threads",
                     t->threads, "one_thread_s", number(t->one_thread_s), "all_threads_s",
                     number(t->all_threads_s), "paths_per_s", number(paths / t->all_threads_s),
                     "speedup_by_threads", number(t->one_thread_s / t->all_threads_s),
                     "mitsuba_paths_per_s", number(paths / t->mitsuba_s), "over_mitsuba",
                     number(t->mitsuba_s / t->all_threads_s), "mitsuba_with_features_paths_per_s",
                     number(paths / t->mitsuba_features_s), "over_mitsuba_with_features",
                     number(t->mitsuba_features_s / t->all_threads_s));
}

static json_t *peers_json(const struct bench *bench) {
    if (!bench->peers[0])
        return json_null();
    return json_pack("{s:s, s:f, s:f}", "names", bench->peers, "load_s", bench->peers_load_s,
                     "compile_s", bench->peers_compile_s);
}

static json_t *settings_json(const struct bench *bench) {
    const struct bench_settings *settings = &bench->settings;
    json_t *spp = json_array();
    for (int i = 0; i < settings->spp_count; i++)
        json_array_append_new(spp, json_integer(settings->spp[i]));
    json_t *object =
        json_pack("{s:s, s:s, s:i, s:i, s:o, s:i, s:i}", "scene", settings->scene_path, "reference",
                  settings->reference_path, "width", bench->width, "height", bench->height, "spp",
                  spp, "seeds", settings->seeds, "threads", bench->threads);
    /* 0 means the scene's own */
    json_object_set_new(object, "max_depth",
                        settings->render.max_depth ? json_integer(settings->render.max_depth)
                                                   : json_null());
    return object;
}

static json_t *machine_json(const struct bench *bench) {
    char cpu[128];
    origin_cpu(cpu, sizeof cpu);
    return json_pack("{s:s, s:i, s:o}", "cpu", cpu, "threads", bench->threads, "load_1min_before",
                     number(bench->load_1min));
}

static bool put_json(FILE *file, const void *data) {
    return !json_dumpf(data, file, JSON_INDENT(1) | JSON_REAL_PRECISION(7)) &&
           fputc('\n', file) != EOF;
}

int bench_write_json(const struct bench *bench, const char *path, struct fewray_error *error) {
    json_t *object =
        json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "version", FEWRAY_VERSION, "machine",
                  machine_json(bench), "settings", settings_json(bench), "peers", peers_json(bench),
                  "ref_mrse", number(bench->reference_noise), "throughput", throughput_json(bench),
                  "methods", methods_json(bench), "same_time", same_time_json(bench));
    if (!object)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for the bench's JSON");
    const int status = write_whole(path, put_json, object, error);
    json_decref(object);
    return status;
}
