/* SPDX-License-Identifier: Apache-2.0 */
/* The patterns of the generated textures. */

#include "guide/train/scenes/picture.h"

#include <stdlib.h>

#include "guide/train/scenes/noise.h"

struct picture picture_random(struct random *r, enum picture_kind kind, struct vec3 color,
                              struct vec3 other) {
    struct picture picture = {.kind = kind, .seed = random_bits(r)};
    picture.colors[0] = color;
    picture.colors[1] = other;
    for (int i = 2; i < PICTURE_COLORS; i++) {
        float t = uniform(r, 0, 1);
        struct vec3 blend = add(scale(color, t), scale(other, 1 - t));
        picture.colors[i] = scale(blend, uniform(r, 0.4f, 1));
    }
    static const int least[PICTURE_KINDS] = {2, 48, 1, 3, 2, 2, 2, 3, 2, 8};
    static const int most[PICTURE_KINDS] = {10, 128, 5, 12, 12, 24, 10, 16, 5, 22};
    picture.cells_u = between(r, least[kind], most[kind]);
    picture.cells_v = chance(r, 0.5f) ? picture.cells_u : between(r, least[kind], most[kind]);
    if (kind == PICTURE_BRICKS)
        picture.cells_v = 2 * between(r, 2, 10); /* whole bonds */
    picture.sharpness = uniform(r, 0, 1);
    return picture;
}

static struct vec3 mix(struct vec3 a, struct vec3 b, float t) {
    return add(scale(a, 1 - t), scale(b, t));
}

static float smooth_edge(float low, float high, float x) {
    float t = fminf(1, fmaxf(0, (x - low) / (high - low)));
    return t * t * (3 - 2 * t);
}

/* 0..1 and bound to a cell. */
static float cell_random(const struct picture *p, int x, int y, int salt) {
    return noise_lattice(p->seed, x, y, 1000 + salt);
}

static struct vec3 clouds(const struct picture *p, float u, float v) {
    float n = noise_tileable(p->seed, u, v, p->cells_u, p->cells_v, 5);
    float m = noise_tileable(p->seed + 50, u, v, p->cells_v, p->cells_u, 4);
    float half = 0.5f - 0.42f * p->sharpness;
    float t = smooth_edge(0.5f - half, 0.5f + half, n);
    return mix(mix(p->colors[0], p->colors[1], t), p->colors[2], 0.5f * m * m);
}

static struct vec3 grain(const struct picture *p, float u, float v) {
    float n = noise_tileable(p->seed, u, v, p->cells_u, p->cells_v, 2);
    return mix(p->colors[0], p->colors[1], smooth_edge(0.2f, 0.8f, n));
}

/* Planks along u; rings are distances to a stem's axis that runs nearly along the plank. */
static struct vec3 wood(const struct picture *p, float u, float v) {
    int plank = (int)(v * (float)p->cells_v) % p->cells_v;
    float across = v * (float)p->cells_v - floorf(v * (float)p->cells_v);
    float shift = cell_random(p, plank, 0, 0), shade = cell_random(p, plank, 0, 1);
    float wobble = noise_tileable(p->seed + (uint32_t)plank * 7, u, v, 3, 4 * p->cells_v, 3);
    float y = across - 0.5f + 2 * (shift - 0.5f), z = 0.15f + 0.4f * wobble;
    float ring = sqrtf(y * y + z * z) * (8 + 14 * p->sharpness);
    float t = ring - floorf(ring);
    float fiber = noise_tileable(p->seed + 90, u, v, 6, 128, 2);
    struct vec3 color = mix(p->colors[0], p->colors[1], 0.8f * t * t + 0.2f * fiber);
    color = scale(color, 0.75f + 0.25f * shade);
    float joint = fminf(across, 1 - across) / (float)p->cells_v;
    return p->cells_v > 1 && joint < 0.004f ? scale(color, 0.35f) : color;
}

/* Bricks and tiles: shade of the cell, joints of colour 3. */
static struct vec3 cells(const struct picture *p, float u, float v, bool bond) {
    float y = v * (float)p->cells_v;
    int row = (int)y % p->cells_v;
    float x = u * (float)p->cells_u + (bond && row % 2 ? 0.5f : 0);
    int column = (int)x % p->cells_u;
    float fx = x - floorf(x), fy = y - floorf(y);
    float edge =
        fminf(fminf(fx, 1 - fx) / (float)p->cells_u, fminf(fy, 1 - fy) / (float)p->cells_v);
    float width = 0.002f + 0.012f * p->sharpness;
    float shade = cell_random(p, column, row, 0);
    float stain = noise_tileable(p->seed + 9, u, v, 16, 16, 4);
    struct vec3 color = bond ? mix(p->colors[0], p->colors[1], 0.6f * shade)
                             : p->colors[(column + row) % 2 * (int)(p->seed % 2)];
    color = scale(color, 0.7f + 0.15f * shade + 0.15f * stain);
    return mix(p->colors[3], color, smooth_edge(width * 0.6f, width, edge));
}

