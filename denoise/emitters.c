/* SPDX-License-Identifier: Apache-2.0 */
/* Finds emitters where no layer tells of them. */

#include "denoise/emitters.h"

#include <math.h>

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
    const float v = layer->channel[c][y * layer->row_stride + x * layer->pixel_stride];
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

static void split_pixel(const struct view *view, int x, int y, float *albedo, float *emission) {
    const bool black = largest_albedo(view, x, y) < KPN_ALBEDO_MIN;
    const float emitter = black ? emitter_at(view, x, y) : emitter_near(view, x, y, 1);
    const float least = emitter > 0.0f ? 0.0f : least_albedo(view, x, y);
    const float own = brightness(view, x, y);
    const float share = own > emitter ? emitter / own : 1.0f; /* an outlier beside a lamp */
    for (int c = 0; c < 3; c++) {
        const float a = value(&view->in->albedo, c, x, y);
        const float color = value(&view->in->color, c, x, y) * share;
        albedo[c] = fmaxf(a, least);
        emission[c] =
            emitter > 0.0f ? fmaxf(color - fmaxf(a, KPN_ALBEDO_MIN) * view->bound, 0.0f) : 0.0f;
    }
}

void emitters_find(const struct fewray_denoise_input *in, const struct kpn_scale *scale,
                   int threads, float *albedo, float *emission) {
    const struct view view = {in, scale->exposure > 0.0f ? EMITTERS_IRRADIANCE_MAX / scale->exposure
                                                         : 1e12f};
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int y = 0; y < in->height; y++)
        for (int x = 0; x < in->width; x++) {
            const size_t i = 3 * ((size_t)y * (size_t)in->width + (size_t)x);
            split_pixel(&view, x, y, albedo + i, emission + i);
        }
}
