/* SPDX-License-Identifier: Apache-2.0 */
/* A bench's JSON as inline SVG: a panel for each metric, error against seconds, both axes
 * logarithmic. As pipeline/bench_plot.c draws it, but for the eye's own colour scheme and with the
 * values of each point. */

#include <math.h>
#include <string.h>

#include "pipeline/axis.h"
#include "pipeline/bench.h"
#include "pipeline/page/page.h"

enum { WIDTH = 420, HEIGHT = 340, LEFT = 58, RIGHT = 10, TOP = 10, BOTTOM = 44 };
enum { PANEL_WIDTH = WIDTH - LEFT - RIGHT, PANEL_HEIGHT = HEIGHT - TOP - BOTTOM };
enum { STYLES = 7, X_LABELS = 7, Y_LABELS = 8 };

struct panel {
    const char *metric;
    struct axis time, error;
};

struct point {
    int spp;
    double seconds, median, least, most;
};

static const char *about(const char *metric) {
    return !strcmp(metric, "mrse_net")    ? "mrse, less the reference's noise"
           : !strcmp(metric, "ssim_loss") ? "1 - SSIM of the displayed pictures"
           : !strcmp(metric, "flip")      ? "FLIP of the displayed pictures, 0 to 1"
                                          : "mrse, worst 0.01 % of the pixels left out";
}

