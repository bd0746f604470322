/* SPDX-License-Identifier: Apache-2.0 */
/* Finds emitters where no layer tells of them. */

#include "denoise/emitters.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Surfaces of this albedo and more aren't black. */
#define BLACK_MAX 0.1f
/* Emitters have this many neighbours of nearly their own brightness: a corner has three. */
#define ALIKE_COUNT 3
#define ALIKE_RATIO 0.05f
/* Pixels around an emitter that may show parts of it, through bars say. */
#define REACH 3

struct view {
    const struct fewray_denoise_input *in;
    float bound; /* the irradiance of EMITTERS_IRRADIANCE_MAX, in the picture's unit */
};

static float value(const struct fewray_channels *layer, int c, int x, int y) {
    const float v = kpn_value(layer, c, y, x);
    return v > 0.0f ? fminf(v, 1e12f) : 0.0f; /* NaN: 0, too */
}

static float brightness(const struct view *view, int x, int y) {
    const struct fewray_channels *color = &view->in->color;
    return 0.2126f * value(color, 0, x, y) + 0.7152f * value(color, 1, x, y) +
           0.0722f * value(color, 2, x, y);
}

static float largest_albedo(const struct view *view, int x, int y) {
    const struct fewray_channels *albedo = &view->in->albedo;
    return fmaxf(value(albedo, 0, x, y), fmaxf(value(albedo, 1, x, y), value(albedo, 2, x, y)));
}

static bool inside(const struct view *view, int x, int y) {
    return x >= 0 && y >= 0 && x < view->in->width && y < view->in->height;
}

/* The brightness of an emitter; 0 where there is none, or none brighter than what a mirror shows.
 */
static float emitter_at(const struct view *view, int x, int y) {
    if (largest_albedo(view, x, y) >= KPN_ALBEDO_MIN)
        return 0.0f;
    const float own = brightness(view, x, y);
    int alike = 0;
    for (int v = y - 1; v <= y + 1; v++)
        for (int u = x - 1; u <= x + 1; u++)
            if (inside(view, u, v) && !(u == x && v == y))
                alike += fabsf(brightness(view, u, v) - own) <= ALIKE_RATIO * own;
    return own > view->bound / 2 && alike >= ALIKE_COUNT ? own : 0.0f;
}

/* The brightest emitter among the pixels at most radius away. */
static float emitter_near(const struct view *view, int x, int y, int radius) {
    float most = 0.0f;
    for (int v = y - radius; v <= y + radius; v++)
        for (int u = x - radius; u <= x + radius; u++)
            if (inside(view, u, v))
                most = fmaxf(most, emitter_at(view, u, v));
    return most;
}

/* The brightness that the pixel shares with at least two of its neighbours. */
static float shared_brightness(const struct view *view, int x, int y) {
    float first = 0, second = 0; /* of the neighbours */
    for (int v = y - 1; v <= y + 1; v++)
        for (int u = x - 1; u <= x + 1; u++)
            if (inside(view, u, v) && !(u == x && v == y)) {
                const float b = brightness(view, u, v);
                second = fmaxf(second, fminf(first, b));
                first = fmaxf(first, b);
            }
    return fminf(brightness(view, x, y), second);
}

/* What the albedo has to be at the least, so that the irradiance stays believable. */
static float least_albedo(const struct view *view, int x, int y) {
    const float blackness = 1.0f - largest_albedo(view, x, y) / BLACK_MAX;
    if (blackness <= 0.0f)
        return 0.0f;
    const float light = fminf(shared_brightness(view, x, y), emitter_near(view, x, y, REACH));
    return blackness * fminf(light / view->bound, 1.0f);
}

/* As struct emitters has it; 0: nothing to change. */
static float mark_of(const struct view *view, int x, int y) {
    const bool black = largest_albedo(view, x, y) < KPN_ALBEDO_MIN;
    const float emitter = black ? emitter_at(view, x, y) : emitter_near(view, x, y, 1);
    if (!(emitter > 0.0f))
        return least_albedo(view, x, y);
    const float own = brightness(view, x, y);
    return own > emitter ? -(emitter / own) : -1.0f; /* an outlier beside a lamp */
}

/* Without an emitter in reach nothing in a block changes, and few have one. */
static bool emitter_in_reach(const struct view *view, int y0, int x0) {
    for (int y = y0 - REACH; y < y0 + EMITTERS_BLOCK + REACH; y++)
        for (int x = x0 - REACH; x < x0 + EMITTERS_BLOCK + REACH; x++)
            if (inside(view, x, y) && emitter_at(view, x, y) > 0.0f)
                return true;
    return false;
}

