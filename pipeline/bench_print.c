/* SPDX-License-Identifier: Apache-2.0 */
/* A bench for people: tables on stdout. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "pipeline/bench.h"
#include "pipeline/curve.h"

enum { LEVELS_MAX = 4 };

static void print_points(const struct bench *bench) {
    const enum bench_metric first = bench_main_metric(bench);
    printf("%-16s %4s %9s %9s  %-32s %-11s %-11s %s\n", "method", "spp", "work [s]", "wall [s]",
           first == BENCH_MRSE_NET ? "mrse_net (least..most)" : "mrse_trimmed (least..most)",
           "mrse", "ssim_loss", "flip");
    for (int i = 0; i < bench->point_count; i++) {
        const struct bench_point *p = &bench->points[i];
        const struct bench_spread *e = &p->errors[first];
        char spread[48], wall[16] = "-";
        snprintf(spread, sizeof spread, "%.4g (%.4g..%.4g)", e->median, e->least, e->most);
        if (!isnan(p->wall_s))
            snprintf(wall, sizeof wall, "%.3f", p->wall_s);
        printf("%-16s %4d %9.3f %9s  %-32s %-11.4g %-11.4g %.4g%s%s\n",
               BENCH_METHOD_NAMES[p->method], p->spp, p->work_s, wall, spread,
               p->errors[BENCH_MRSE].median, p->errors[BENCH_SSIM_LOSS].median,
               p->errors[BENCH_FLIP].median, strcmp(p->guide, "off") ? "  guide: " : "",
               strcmp(p->guide, "off") ? p->guide : "");
    }
}

/* Round errors (1, 2, 5 times a power of ten) that at least two curves get down to from above,
 * greatest first. */
static int choose_levels(const struct curve curves[BENCH_METHODS], double levels[LEVELS_MAX]) {
    static const double digits[3] = {5, 2, 1};
    int count = 0;
    for (int power = 4; power >= -7; power--)
        for (int d = 0; d < 3; d++) {
            const double level = digits[d] * pow(10, power);
            int crossed = 0;
            for (int method = 0; method < BENCH_METHODS; method++) {
                const struct curve *curve = &curves[method];
                crossed += curve->count > 0 && curve->error[0] > level &&
                           !isnan(curve_seconds_to(curve, level));
            }
            if (crossed < 2)
                continue;
            if (count == LEVELS_MAX) /* the small errors are what matters */
                memmove(levels, levels + 1, (LEVELS_MAX - 1) * sizeof *levels);
            else
                count++;
            levels[count - 1] = level;
        }
    return count;
}

static void print_times_to_errors(const struct bench *bench) {
    const enum bench_metric metric = bench_main_metric(bench);
    struct curve curves[BENCH_METHODS];
    double levels[LEVELS_MAX];
    for (int method = 0; method < BENCH_METHODS; method++)
        bench_curve(bench, (enum bench_method)method, metric, &curves[method]);
    const int count = choose_levels(curves, levels);
    if (count == 0)
        return;
    printf("\nseconds of work to reach %s of", BENCH_METRIC_NAMES[metric]);
    for (int k = 0; k < count; k++)
        printf(" %9g", levels[k]);
    putchar('\n');
    for (int method = 0; method < BENCH_METHODS; method++) {
        if (curves[method].count == 0)
            continue;
        printf("%-37s", BENCH_METHOD_NAMES[method]);
        for (int k = 0; k < count; k++) {
            char text[16] = "-";
            const double seconds = curve_seconds_to(&curves[method], levels[k]);
            const bool sooner = curves[method].error[0] <= levels[k];
            if (!isnan(seconds))
                snprintf(text, sizeof text, "%s%.3f", sooner ? "<=" : "", seconds);
            printf(" %9s", text);
        }
        putchar('\n');
    }
}

static void print_same_time(const struct bench *bench) {
    const enum bench_metric metrics[3] = {bench_main_metric(bench), BENCH_SSIM_LOSS, BENCH_FLIP};
    if (!bench_has_points(bench, BENCH_MITSUBA_OIDN))
        return;
    printf("\nerror of %s over ours after the same seconds of work (above 1: ours is better; "
           "-: it has no\npicture that soon or that late)\n%-16s %4s %9s %13s %13s %13s\n",
           BENCH_METHOD_NAMES[BENCH_MITSUBA_OIDN], "method", "spp", "work [s]",
           BENCH_METRIC_NAMES[metrics[0]], BENCH_METRIC_NAMES[metrics[1]],
           BENCH_METRIC_NAMES[metrics[2]]);
    for (int i = 0; i < bench->point_count; i++) {
        const struct bench_point *p = &bench->points[i];
        if (p->method != BENCH_PT_DENOISED && p->method != BENCH_GUIDED_DENOISED)
            continue;
        printf("%-16s %4d %9.3f", BENCH_METHOD_NAMES[p->method], p->spp, p->work_s);
        for (int m = 0; m < 3; m++) {
            struct curve peer;
            char text[16] = "-";
            bench_curve(bench, BENCH_MITSUBA_OIDN, metrics[m], &peer);
            const double ratio = curve_error_at(&peer, p->work_s) / p->errors[metrics[m]].median;
            if (ratio > 0)
                snprintf(text, sizeof text, "%.3f", ratio);
            printf(" %13s", text);
        }
        putchar('\n');
    }
}

static void print_throughput(const struct bench *bench) {
    const struct bench_throughput *t = &bench->throughput;
    const double paths = 1e-6 * bench->width * bench->height * t->spp;
    if (isnan(t->all_threads_s))
        return;
    printf("\npath tracing with features: %.2f M paths/s on %d threads, %.2f M paths/s on 1 "
           "(speedup %.2f)",
           paths / t->all_threads_s, t->threads, paths / t->one_thread_s,
           t->one_thread_s / t->all_threads_s);
    if (!isnan(t->mitsuba_s))
        printf("; Mitsuba without features %.2f M paths/s (ours over it: %.2f), with albedo and "
               "normal %.2f (%.2f)",
               paths / t->mitsuba_s, t->mitsuba_s / t->all_threads_s, paths / t->mitsuba_features_s,
               t->mitsuba_features_s / t->all_threads_s);
    putchar('\n');
}

void bench_print(const struct bench *bench) {
    print_points(bench);
    print_times_to_errors(bench);
    print_same_time(bench);
    print_throughput(bench);
    if (bench->peers[0])
        printf("peers: %s; scene %.2f s and kernels %.2f s aren't counted\n", bench->peers,
               bench->peers_load_s, bench->peers_compile_s);
}
