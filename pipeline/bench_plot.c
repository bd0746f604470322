/* SPDX-License-Identifier: Apache-2.0 */
/* Error against time as a picture: a panel for each metric, both axes logarithmic, a curve for each
 * method with the spread over the seeds as bars, and a legend. What isn't denoised is pale and
 * dashed; each maker has a colour and a marker. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "pipeline/axis.h"
#include "pipeline/bench.h"
#include "pipeline/opencv.h"
#include "pipeline/origin.h"

enum { BACKGROUND = 0xffffff, INK = 0x1c1f24, FAINT = 0x5c6470, GRID = 0xe2e5ea };
enum {
    PANELS = 3,
    PANEL_WIDTH = 410,
    PANEL_HEIGHT = 400,
    TITLE = 18,
    LETTER = 15,
    SMALL = 13
}; /* pixels */
enum { EDGE = 24, GAP = 30, TOP = 170, X_ROOM = 8, Y_ROOM = 9, TICK = 8, SMALL_TICK = 4 };

enum marker { CIRCLE, DIAMOND, SQUARE, TRIANGLE };

static const struct style {
    canvas_color color;
    enum marker marker;
    int thickness;
    bool dashed;
} STYLES[BENCH_METHODS] = {
    [BENCH_PT] = {0x74a9e0, CIRCLE, 2, true},
    [BENCH_GUIDED] = {0xf2a269, DIAMOND, 2, true},
    [BENCH_PT_DENOISED] = {0x1864ab, CIRCLE, 2, false},
    [BENCH_GUIDED_DENOISED] = {0xd9380b, DIAMOND, 3, false},
    [BENCH_PT_OIDN] = {0x2f9e44, TRIANGLE, 2, false},
    [BENCH_MITSUBA] = {0x9aa0a8, SQUARE, 2, true},
    [BENCH_MITSUBA_OIDN] = {0x2b2f36, SQUARE, 2, false},
};

static const char *const ABOUT[BENCH_METRICS] = {
    [BENCH_MRSE_TRIMMED] = "squared relative error, worst 0.01 % left out",
    [BENCH_MRSE_NET] = "squared relative error, less the reference's",
    [BENCH_SSIM_LOSS] = "1 - SSIM of the displayed pictures",
    [BENCH_FLIP] = "FLIP of the displayed pictures, 0..1",
};

struct plot {
    const struct bench *bench;
    const struct opencv *cv;
    struct canvas *canvas;
    struct axis time;
    int width, height;
};

struct panel {
    enum bench_metric metric;
    struct axis error;
    int left, top; /* pixels, of the frame */
};

static double x_of(const struct plot *plot, const struct panel *panel, double seconds) {
    return panel->left + PANEL_WIDTH * axis_place(plot->time, seconds);
}

static double y_of(const struct panel *panel, double error) {
    return panel->top + PANEL_HEIGHT * (1 - axis_place(panel->error, error));
}

/* Text whose middle is at x. */
static void text_centred(const struct plot *plot, double x, int y, double size, canvas_color color,
                         const char *text) {
    const int width = plot->cv->text_width(size, text);
    plot->cv->text(plot->canvas, (int)lround(x - width / 2.0), y, size, color, text);
}

static void line(const struct plot *plot, double x0, double y0, double x1, double y1, int thickness,
                 canvas_color color) {
    const double points[4] = {x0, y0, x1, y1};
    plot->cv->polyline(plot->canvas, points, 2, thickness, color);
}

/* Dashes start at each of a curve's points, so that short pieces have one, too. */
static void dashed_line(const struct plot *plot, double x0, double y0, double x1, double y1,
                        int thickness, canvas_color color) {
    const double dash = 9, space = 6, length = hypot(x1 - x0, y1 - y0);
    for (double at = 0; at < length; at += dash + space) {
        const double from = at / length, to = fmin((at + dash) / length, 1);
        line(plot, x0 + from * (x1 - x0), y0 + from * (y1 - y0), x0 + to * (x1 - x0),
             y0 + to * (y1 - y0), thickness, color);
    }
}

static void draw_stroke(const struct plot *plot, const struct style *style, double x0, double y0,
                        double x1, double y1) {
    (style->dashed ? dashed_line : line)(plot, x0, y0, x1, y1, style->thickness, style->color);
}

