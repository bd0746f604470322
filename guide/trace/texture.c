/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluation of constant, checkerboard and bitmap textures. */

#include "guide/trace/texture.h"

#include "guide/trace/srgb_table.h"

/* The texels around a point, and its place between them. */
struct footprint {
    int x[2], y[2];
    float wx, wy;
};

/* One channel of the texel whose values start at `at`. */
static float texel_channel(const struct texture *t, size_t at, int channel) {
    const struct fewray_image *image = t->image;
    int last = image->channels - 1;
    bool alpha = channel == 3;
    if (alpha && last < 3)
        return 1;
    at += (size_t)(channel < last ? channel : last);
    if (image->floats)
        return image->floats[at];
    return t->srgb && !alpha ? srgb_to_linear[image->bytes[at]]
                             : (float)image->bytes[at] * (1.0f / 255);
}

static struct vec3 texel(const struct texture *t, int x, int y) {
    const struct fewray_image *image = t->image;
    size_t at = ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)image->channels;
    if (t->channel >= 0) {
        float grey = texel_channel(t, at, t->channel);
        return vec(grey, grey, grey);
    }
    if (image->channels < 3)
        return scale(vec(1, 1, 1), texel_channel(t, at, 0));
    return vec(texel_channel(t, at, 0), texel_channel(t, at, 1), texel_channel(t, at, 2));
}

/* A coordinate that shows the same, near the picture: its texels' numbers must fit an int. */
static float wrap_coordinate(float u, enum texture_wrap mode) {
    switch (mode) {
    case WRAP_MIRROR:
        return u - 2 * floorf(u * 0.5f);
    case WRAP_CLAMP:
        return u > 0 ? (u < 1 ? u : 1) : 0;
    default:
        return u - floorf(u);
    }
}

static int wrap_index(int i, int n, enum texture_wrap mode) {
    if (mode == WRAP_CLAMP)
        return i < 0 ? 0 : (i < n ? i : n - 1);
    int period = mode == WRAP_MIRROR ? 2 * n : n;
    i %= period;
    i = i < 0 ? i + period : i;
    return i < n ? i : period - 1 - i;
}

static struct footprint find_footprint(const struct texture *t, float u, float v) {
    int w = t->image->width, h = t->image->height;
    float offset = t->nearest ? 0 : 0.5f;
    float x = wrap_coordinate(u, t->wrap) * (float)w - offset;
    float y = wrap_coordinate(v, t->wrap) * (float)h - offset;
    float fx = floorf(x), fy = floorf(y);
    struct footprint f = {.wx = x - fx, .wy = y - fy};
    for (int i = 0; i < 2; i++) {
        f.x[i] = wrap_index((int)fx + i, w, t->wrap);
        f.y[i] = wrap_index((int)fy + i, h, t->wrap);
    }
    return f;
}

static struct vec3 bitmap_value(const struct texture *t, float u, float v) {
    struct footprint f = find_footprint(t, u, v);
    if (t->nearest)
        return mul(texel(t, f.x[0], f.y[0]), t->factor);
    struct vec3 top =
        add(scale(texel(t, f.x[0], f.y[0]), 1 - f.wx), scale(texel(t, f.x[1], f.y[0]), f.wx));
    struct vec3 bottom =
        add(scale(texel(t, f.x[0], f.y[1]), 1 - f.wx), scale(texel(t, f.x[1], f.y[1]), f.wx));
    return mul(add(scale(top, 1 - f.wy), scale(bottom, f.wy)), t->factor);
}

static void transform_uv(const struct texture *t, float u, float v, float out[2]) {
    out[0] = t->to_uv[0] * u + t->to_uv[1] * v + t->to_uv[2];
    out[1] = t->to_uv[3] * u + t->to_uv[4] * v + t->to_uv[5];
    if (!isfinite(out[0]) || !isfinite(out[1]))
        out[0] = out[1] = 0;
}

struct vec3 texture_value(const struct texture *t, float u, float v) {
    if (t->kind == TEXTURE_CONSTANT)
        return t->color0;
    float uv[2];
    transform_uv(t, u, v, uv);
    if (t->kind == TEXTURE_BITMAP)
        return bitmap_value(t, uv[0], uv[1]);
    bool left = uv[0] - floorf(uv[0]) > 0.5f, low = uv[1] - floorf(uv[1]) > 0.5f;
    return left == low ? t->color0 : t->color1;
}

void texture_gradient(const struct texture *t, float u, float v, float gradient[2]) {
    gradient[0] = gradient[1] = 0;
    if (t->kind != TEXTURE_BITMAP || t->nearest)
        return;
    float uv[2], grey[2][2];
    transform_uv(t, u, v, uv);
    struct footprint f = find_footprint(t, uv[0], uv[1]);
    for (int i = 0; i < 4; i++)
        grey[i / 2][i % 2] = luminance(mul(texel(t, f.x[i % 2], f.y[i / 2]), t->factor));
    float dx = (1 - f.wy) * (grey[0][1] - grey[0][0]) + f.wy * (grey[1][1] - grey[1][0]);
    float dy = (1 - f.wx) * (grey[1][0] - grey[0][0]) + f.wx * (grey[1][1] - grey[0][1]);
    dx *= (float)t->image->width;
    dy *= (float)t->image->height;
    gradient[0] = dx * t->to_uv[0] + dy * t->to_uv[3];
    gradient[1] = dx * t->to_uv[1] + dy * t->to_uv[4];
}