/* False without memory. */
static bool find_in_block(const struct view *view, int row, int column, float **out) {
    float marks[EMITTERS_BLOCK * EMITTERS_BLOCK] = {0};
    const int y0 = row * EMITTERS_BLOCK, x0 = column * EMITTERS_BLOCK;
    bool any = false;
    if (!emitter_in_reach(view, y0, x0))
        return true;
    for (int y = y0; y < y0 + EMITTERS_BLOCK && y < view->in->height; y++)
        for (int x = x0; x < x0 + EMITTERS_BLOCK && x < view->in->width; x++) {
            const float mark = mark_of(view, x, y);
            marks[(y - y0) * EMITTERS_BLOCK + x - x0] = mark;
            any |= mark != 0.0f;
        }
    if (any && (*out = malloc(sizeof marks)))
        memcpy(*out, marks, sizeof marks);
    return !any || *out;
}

int emitters_find(const struct fewray_denoise_input *in, const struct kpn_scale *scale, int threads,
                  struct emitters *emitters, struct fewray_error *error) {
    *emitters = (struct emitters){
        .width = in->width,
        .columns = (in->width - 1) / EMITTERS_BLOCK + 1,
        .rows = (in->height - 1) / EMITTERS_BLOCK + 1,
        .bound = scale->exposure > 0.0f ? EMITTERS_IRRADIANCE_MAX / scale->exposure : 1e12f};
    const struct view view = {in, emitters->bound};
    int count = emitters->columns * emitters->rows;
    bool failed = !(emitters->blocks = calloc((size_t)count, sizeof *emitters->blocks));
    if (failed)
        count = 0;
#pragma omp parallel for num_threads(threads) schedule(dynamic) reduction(|| : failed)
    for (int i = 0; i < count; i++)
        if (!find_in_block(&view, i / emitters->columns, i % emitters->columns,
                           &emitters->blocks[i]))
            failed = true;
    return failed ? fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                                "no memory to look for emitters in the picture")
                  : FEWRAY_OK;
}

void emitters_clear(struct emitters *emitters) {
    for (int i = 0; emitters->blocks && i < emitters->columns * emitters->rows; i++)
        free(emitters->blocks[i]);
    free(emitters->blocks);
    emitters->blocks = NULL;
}

/* --- rows */

/* The marks of pixels (y, x0) up to *end, NULL where there are none. *end is at most `limit` and
 * the end of a block; all pixels beyond the right edge are of one piece. */
static const float *marks_from(const struct emitters *emitters, int y, int x0, int limit,
                               int *end) {
    const int x = x0 < emitters->width ? x0 : emitters->width - 1;
    const int column = x / EMITTERS_BLOCK, next = (column + 1) * EMITTERS_BLOCK;
    *end = column + 1 == emitters->columns || next > limit ? limit : next;
    const float *block = emitters->blocks[y / EMITTERS_BLOCK * emitters->columns + column];
    return block ? block + y % EMITTERS_BLOCK * EMITTERS_BLOCK - column * EMITTERS_BLOCK : NULL;
}

void emitters_raise_albedo(const struct emitters *emitters, int y, int x0, int count,
                           float *albedo) {
    for (int x = x0, end; x < x0 + count; x = end) {
        const float *marks = marks_from(emitters, y, x, x0 + count, &end);
        for (int i = x; marks && i < end; i++)
            albedo[i - x0] =
                fmaxf(albedo[i - x0], marks[i < emitters->width ? i : emitters->width - 1]);
    }
}

void emitters_add_emission(const struct emitters *emitters, const struct fewray_denoise_input *in,
                           int c, int y, int x0, int count, float *emission) {
    for (int x = x0, end; x < x0 + count; x = end) {
        const float *marks = marks_from(emitters, y, x, x0 + count, &end);
        for (int i = x; marks && i < end; i++) {
            const int u = i < emitters->width ? i : emitters->width - 1;
            if (marks[u] >= 0.0f)
                continue;
            const float color = value(&in->color, c, u, y) * -marks[u];
            const float reflected =
                fmaxf(value(&in->albedo, c, u, y), KPN_ALBEDO_MIN) * emitters->bound;
            emission[i - x0] = fmaxf(color - reflected, 0.0f);
        }
    }
}