/* Markers of equal area by eye. */
static void draw_marker(const struct plot *plot, const struct style *style, double x, double y) {
    const double r = style->thickness + 3.5;
    const double diamond[8] = {x, y - 1.3 * r, x + 1.3 * r, y, x, y + 1.3 * r, x - 1.3 * r, y};
    const double square[8] = {x - r, y - r, x + r, y - r, x + r, y + r, x - r, y + r};
    const double triangle[6] = {x, y - 1.4 * r, x + 1.3 * r, y + r, x - 1.3 * r, y + r};
    switch (style->marker) {
    case CIRCLE:
        plot->cv->disc(plot->canvas, x, y, 1.1 * r, style->color);
        break;
    case DIAMOND:
        plot->cv->polygon(plot->canvas, diamond, 4, style->color);
        break;
    case SQUARE:
        plot->cv->polygon(plot->canvas, square, 4, style->color);
        break;
    case TRIANGLE:
        plot->cv->polygon(plot->canvas, triangle, 3, style->color);
        break;
    }
}

static bool drawable(const struct bench_point *point, enum bench_metric metric) {
    return point->work_s > 0 && point->errors[metric].median > 0;
}

/* The least error of the seeds may be below the reference's noise, where mrse_net isn't positive:
 * no logarithm. */
static double lower_end(const struct bench_spread *spread) {
    return spread->least > 0 ? spread->least : spread->median;
}

static void draw_spread(const struct plot *plot, const struct panel *panel,
                        const struct bench_point *point) {
    const struct bench_spread *spread = &point->errors[panel->metric];
    const struct style *style = &STYLES[point->method];
    const double x = x_of(plot, panel, point->work_s), cap = 5,
                 low = y_of(panel, lower_end(spread)), high = y_of(panel, spread->most);
    line(plot, x, low, x, high, 1, style->color);
    line(plot, x - cap, low, x + cap, low, 1, style->color);
    line(plot, x - cap, high, x + cap, high, 1, style->color);
}

static void draw_curve(const struct plot *plot, const struct panel *panel, int method) {
    const struct style *style = &STYLES[method];
    const struct bench_point *last = NULL;
    for (int i = 0; i < plot->bench->point_count; i++) {
        const struct bench_point *point = &plot->bench->points[i];
        if ((int)point->method != method || !drawable(point, panel->metric))
            continue;
        const double x = x_of(plot, panel, point->work_s),
                     y = y_of(panel, point->errors[panel->metric].median);
        if (last)
            draw_stroke(plot, style, x_of(plot, panel, last->work_s),
                        y_of(panel, last->errors[panel->metric].median), x, y);
        draw_spread(plot, panel, point);
        draw_marker(plot, style, x, y);
        last = point;
    }
}

static void draw_time_axis(const struct plot *plot, const struct panel *panel) {
    struct axis_tick ticks[AXIS_TICKS_MAX];
    const int count = axis_ticks(plot->time, X_ROOM, ticks);
    const int bottom = panel->top + PANEL_HEIGHT;
    for (int i = 0; i < count; i++) {
        const double x = x_of(plot, panel, ticks[i].value);
        const bool labelled = ticks[i].label[0];
        if (labelled)
            line(plot, x, panel->top, x, bottom, 1, GRID);
        line(plot, x, bottom - (labelled ? TICK : SMALL_TICK), x, bottom, 1, INK);
        text_centred(plot, x, bottom + SMALL + 9, SMALL, INK, ticks[i].label);
    }
    text_centred(plot, panel->left + PANEL_WIDTH / 2.0, bottom + SMALL + LETTER + 24, LETTER, INK,
                 "work [s]");
}

static void draw_error_axis(const struct plot *plot, const struct panel *panel) {
    struct axis_tick ticks[AXIS_TICKS_MAX];
    const int count = axis_ticks(panel->error, Y_ROOM, ticks);
    for (int i = 0; i < count; i++) {
        const double y = y_of(panel, ticks[i].value);
        const bool labelled = ticks[i].label[0];
        if (labelled)
            line(plot, panel->left, y, panel->left + PANEL_WIDTH, y, 1, GRID);
        line(plot, panel->left, y, panel->left + (labelled ? TICK : SMALL_TICK), y, 1, INK);
        plot->cv->text(plot->canvas, panel->left - 8 - plot->cv->text_width(SMALL, ticks[i].label),
                       (int)lround(y + SMALL / 2.0), SMALL, INK, ticks[i].label);
    }
}

/* Ranges of what is drawn; false where nothing can be. */
static bool find_ranges(const struct bench *bench, enum bench_metric metric, struct axis *time,
                        struct axis *error) {
    double soonest = INFINITY, latest = 0, least = INFINITY, most = 0;
    for (int i = 0; i < bench->point_count; i++) {
        const struct bench_point *point = &bench->points[i];
        if (!drawable(point, metric))
            continue;
        soonest = fmin(soonest, point->work_s);
        latest = fmax(latest, point->work_s);
        least = fmin(least, lower_end(&point->errors[metric]));
        most = fmax(most, point->errors[metric].most);
    }
    if (!(latest > 0))
        return false;
    *time = axis_around(soonest, latest);
    *error = axis_around(least, most);
    return true;
}