/* Colours of stripes whose widths vary along x in 0..1. */
static struct vec3 stripe(const struct picture *p, float x, int count, int salt) {
    float at = x * (float)count;
    int band = (int)at % count;
    float width = 0.25f + 0.5f * cell_random(p, band % 3, 0, salt);
    bool first = at - floorf(at) < width;
    int color = first ? 0 : 1 + (int)(2.99f * cell_random(p, band % 4, 1, salt));
    return p->colors[color];
}

static struct vec3 plaid(const struct picture *p, float u, float v) {
    struct vec3 a = stripe(p, u, p->cells_u, 0), b = stripe(p, v, p->cells_v, 5);
    int thread = (int)(u * PICTURE_SIZE / 2) + (int)(v * PICTURE_SIZE / 2);
    return mix(a, b, thread % 2 ? 0.35f : 0.65f);
}

static struct vec3 dots(const struct picture *p, float u, float v) {
    float x = u * (float)p->cells_u, y = v * (float)p->cells_v;
    int column = (int)x % p->cells_u, row = (int)y % p->cells_v;
    float dx = x - floorf(x) - 0.5f, dy = y - floorf(y) - 0.5f;
    float radius = 0.15f + 0.3f * cell_random(p, column, row, 0) * p->sharpness;
    int color = 1 + (int)(2.99f * cell_random(p, column, row, 1));
    return dx * dx + dy * dy < radius * radius ? p->colors[color] : p->colors[0];
}

/* Veins where a turned and bent sine crosses zero. */
static struct vec3 marble(const struct picture *p, float u, float v) {
    float bend = noise_tileable(p->seed, u, v, p->cells_u, p->cells_v, 6) - 0.5f;
    float wave = sinf(2 * PI_F * ((float)p->cells_u * u + (float)p->cells_v * v + 3 * bend));
    float vein = expf(-fabsf(wave) * (3 + 12 * p->sharpness));
    float cloud = noise_tileable(p->seed + 20, u, v, 2, 2, 5);
    struct vec3 ground = mix(p->colors[0], scale(p->colors[0], 0.7f), cloud);
    return mix(ground, p->colors[1], 0.85f * vein);
}

/* Glyphs of 3 x 5 random dots in words, paragraphs and ragged lines. */
static struct vec3 text(const struct picture *p, float u, float v) {
    int lines = p->cells_v, letters = 2 * p->cells_v;
    float x = u * (float)letters, y = v * (float)lines;
    int letter = (int)x, line = (int)y;
    float fx = x - (float)letter, fy = y - (float)line;
    float end = 0.55f + 0.4f * cell_random(p, 0, line, 0);
    bool heading = line % 7 == 0, blank = line % 7 == 1 || cell_random(p, letter, line, 1) < 0.16f;
    if (blank || u < 0.06f || u > (heading ? end * 0.6f : end) || fx > 0.8f || fy > 0.72f)
        return p->colors[0];
    int dot_x = (int)(fx / 0.8f * 3), dot_y = (int)(fy / 0.72f * 5);
    bool ink = cell_random(p, letter * 4 + dot_x, line * 6 + dot_y, 2) < (heading ? 0.8f : 0.55f);
    return ink ? p->colors[heading ? 2 : 1] : p->colors[0];
}

/* Linear reflectance at u, v in 0..1. */
static struct vec3 color_at(const struct picture *p, float u, float v) {
    switch (p->kind) {
    case PICTURE_GRAIN:
        return grain(p, u, v);
    case PICTURE_WOOD:
        return wood(p, u, v);
    case PICTURE_BRICKS:
        return cells(p, u, v, true);
    case PICTURE_TILES:
        return cells(p, u, v, false);
    case PICTURE_STRIPES:
        return stripe(p, u, p->cells_u, 0);
    case PICTURE_PLAID:
        return plaid(p, u, v);
    case PICTURE_DOTS:
        return dots(p, u, v);
    case PICTURE_MARBLE:
        return marble(p, u, v);
    case PICTURE_TEXT:
        return text(p, u, v);
    default:
        return clouds(p, u, v);
    }
}

static uint8_t to_srgb(float linear) {
    float x = fminf(0.92f, fmaxf(0, linear));
    float encoded = x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
    return (uint8_t)(255 * encoded + 0.5f);
}

int picture_write(const struct picture *picture, const char *path, struct fewray_error *error) {
    uint8_t *rgb = malloc(3 * PICTURE_SIZE * PICTURE_SIZE);
    if (!rgb)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    for (int i = 0; i < PICTURE_SIZE * PICTURE_SIZE; i++) {
        float u = ((float)(i % PICTURE_SIZE) + 0.5f) / PICTURE_SIZE,
              v = ((float)(i / PICTURE_SIZE) + 0.5f) / PICTURE_SIZE;
        struct vec3 color = color_at(picture, u, v);
        rgb[3 * i] = to_srgb(color.x);
        rgb[3 * i + 1] = to_srgb(color.y);
        rgb[3 * i + 2] = to_srgb(color.z);
    }
    int status = fewray_image_write_png(path, PICTURE_SIZE, PICTURE_SIZE, rgb, error);
    free(rgb);
    return status;
}