static double number_of(const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

/* False for a point that a logarithmic axis has no place for. */
static bool read_point(const json_t *object, const char *metric, struct point *point) {
    const json_t *spread = json_object_get(object, metric);
    point->spp = (int)fmin(fmax(number_of(object, "spp"), 0), 1e9);
    point->seconds = number_of(object, "work_s");
    point->median = number_of(spread, "median");
    point->least = number_of(spread, "least");
    point->most = number_of(spread, "most");
    if (!(point->least > 0 && point->least <= point->median))
        point->least = point->median;
    if (!(point->most >= point->median))
        point->most = point->median;
    return point->seconds > 1e-9 && point->seconds < 1e12 && point->least > 1e-30 &&
           point->most < 1e30;
}

static const json_t *points_of(const json_t *method) {
    return json_object_get(method, "points");
}

/* Axes around all that can be drawn; false where nothing can. */
static bool find_ranges(const json_t *methods, struct panel *panel) {
    double soonest = INFINITY, latest = 0, least = INFINITY, most = 0;
    for (size_t m = 0; m < json_array_size(methods); m++) {
        const json_t *points = points_of(json_array_get(methods, m));
        for (size_t i = 0; i < json_array_size(points); i++) {
            struct point point;
            if (!read_point(json_array_get(points, i), panel->metric, &point))
                continue;
            soonest = fmin(soonest, point.seconds);
            latest = fmax(latest, point.seconds);
            least = fmin(least, point.least);
            most = fmax(most, point.most);
        }
    }
    if (!(latest > 0))
        return false;
    panel->time = axis_around(soonest, latest);
    panel->error = axis_around(least, most);
    return true;
}

static double x_of(const struct panel *panel, double seconds) {
    return LEFT + PANEL_WIDTH * axis_place(panel->time, seconds);
}

static double y_of(const struct panel *panel, double error) {
    return TOP + PANEL_HEIGHT * (1 - axis_place(panel->error, error));
}

static void put_axes(const struct page *page, const struct panel *panel) {
    struct axis_tick ticks[AXIS_TICKS_MAX];
    int count = axis_ticks(panel->time, X_LABELS, ticks);
    for (int i = 0; i < count; i++) {
        const double x = x_of(panel, ticks[i].value);
        if (ticks[i].label[0])
            fprintf(page->file,
                    "<path class=\"grid\" d=\"M%.1f %dv%d\"/><text x=\"%.1f\" y=\"%d\" "
                    "text-anchor=\"middle\">%s</text>\n",
                    x, TOP, PANEL_HEIGHT, x, HEIGHT - BOTTOM + 16, ticks[i].label);
    }
    count = axis_ticks(panel->error, Y_LABELS, ticks);
    for (int i = 0; i < count; i++) {
        const double y = y_of(panel, ticks[i].value);
        if (ticks[i].label[0])
            fprintf(page->file,
                    "<path class=\"grid\" d=\"M%d %.1fh%d\"/><text x=\"%d\" y=\"%.1f\" "
                    "text-anchor=\"end\">%s</text>\n",
                    LEFT, y, PANEL_WIDTH, LEFT - 6, y + 4, ticks[i].label);
    }
    fprintf(page->file,
            "<rect class=\"frame\" x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\"/><text x=\"%d\" "
            "y=\"%d\" text-anchor=\"middle\">work [s]</text>\n",
            LEFT, TOP, PANEL_WIDTH, PANEL_HEIGHT, LEFT + PANEL_WIDTH / 2, HEIGHT - 8);
}

/* The bench's own methods keep their colours, whichever of them took part. */
static int style_of(const char *name, size_t place) {
    for (int i = 0; i < BENCH_METHODS && name; i++)
        if (!strcmp(name, BENCH_METHOD_NAMES[i]))
            return i;
    return (int)(place % STYLES);
}

static const char *name_of(const json_t *method) {
    const char *name = json_string_value(json_object_get(method, "method"));
    return name ? name : "a method without a name";
}

static const char *legend_of(const char *name) {
    for (int i = 0; i < BENCH_METHODS; i++)
        if (!strcmp(name, BENCH_METHOD_NAMES[i]))
            return BENCH_METHOD_LEGENDS[i];
    return name;
}

/* What isn't denoised is dashed. */
static bool is_dashed(int style) {
    return style == BENCH_PT || style == BENCH_GUIDED || style == BENCH_MITSUBA;
}

/* Circle, diamond, triangle or square around the present point, so that curves differ without
 * colours, too. */
static const char *marker_of(int style) {
    static const char *const shapes[] = {
        "m-4.5 0a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0 -9 0z",
        "m0 -6l6 6l-6 6l-6 -6z",
        "m0 -6l6 10.5h-12z",
        "m-4.5 -4.5h9v9h-9z",
    };
    return shapes[style == BENCH_PT || style == BENCH_PT_DENOISED           ? 0
                  : style == BENCH_GUIDED || style == BENCH_GUIDED_DENOISED ? 1
                  : style == BENCH_PT_OIDN                                  ? 2
                                                                            : 3];
}

static void put_line(const struct page *page, const struct panel *panel, const json_t *points,
                     int style) {
    char command = 'M';
    struct point point;
    fprintf(page->file, "<path class=\"curve m%d%s\" style=\"fill:none\" d=\"", style,
            is_dashed(style) ? " dashed" : "");
    for (size_t i = 0; i < json_array_size(points); i++)
        if (read_point(json_array_get(points, i), panel->metric, &point)) {
            fprintf(page->file, "%c%.1f %.1f", command, x_of(panel, point.seconds),
                    y_of(panel, point.median));
            command = 'L';
        }
    fputs("\"/>\n", page->file);
}

static void put_point(const struct page *page, const struct panel *panel, const char *name,
                      int style, const struct point *point) {
    const double x = x_of(panel, point->seconds);
    char values[200], range[64] = "";
    if (point->most > point->least)
        snprintf(range, sizeof range, " (%.4g to %.4g)", point->least, point->most);
    snprintf(values, sizeof values, ", %d samples a pixel: %.3g s, %s %.4g%s", point->spp,
             point->seconds, panel->metric, point->median, range);
    if (point->most > point->least)
        fprintf(page->file, "<path class=\"spread m%d\" d=\"M%.1f %.1fV%.1f\"/>", style, x,
                y_of(panel, point->most), y_of(panel, point->least));
    fprintf(page->file,
            "<path class=\"point m%d\" tabindex=\"0\" role=\"img\" d=\"M%.1f %.1f%s\" "
            "aria-label=\"",
            style, x, y_of(panel, point->median), marker_of(style));
    html_text(page->file, legend_of(name));
    html_text(page->file, values);
    fputs("\"><title>", page->file);
    html_text(page->file, legend_of(name));
    html_text(page->file, values);
    fputs("</title></path>\n", page->file);
}

static void put_panel(const struct page *page, const json_t *methods, const char *metric) {
    struct panel panel = {.metric = metric};
    struct point point;
    if (!find_ranges(methods, &panel))
        return;
    fprintf(page->file,
            "<figure>\n<figcaption>%s</figcaption>\n<svg viewBox=\"0 0 %d %d\" role=\"group\" "
            "aria-label=\"%s against seconds of work\">\n",
            about(metric), WIDTH, HEIGHT, about(metric));
    put_axes(page, &panel);
    for (size_t m = json_array_size(methods); m-- > 0;) { /* ours over the others */
        const json_t *method = json_array_get(methods, m), *points = points_of(method);
        const int style = style_of(name_of(method), m);
        put_line(page, &panel, points, style);
        for (size_t i = 0; i < json_array_size(points); i++)
            if (read_point(json_array_get(points, i), metric, &point))
                put_point(page, &panel, name_of(method), style, &point);
    }
    fputs("</svg>\n<output aria-live=\"polite\"></output>\n</figure>\n", page->file);
}

static void put_methods(const struct page *page, const json_t *methods) {
    fputs("<ul class=\"methods\">\n", page->file);
    for (size_t m = 0; m < json_array_size(methods); m++) {
        const char *name = name_of(json_array_get(methods, m));
        const int style = style_of(name, m);
        fprintf(page->file,
                "<li><svg viewBox=\"0 0 44 14\" aria-hidden=\"true\"><path class=\"curve m%d%s\" "
                "style=\"fill:none\" d=\"M0 7h44\"/><path class=\"m%d\" d=\"M22 7%s\"/></svg>",
                style, is_dashed(style) ? " dashed" : "", style, marker_of(style));
        html_text(page->file, legend_of(name));
        fputs("</li>\n", page->file);
    }
    fputs("</ul>\n", page->file);
}

static bool has_metric(const json_t *methods, const char *metric) {
    struct panel panel = {.metric = metric};
    return find_ranges(methods, &panel);
}

void page_curves(const struct page *page) {
    const json_t *methods = json_object_get(page->bench, "methods"),
                 *settings = json_object_get(page->bench, "settings");
    const char *const metrics[] = {has_metric(methods, "mrse_net") ? "mrse_net" : "mrse_trimmed",
                                   "ssim_loss", "flip"};
    if (!json_is_array(methods))
        return;
    fputs("<section>\n<h2>Error against time</h2>\n", page->file);
    put_methods(page, methods);
    fputs("<div class=\"panels\">\n", page->file);
    for (int i = 0; i < 3; i++)
        put_panel(page, methods, metrics[i]);
    const int seeds = (int)fmin(fmax(number_of(settings, "seeds"), 0), 1e6);
    fprintf(page->file, "</div>\n<p class=\"note\">Points: medians of %d seed%s", seeds,
            seeds == 1 ? "" : "s");
    fputs(", bars: from the least to the most error, seconds: the least of the seeds. Both axes "
          "are logarithmic; lower is better, further left is sooner. OIDN: Open Image "
          "Denoise.</p>\n</section>\n\n",
          page->file);
}