static void draw_panel(const struct plot *plot, const struct panel *panel) {
    draw_time_axis(plot, panel);
    draw_error_axis(plot, panel);
    const struct box frame = {panel->left, panel->top, PANEL_WIDTH + 1, PANEL_HEIGHT + 1};
    plot->cv->outline(plot->canvas, frame, 1, INK);
    plot->cv->text(plot->canvas, panel->left, panel->top - SMALL - 18, LETTER, INK,
                   BENCH_METRIC_NAMES[panel->metric]);
    plot->cv->text(plot->canvas, panel->left, panel->top - 9, SMALL, FAINT, ABOUT[panel->metric]);
    for (int method = BENCH_METHODS - 1; method >= 0; method--) /* ours over the others */
        draw_curve(plot, panel, method);
}

static void draw_legend(const struct plot *plot, int top) {
    enum { COLUMNS = 4, ROW = 30, SAMPLE = 38 };
    const int column = (plot->width - 2 * EDGE) / COLUMNS;
    int place = 0;
    for (int method = 0; method < BENCH_METHODS; method++) {
        if (!bench_has_points(plot->bench, (enum bench_method)method))
            continue;
        const double x = EDGE + place % COLUMNS * column, y = top + place / COLUMNS * ROW;
        draw_stroke(plot, &STYLES[method], x, y, x + SAMPLE, y);
        draw_marker(plot, &STYLES[method], x + SAMPLE / 2.0, y);
        plot->cv->text(plot->canvas, (int)x + SAMPLE + 10, (int)y + SMALL / 2, SMALL, INK,
                       BENCH_METHOD_LEGENDS[method]);
        place++;
    }
}

/* The last two parts of a path, "veach-ajar/scene.xml". */
static const char *short_path(const char *path) {
    const char *start = path;
    int slashes = 0;
    for (const char *c = path + strlen(path); c > path && slashes < 2; c--)
        if (c[-1] == '/' && ++slashes == 2)
            start = c;
    return start;
}

static void draw_title(const struct plot *plot) {
    const struct bench *bench = plot->bench;
    const struct bench_settings *settings = &bench->settings;
    char text[512], cpu[64];
    origin_cpu(cpu, sizeof cpu);
    int y = EDGE + TITLE;
    snprintf(text, sizeof text, "Error against time: %s", short_path(settings->scene_path));
    plot->cv->text(plot->canvas, EDGE, y, TITLE, INK, text);
    snprintf(text, sizeof text, "%dx%d pixels, %d to %d samples a pixel, %d threads of %s",
             bench->width, bench->height, settings->spp[0], settings->spp[settings->spp_count - 1],
             bench->threads, cpu);
    plot->cv->text(plot->canvas, EDGE, y += 2 * SMALL + 2, SMALL, FAINT, text);
    snprintf(text, sizeof text,
             "curves: medians of %d seed%s, least times; bars: from the least to the most error",
             settings->seeds, settings->seeds > 1 ? "s" : "");
    plot->cv->text(plot->canvas, EDGE, y + SMALL + 9, SMALL, FAINT, text);
}

static void draw_all(struct plot *plot, int legend_top) {
    const enum bench_metric metrics[PANELS] = {bench_main_metric(plot->bench), BENCH_SSIM_LOSS,
                                               BENCH_FLIP};
    const int label_room = plot->cv->text_width(SMALL, "0.0005") + 8;
    draw_title(plot);
    for (int i = 0; i < PANELS; i++) {
        struct panel panel = {.metric = metrics[i],
                              .left = EDGE + label_room + i * (PANEL_WIDTH + GAP + label_room),
                              .top = TOP};
        if (find_ranges(plot->bench, panel.metric, &plot->time, &panel.error))
            draw_panel(plot, &panel);
    }
    draw_legend(plot, legend_top);
}

int bench_plot(const struct bench *bench, const char *path, struct fewray_error *error) {
    struct plot plot = {.bench = bench, .cv = opencv_open(error)};
    if (!plot.cv)
        return FEWRAY_ERROR_UNSUPPORTED;
    const int legend_top = TOP + PANEL_HEIGHT + 90;
    plot.width = 2 * EDGE + PANELS * (PANEL_WIDTH + plot.cv->text_width(SMALL, "0.0005") + 8) +
                 (PANELS - 1) * GAP;
    plot.height = legend_top + 60;
    plot.canvas = plot.cv->create(plot.width, plot.height, BACKGROUND);
    int status = FEWRAY_OK;
    if (plot.canvas)
        draw_all(&plot, legend_top);
    const uint8_t *pixels = plot.canvas ? plot.cv->pixels(plot.canvas) : NULL;
    if (!pixels)
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for the plot");
    else
        status = fewray_image_write_png(path, plot.width, plot.height, pixels, error);
    if (plot.canvas)
        plot.cv->destroy(&plot.canvas);
    return status;
}
