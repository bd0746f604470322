/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_DENOISE_ROOM_H
#define FEWRAY_TESTS_DENOISE_ROOM_H

/* A made-up noisy picture with all layers, and the denoiser run on it. */

#include <string.h>

#include "fewray/denoise.h"
#include "tests/unit/check.h"

/* Interleaved layers of a picture. */
struct picture {
    int width, height;
    float *color, *variance, *albedo, *normal, *emission, *depth, *out;
};

static inline float uniform(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * 0x1p-24f;
}

static inline float *layer(const struct picture *p, int channels) {
    return calloc((size_t)p->width * (size_t)p->height * (size_t)channels, sizeof(float));
}

static inline struct picture picture_new(int width, int height) {
    struct picture p = {.width = width, .height = height};
    p.color = layer(&p, 3);
    p.variance = layer(&p, 3);
    p.albedo = layer(&p, 3);
    p.normal = layer(&p, 3);
    p.emission = layer(&p, 3);
    p.depth = layer(&p, 1);
    p.out = layer(&p, 3);
    return p;
}

static inline void picture_clear(struct picture *p) {
    float *layers[] = {p->color, p->variance, p->albedo, p->normal, p->emission, p->depth, p->out};
    for (int i = 0; i < 7; i++)
        free(layers[i]);
}

/* A tiled floor under a smooth, noisy light, as 4 samples a pixel give it; a lamp; nothing behind
 * the upper left. */
static inline struct picture room(int width, int height) {
    struct picture p = picture_new(width, height);
    uint32_t seed = 7;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            int i = y * width + x;
            if (x + y < width / 8)
                continue;
            float light = 1.0f + 0.5f * sinf(0.02f * (float)x), noise = 0;
            for (int s = 0; s < 4; s++)
                noise += uniform(&seed) < 0.3f ? 0.25f / 0.3f : 0.0f;
            bool lamp = x > width / 2 && x < width / 2 + 20 && y > height / 3 && y < height / 3 + 9;
            for (int c = 0; c < 3; c++) {
                float albedo = ((x / 16 + y / 16) & 1 ? 0.8f : 0.3f) * (1.0f - 0.2f * (float)c);
                p.albedo[3 * i + c] = albedo;
                p.emission[3 * i + c] = lamp ? 15.0f : 0.0f;
                p.color[3 * i + c] = albedo * light * noise + p.emission[3 * i + c];
                p.variance[3 * i + c] = 0.25f * albedo * albedo * light * noise;
            }
            p.normal[3 * i + 1] = 1.0f;
            p.depth[i] = 2.0f + 0.01f * (float)y;
        }
    return p;
}

static inline struct fewray_denoise_input color_alone(const struct picture *p) {
    return (struct fewray_denoise_input){
        .width = p->width, .height = p->height, .color = fewray_interleaved(p->color, p->width)};
}

static inline struct fewray_denoise_input all_layers(const struct picture *p) {
    struct fewray_denoise_input in = color_alone(p);
    in.variance = fewray_interleaved(p->variance, p->width);
    in.albedo = fewray_interleaved(p->albedo, p->width);
    in.normal = fewray_interleaved(p->normal, p->width);
    in.emission = fewray_interleaved(p->emission, p->width);
    in.depth =
        (struct fewray_channels){.channel = {p->depth}, .pixel_stride = 1, .row_stride = p->width};
    return in;
}

/* What fewray_denoiser_run() returns; options may be NULL. */
static inline int try_denoise(const struct fewray_denoise_input *in, float *out,
                              const struct fewray_denoise_options *options,
                              struct fewray_denoise_stats *stats) {
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_error error;
    assert_int_equal(fewray_denoiser_create(options, &denoiser, &error), FEWRAY_OK);
    int status = fewray_denoiser_run(denoiser, in, out, stats, &error);
    fewray_denoiser_destroy(&denoiser);
    assert_null(denoiser);
    return status;
}

static inline struct fewray_denoise_stats denoise(const struct fewray_denoise_input *in, float *out,
                                                  int threads, size_t memory) {
    struct fewray_denoise_options options;
    struct fewray_denoise_stats stats;
    fewray_denoise_options_init(&options);
    options.threads = threads;
    options.max_memory = memory;
    assert_int_equal(try_denoise(in, out, &options, &stats), FEWRAY_OK);
    return stats;
}

static inline size_t count(const struct picture *p) {
    return (size_t)p->width * (size_t)p->height * 3;
}

#endif
