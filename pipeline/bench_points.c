/* SPDX-License-Identifier: Apache-2.0 */
/* Rows to points: medians over the seeds, least times. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pipeline/bench.h"
#include "pipeline/curve.h"

const char *const BENCH_METRIC_NAMES[BENCH_METRICS] = {"mrse", "mrse_trimmed", "mrse_net",
                                                       "ssim_loss", "flip"};

static double metric_of(const struct fewray_metrics *metrics, enum bench_metric metric) {
    switch (metric) {
    case BENCH_MRSE:
        return metrics->mrse;
    case BENCH_MRSE_TRIMMED:
        return metrics->mrse_trimmed;
    case BENCH_MRSE_NET:
        return metrics->mrse_net;
    case BENCH_SSIM_LOSS:
        return metrics->ssim_loss;
    case BENCH_FLIP:
        return metrics->flip;
    case BENCH_METRICS:
        break;
    }
    return NAN;
}

static int compare_doubles(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static struct bench_spread spread_of(double *values, int count) {
    qsort(values, (size_t)count, sizeof *values, compare_doubles);
    const double low = values[(count - 1) / 2], high = values[count / 2];
    return (struct bench_spread){(low + high) / 2, values[0], values[count - 1]};
}

static bool of_point(const struct bench_row *row, const struct bench_point *point) {
    return row->method == point->method && row->spp == point->spp;
}

/* values has room for every row. */
static void fill_point(const struct bench *bench, struct bench_point *point, double *values) {
    point->work_s = point->wall_s = INFINITY;
    for (int i = 0; i < bench->row_count; i++) {
        const struct bench_row *row = &bench->rows[i];
        if (!of_point(row, point))
            continue;
        if (point->rows++ == 0)
            point->guide = row->guide;
        point->work_s = fmin(point->work_s, row->work_s);
        point->wall_s = fmin(point->wall_s, row->wall_s);
    }
    if (isinf(point->wall_s))
        point->wall_s = NAN;
    for (int m = 0; m < BENCH_METRICS; m++) {
        int count = 0;
        for (int i = 0; i < bench->row_count; i++)
            if (of_point(&bench->rows[i], point))
                values[count++] = metric_of(&bench->rows[i].metrics, (enum bench_metric)m);
        if (count > 0)
            point->errors[m] = spread_of(values, count);
    }
}

void bench_summarize(struct bench *bench) {
    const struct bench_settings *settings = &bench->settings;
    double *values = malloc(((size_t)bench->row_count + 1) * sizeof *values);
    bench->point_count = 0;
    for (int method = 0; values && method < BENCH_METHODS; method++)
        for (int i = 0; i < settings->spp_count; i++) {
            struct bench_point point = {.method = (enum bench_method)method,
                                        .spp = settings->spp[i]};
            fill_point(bench, &point, values);
            if (point.rows > 0)
                bench->points[bench->point_count++] = point;
        }
    free(values);
}

bool bench_has_points(const struct bench *bench, enum bench_method method) {
    for (int i = 0; i < bench->point_count; i++)
        if (bench->points[i].method == method)
            return true;
    return false;
}

void bench_curve(const struct bench *bench, enum bench_method method, enum bench_metric metric,
                 struct curve *curve) {
    curve->count = 0;
    for (int i = 0; i < bench->point_count; i++) {
        const struct bench_point *point = &bench->points[i];
        if (point->method == method)
            curve_add(curve, point->work_s, point->errors[metric].median);
    }
}

enum bench_metric bench_main_metric(const struct bench *bench) {
    return isnan(bench->reference_noise) ? BENCH_MRSE_TRIMMED : BENCH_MRSE_NET;
}
