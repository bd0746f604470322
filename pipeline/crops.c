/* SPDX-License-Identifier: Apache-2.0 */
/* Crop places by three scores, each summed over the crop through a summed-area table (Crow 1984).
 */

#include "pipeline/crops.h"

#include <math.h>
#include <stdlib.h>

struct pictures {
    const uint8_t *noisy, *denoised, *target;
    int width, height;
};

static double difference(const uint8_t *a, const uint8_t *b) {
    return abs(a[0] - b[0]) + abs(a[1] - b[1]) + abs(a[2] - b[2]);
}

/* Change from a pixel of the target to its left and upper neighbours. */
static double detail(const struct pictures *in, int x, int y) {
    const uint8_t *pixel = in->target + 3 * ((size_t)y * in->width + x);
    double sum = 0;
    if (x > 0)
        sum += difference(pixel, pixel - 3);
    if (y > 0)
        sum += difference(pixel, pixel - 3 * (size_t)in->width);
    return sum;
}

static double score(const struct pictures *in, int kind, int x, int y) {
    const size_t i = 3 * ((size_t)y * in->width + x);
    switch (kind) {
    case 0:
        return difference(in->denoised + i, in->target + i);
    case 1:
        return sqrt(difference(in->noisy + i, in->denoised + i) * detail(in, x, y));
    default:
        return detail(in, x, y);
    }
}

/* table: (height + 1, width + 1); entry (x, y) is the sum of the scores left of x and above y. */
static void fill_table(const struct pictures *in, int kind, double *table) {
    const size_t stride = (size_t)in->width + 1;
    for (size_t x = 0; x < stride; x++)
        table[x] = 0;
    for (int y = 0; y < in->height; y++) {
        double *row = table + ((size_t)y + 1) * stride, sum = 0;
        row[0] = 0;
        for (int x = 0; x < in->width; x++) {
            sum += score(in, kind, x, y);
            row[x + 1] = row[(ptrdiff_t)(x + 1) - (ptrdiff_t)stride] + sum;
        }
    }
}

static double table_sum(const double *table, int width, int x, int y, int w, int h) {
    const size_t stride = (size_t)width + 1;
    const double *top = table + (size_t)y * stride, *bottom = table + (size_t)(y + h) * stride;
    return bottom[x + w] - bottom[x] - top[x + w] + top[x];
}

/* Nor side by side: three places should show three things. */
static bool crowds(const struct fewray_crop *crop, int x, int y) {
    return abs(crop->x - x) < 2 * crop->width && abs(crop->y - y) < 2 * crop->height;
}

/* The best place that is free of the earlier crops; the middle where there is none. */
static struct fewray_crop best_place(const struct pictures *in, const double *table, int w, int h,
                                     const struct fewray_crop *taken, int taken_count) {
    struct fewray_crop best = {(in->width - w) / 2, (in->height - h) / 2, w, h};
    double most = -1;
    const int step_x = w > 16 ? w / 16 : 1, step_y = h > 16 ? h / 16 : 1;
    for (int y = 0; y + h <= in->height; y += step_y)
        for (int x = 0; x + w <= in->width; x += step_x) {
            bool is_free = true;
            for (int i = 0; i < taken_count && is_free; i++)
                is_free = !crowds(&taken[i], x, y);
            const double sum = is_free ? table_sum(table, in->width, x, y, w, h) : -1;
            if (sum > most) {
                most = sum;
                best.x = x;
                best.y = y;
            }
        }
    return best;
}

bool crops_pick(const uint8_t *noisy, const uint8_t *denoised, const uint8_t *target, int width,
                int height, int crop_width, int crop_height,
                struct fewray_crop crops[FEWRAY_CROPS]) {
    const struct pictures in = {noisy, denoised, target, width, height};
    double *table = malloc(sizeof(double) * ((size_t)width + 1) * ((size_t)height + 1));
    if (!table)
        return false;
    for (int i = 0; i < FEWRAY_CROPS; i++) {
        fill_table(&in, i == 0 && denoised == target ? 1 : i,
                   table); /* no reference: no error to look for */
        crops[i] = best_place(&in, table, crop_width, crop_height, crops, i);
    }
    free(table);
    return true;
}
