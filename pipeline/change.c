/* SPDX-License-Identifier: Apache-2.0 */
/* The estimate of a picture's error from what the last samples changed. */

#include "pipeline/change.h"

#include <math.h>
#include <stdlib.h>

#include "fewray/guide.h"
#include "pipeline/plan.h"

#define DARK_SQUARED 0.01 /* as in mrse: (x - r)^2 / (r^2 + 0.01) */
#define CELL_MOST    1.0  /* a cell's error for the dealing of samples: one firefly isn't all */
#define LEVEL_RADIUS 2    /* pixels; whose mean stands for the brightness of a noisy pixel */

int change_create(int width, int height, struct change **out, struct fewray_error *error) {
    struct change *change = *out = calloc(1, sizeof *change);
    if (change) {
        const int columns = (width + PLAN_CELL - 1) / PLAN_CELL;
        const int rows = (height + PLAN_CELL - 1) / PLAN_CELL;
        *change = (struct change){.width = width,
                                  .height = height,
                                  .columns = columns,
                                  .rows = rows,
                                  .tile_columns = (width + FEWRAY_TILE_SIZE - 1) / FEWRAY_TILE_SIZE,
                                  .tile_rows = (height + FEWRAY_TILE_SIZE - 1) / FEWRAY_TILE_SIZE,
                                  .error = -1};
        change->before = malloc((size_t)width * (size_t)height * 3 * sizeof *change->before);
        change->tile_before = calloc((size_t)change->tile_columns * (size_t)change->tile_rows,
                                     sizeof *change->tile_before);
        change->cells = calloc((size_t)columns * (size_t)rows, sizeof *change->cells);
    }
    if (change && change->before && change->tile_before && change->cells)
        return FEWRAY_OK;
    change_destroy(out);
    return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the plan of samples");
}

void change_destroy(struct change **change) {
    if (!*change)
        return;
    free((*change)->before);
    free((*change)->tile_before);
    free((*change)->cells);
    free(*change);
    *change = NULL;
}

/* Mean of a plane around a pixel. */
static double level_at(const struct change *change, const float *plane, int x, int y) {
    double sum = 0;
    int count = 0;
    for (int v = y - LEVEL_RADIUS; v <= y + LEVEL_RADIUS; v++)
        for (int u = x - LEVEL_RADIUS; u <= x + LEVEL_RADIUS; u++)
            if (u >= 0 && v >= 0 && u < change->width && v < change->height) {
                sum += plane[(size_t)v * (size_t)change->width + (size_t)u];
                count++;
            }
    return sum / count;
}

/* Mean relative squared difference of a cell's pixels to the picture before. */
static double cell_change(const struct change *change, float *const planes[3], bool denoised,
                          int cell_x, int cell_y) {
    const size_t pixels = (size_t)change->width * (size_t)change->height;
    double sum = 0;
    int count = 0;
    for (int y = cell_y * PLAN_CELL; y < (cell_y + 1) * PLAN_CELL && y < change->height; y++)
        for (int x = cell_x * PLAN_CELL; x < (cell_x + 1) * PLAN_CELL && x < change->width; x++)
            for (int c = 0; c < 3; c++) {
                const size_t i = (size_t)y * (size_t)change->width + (size_t)x;
                const double now = planes[c][i];
                const double difference = now - change->before[(size_t)c * pixels + i];
                const double level = denoised ? now : level_at(change, planes[c], x, y);
                sum += difference * difference / (level * level + DARK_SQUARED);
                count++;
            }
    return sum / count;
}

/* Error of a cell now, and what is to be kept of it in change->cells. */
static double cell_error(struct change *change, float *const planes[3], const int *tile_samples,
                         bool denoised, int x, int y) {
    float *known = &change->cells[(size_t)y * (size_t)change->columns + (size_t)x];
    const size_t tile = (size_t)(y * PLAN_CELL / FEWRAY_TILE_SIZE) * (size_t)change->tile_columns +
                        (size_t)(x * PLAN_CELL / FEWRAY_TILE_SIZE);
    const double samples = tile_samples[tile] > 1 ? tile_samples[tile] : 1;
    const double growth = pow(samples, PLAN_SLOPE);
    const double before = change->tile_before[tile];
    const double factor = plan_change_factor(before, samples);
    if (factor <= 0 && change->count > 1)
        return *known / growth;
    /* few new samples tell little: less than a doubling counts less than what was known */
    const double weight = change->count > 1 ? fmin(samples / before - 1, 1) : 1;
    const double fresh = cell_change(change, planes, denoised, x, y) * (factor > 0 ? factor : 1);
    const double error = weight * fresh + (1 - weight) * *known / growth;
    const double kept = 0.5 * weight; /* half of a doubling's, as the change is a noisy measure */
    *known =
        (float)(change->count > 1 ? kept * fmin(fresh, CELL_MOST) * growth + (1 - kept) * *known
                                  : fmin(fresh, CELL_MOST) * growth);
    return error;
}

void change_see(struct change *change, const struct fewray_frame *frame, const int *tile_samples,
                bool denoised) {
    float *planes[3];
    fewray_frame_layer(frame, FEWRAY_COLOR, planes);
    const size_t pixels = (size_t)change->width * (size_t)change->height;
    double sum = 0;
    for (int y = 0; y < change->rows && change->count > 0; y++)
        for (int x = 0; x < change->columns; x++)
            sum += cell_error(change, planes, tile_samples, denoised, x, y);
    double samples = 0;
    for (int t = 0; t < change->tile_columns * change->tile_rows; t++)
        samples += tile_samples[t];
    samples /= (double)change->tile_columns * change->tile_rows;
    const double unseen = CHANGE_BIAS * pow(fmax(samples, 4) / 4, CHANGE_GROWTH);
    if (change->count > 0)
        change->error = (denoised ? unseen : 1) * sum / ((double)change->columns * change->rows);
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < pixels; i++)
            change->before[(size_t)c * pixels + i] = planes[c][i];
    for (int t = 0; t < change->tile_columns * change->tile_rows; t++)
        change->tile_before[t] = tile_samples[t];
    change->count++;
}
