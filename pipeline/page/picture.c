/* SPDX-License-Identifier: Apache-2.0 */
/* Planes to the PNGs of the page. What is too wide is averaged over areas: light in what a display
 * can show, so that a bright pixel spreads no further than its place; errors as they are, so that
 * the map's mean stays the metric. */

#include <math.h>
#include <stdlib.h>

#include "features/png.h"
#include "pipeline/display.h"
#include "pipeline/page/page.h"

struct page_size page_shown_size(int width, int height, int max_width) {
    if (width <= max_width)
        return (struct page_size){width, height};
    const int scaled = (int)lround((double)height * max_width / width);
    return (struct page_size){max_width, scaled > 0 ? scaled : 1};
}

static int fail_memory(struct fewray_error *error) {
    return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for a picture of the page");
}

/* The mean of the row from x0 to x1, in pixels. */
static double mean_of_row(const float *row, int width, double x0, double x1) {
    double sum = 0;
    for (int x = (int)x0; x < width && x < x1; x++)
        sum += row[x] * (fmin(x + 1, x1) - fmax(x, x0));
    return sum / (x1 - x0);
}

/* The mean over the area that a shown pixel covers. */
static double mean_of_area(const float *plane, int width, int height, struct page_size shown, int x,
                           int y) {
    if (shown.width == width && shown.height == height)
        return plane[(size_t)y * (size_t)width + (size_t)x];
    const double x0 = (double)x * width / shown.width, x1 = (x + 1.0) * width / shown.width,
                 y0 = (double)y * height / shown.height, y1 = (y + 1.0) * height / shown.height;
    double sum = 0;
    for (int row = (int)y0; row < height && row < y1; row++)
        sum += mean_of_row(plane + (size_t)row * (size_t)width, width, x0, x1) *
               (fmin(row + 1, y1) - fmax(row, y0));
    return sum / (y1 - y0);
}

int page_show(float *const planes[3], int width, int height, float exposure, struct page_size shown,
              void **png, size_t *bytes, struct fewray_error *error) {
    const size_t count = (size_t)width * (size_t)height;
    const double scale = exp2(exposure);
    float *light = malloc(count * sizeof *light);
    uint8_t *rgb = malloc(3 * (size_t)shown.width * (size_t)shown.height);
    int status = light && rgb ? FEWRAY_OK : fail_memory(error);
    for (int c = 0; c < 3 && !status; c++) {
        for (size_t i = 0; i < count; i++)
            light[i] = planes[c][i] > 0 ? (float)fmin(scale * planes[c][i], 1) : 0;
        for (int y = 0; y < shown.height; y++)
            for (int x = 0; x < shown.width; x++)
                rgb[3 * ((size_t)y * (size_t)shown.width + (size_t)x) + (size_t)c] =
                    display_byte(mean_of_area(light, width, height, shown, x, y));
    }
    if (!status)
        status = png_encode("report", shown.width, shown.height, rgb, png, bytes, error);
    free(light);
    free(rgb);
    return status;
}

/* As the metrics see it: where r isn't finite nothing is judged, where x isn't it counts as
 * 2 r + 1. */
static double squared_error(float *const x[3], float *const r[3], size_t i) {
    bool finite = true;
    for (int c = 0; c < 3; c++) {
        if (!isfinite(r[c][i]))
            return 0;
        finite = finite && isfinite(x[c][i]);
    }
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        const double difference = finite ? (double)x[c][i] - r[c][i] : (double)r[c][i] + 1;
        sum += difference * difference / ((double)r[c][i] * r[c][i] + 0.01);
    }
    return sum / 3;
}

static uint8_t heat_of(double error) {
    const double place =
        log(fmax(error, 1e-30) / PAGE_HEAT_LEAST) / log(PAGE_HEAT_MOST / PAGE_HEAT_LEAST);
    return (uint8_t)(255 * fmin(fmax(place, 0), 1) + 0.5);
}

int page_error_map(float *const x[3], float *const r[3], int width, int height,
                   struct page_size shown, const uint8_t palette[256 * 3], void **png,
                   size_t *bytes, struct fewray_error *error) {
    const size_t count = (size_t)width * (size_t)height;
    float *errors = malloc(count * sizeof *errors);
    uint8_t *heat = malloc((size_t)shown.width * (size_t)shown.height);
    int status = errors && heat ? FEWRAY_OK : fail_memory(error);
    for (size_t i = 0; i < count && !status; i++)
        errors[i] = (float)fmin(squared_error(x, r, i), 1e30);
    for (int row = 0; row < shown.height && !status; row++)
        for (int column = 0; column < shown.width; column++)
            heat[(size_t)row * (size_t)shown.width + (size_t)column] =
                heat_of(mean_of_area(errors, width, height, shown, column, row));
    if (!status)
        status = png_encode_indexed("report", shown.width, shown.height, heat, palette, png, bytes,
                                    error);
    free(errors);
    free(heat);
    return status;
}
