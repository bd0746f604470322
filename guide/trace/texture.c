/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluation of constant, checkerboard and bitmap textures. */

#include "guide/trace/texture.h"

#include "guide/trace/srgb_table.h"

static struct vec3 texel(const struct texture *t, int x, int y) {
    const struct fewray_image *image = t->image;
    size_t at = ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)image->channels;
    float c[3];
    for (int i = 0; i < 3; i++) {
        size_t k = at + (size_t)(image->channels >= 3 ? i : 0);
        if (image->floats)
            c[i] = image->floats[k];
        else
            c[i] =
                t->srgb ? srgb_to_linear[image->bytes[k]] : (float)image->bytes[k] * (1.0f / 255);
    }
    return vec(c[0], c[1], c[2]);
}

static int wrap(int i, int n) {
    i %= n;
    return i < 0 ? i + n : i;
}

static struct vec3 bitmap_value(const struct texture *t, float u, float v) {
    int w = t->image->width, h = t->image->height;
    u -= floorf(u);
    v -= floorf(v);
    if (t->nearest)
        return texel(t, wrap((int)(u * (float)w), w), wrap((int)(v * (float)h), h));
    float x = u * (float)w - 0.5f, y = v * (float)h - 0.5f;
    float fx = floorf(x), fy = floorf(y), wx = x - fx, wy = y - fy;
    int x0 = wrap((int)fx, w), x1 = wrap((int)fx + 1, w);
    int y0 = wrap((int)fy, h), y1 = wrap((int)fy + 1, h);
    struct vec3 top = add(scale(texel(t, x0, y0), 1 - wx), scale(texel(t, x1, y0), wx));
    struct vec3 bottom = add(scale(texel(t, x0, y1), 1 - wx), scale(texel(t, x1, y1), wx));
    return add(scale(top, 1 - wy), scale(bottom, wy));
}

struct vec3 texture_value(const struct texture *t, float u, float v) {
    if (t->kind == TEXTURE_CONSTANT)
        return t->color0;
    float s = t->to_uv[0] * u + t->to_uv[1] * v + t->to_uv[2];
    float r = t->to_uv[3] * u + t->to_uv[4] * v + t->to_uv[5];
    if (!isfinite(s) || !isfinite(r))
        s = r = 0;
    if (t->kind == TEXTURE_BITMAP)
        return bitmap_value(t, s, r);
    bool left = s - floorf(s) > 0.5f, low = r - floorf(r) > 0.5f;
    return left == low ? t->color0 : t->color1;
}
