/* SPDX-License-Identifier: Apache-2.0 */
/* Tells what moves otherwise than the surface: reflections, shadows of things that move, lamps that
 * are switched. Over windows of pixels the newest frame is compared with the frames before, in
 * units of the standard error that the noisy frames' difference would have. */

#include <math.h>
#include <omp.h>

#include "denoise/input_rows.h"
#include "denoise/temporal.h"

enum { RADIUS_WIDE = 3, RADIUS_NARROW = 1 };
/* Interpolation errs by so much of the light; finer differences are no reason to start anew. */
#define SETTLED 0.03f

enum { DIFFERENCE, VARIANCE, LIGHT, COUNT, PLANES };

static float luminance_of(const float v[3]) {
    return luminance(v[0], v[1], v[2]);
}

/* Of a luminance whose channels go together, as noise of light does. */
static float luminance_variance(const float v[3]) {
    const float deviation = luminance(sqrtf(v[0]), sqrtf(v[1]), sqrtf(v[2]));
    return deviation * deviation;
}

/* The difference, and its variance. A frame that missed a rare bright path also thinks that there
 * is no noise; what the frames before knew of it counts as well. */
static void compare(const struct temporal_pixel *now, const struct temporal_pixel *warped,
                    float out[PLANES]) {
    for (int k = 0; k < PLANES; k++)
        out[k] = 0;
    if (!(warped->frames > 0))
        return;
    const float past = luminance_variance(warped->variance);
    out[DIFFERENCE] = luminance_of(now->light) - luminance_of(warped->light);
    out[VARIANCE] = past + fmaxf(luminance_variance(now->variance), past * warped->frames);
    out[LIGHT] = fmaxf(luminance_of(now->light), luminance_of(warped->light));
    out[COUNT] = 1;
}

/* |mean difference| over its standard error, in a window around (x, y). */
static float score(const float *planes, size_t pixels, int width, int height, int x, int y,
                   int radius) {
    float sums[PLANES] = {0};
    const int x0 = x > radius ? x - radius : 0, x1 = x + radius < width ? x + radius : width - 1;
    const int y0 = y > radius ? y - radius : 0, y1 = y + radius < height ? y + radius : height - 1;
    for (int k = 0; k < PLANES; k++)
        for (int j = y0; j <= y1; j++) {
            const float *row = planes + (size_t)k * pixels + (size_t)j * (size_t)width;
            for (int i = x0; i <= x1; i++)
                sums[k] += row[i];
        }
    const float settled = SETTLED * sums[LIGHT];
    const float variance = sums[VARIANCE] + settled * settled;
    return variance > 0 ? fabsf(sums[DIFFERENCE]) / sqrtf(variance) : 0;
}

void temporal_trust(const struct temporal_pixel *now, struct temporal_pixel *warped, int width,
                    int height, float sigmas, int threads, float *scratch) {
    const size_t pixels = (size_t)width * (size_t)height;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < pixels; i++) {
        float values[PLANES];
        compare(&now[i], &warped[i], values);
        for (int k = 0; k < PLANES; k++)
            scratch[(size_t)k * pixels + i] = values[k];
    }
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            struct temporal_pixel *pixel = &warped[(size_t)y * (size_t)width + (size_t)x];
            if (!(pixel->frames > 0))
                continue;
            const float worst = fmaxf(score(scratch, pixels, width, height, x, y, RADIUS_WIDE),
                                      score(scratch, pixels, width, height, x, y, RADIUS_NARROW));
            /* From the threshold to its double less and less is believed. */
            pixel->frames *= fminf(1, fmaxf(0, 2 - worst / sigmas));
        }
}
