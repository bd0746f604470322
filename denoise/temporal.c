/* SPDX-License-Identifier: Apache-2.0 */
/* The mean of denoised light over the frames of a sequence, each pixel's surface found again in the
 * frame before as in Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering", section 4.1,
 * but behind the denoiser: noise that was interpolated between pixels looks like detail to it. */

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "denoise/input_rows.h"
#include "denoise/temporal.h"

enum { SCRATCH_PLANES = 4, PIXEL_FLOATS = sizeof(struct temporal_pixel) / sizeof(float) };

struct fewray_denoise_history {
    struct fewray_denoise_history_options options;
    int width, height;
    int layer_count; /* of radiance: coverage isn't kept */
    bool has_past;
    struct temporal_pixel *past, *now; /* (height, width) */
    struct temporal_pixel *warped; /* what of the past each pixel of now shows; then the result */
    float *scratch;                /* SCRATCH_PLANES of (height, width) */
    /* Light of the layers of radiance, (layer_count, height, width, 3). */
    float *past_layers, *now_layers, *result_layers;
    struct fewray_denoise_layer *layers; /* of the result */
};

void fewray_denoise_history_options_init(struct fewray_denoise_history_options *options) {
    *options = (struct fewray_denoise_history_options){.frames = 8, .sigmas = 1.5f};
}

int fewray_denoise_history_create(const struct fewray_denoise_history_options *options,
                                  struct fewray_denoise_history **out, struct fewray_error *error) {
    *out = calloc(1, sizeof **out);
    if (!*out)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the sequence");
    fewray_denoise_history_options_init(&(*out)->options);
    if (options)
        (*out)->options = *options;
    if ((*out)->options.frames >= 1 && (*out)->options.sigmas > 0)
        return FEWRAY_OK;
    fewray_denoise_history_destroy(out);
    return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                       "a history needs at least 1 frame, and sigmas above 0");
}

static void free_buffers(struct fewray_denoise_history *h) {
    free(h->past);
    free(h->now);
    free(h->warped);
    free(h->scratch);
    free(h->past_layers);
    free(h->now_layers);
    free(h->result_layers);
    free(h->layers);
}

void fewray_denoise_history_destroy(struct fewray_denoise_history **history) {
    if (!*history)
        return;
    free_buffers(*history);
    free(*history);
    *history = NULL;
}

/* The layer of radiance number k. */
static const struct fewray_denoise_layer *radiance_layer(const struct fewray_denoise_input *in,
                                                         int k) {
    const struct fewray_denoise_layer *layer = in->layers;
    for (; layer->coverage || k > 0; layer++)
        k -= !layer->coverage;
    return layer;
}

static int count_radiance_layers(const struct fewray_denoise_input *in) {
    int count = 0;
    for (int k = 0; k < in->layer_count; k++)
        count += !in->layers[k].coverage;
    return count;
}

/* Buffers for pictures of this size and so many layers; others are kept as they are. */
static int prepare(struct fewray_denoise_history *h, const struct fewray_denoise_input *in,
                   struct fewray_error *error) {
    const int layer_count = count_radiance_layers(in);
    free(h->layers);
    h->layers = calloc((size_t)in->layer_count + 1, sizeof *h->layers);
    if (h->layers && h->past && h->width == in->width && h->height == in->height &&
        h->layer_count == layer_count)
        return FEWRAY_OK;
    free_buffers(h);
    *h = (struct fewray_denoise_history){.options = h->options,
                                         .width = in->width,
                                         .height = in->height,
                                         .layer_count = layer_count};
    const size_t pixels = (size_t)in->width * (size_t)in->height;
    const size_t layer_floats = 3 * pixels * (size_t)layer_count + 1;
    h->past = calloc(pixels, sizeof *h->past);
    h->now = calloc(pixels, sizeof *h->now);
    h->warped = calloc(pixels, sizeof *h->warped);
    h->scratch = calloc(pixels, SCRATCH_PLANES * sizeof *h->scratch);
    h->past_layers = calloc(layer_floats, sizeof *h->past_layers);
    h->now_layers = calloc(layer_floats, sizeof *h->now_layers);
    h->result_layers = calloc(layer_floats, sizeof *h->result_layers);
    h->layers = calloc((size_t)in->layer_count + 1, sizeof *h->layers);
    if (h->past && h->now && h->warped && h->scratch && h->past_layers && h->now_layers &&
        h->result_layers && h->layers)
        return FEWRAY_OK;
    free_buffers(h);
    *h = (struct fewray_denoise_history){.options = h->options};
    return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                       "no memory for the frames of the sequence");
}

static float value_or(const struct fewray_channels *layer, int c, int y, int x, float missing) {
    return kpn_has(layer) ? kpn_value(layer, c, y, x) : missing;
}

/* What a pixel's light is multiplied by to be colour. */
static float albedo_at(const struct fewray_denoise_input *in, int c, int y, int x) {
    return divisor(value_or(&in->albedo, c, y, x, 1));
}

static float emission_at(const struct fewray_denoise_input *in, int c, int y, int x) {
    return clean(value_or(&in->emission, c, y, x, 0));
}

/* The part of a layer that isn't filtered: see modulate.c. */
static float layer_emission_at(const struct fewray_denoise_input *in,
                               const struct fewray_denoise_layer *layer, int c, int y, int x) {
    return layer->emission == FEWRAY_EMISSION_INSIDE ? emission_at(in, c, y, x) : 0;
}

static void read_pixel(const struct fewray_denoise_input *in, int y, int x,
                       struct temporal_pixel *out) {
    for (int c = 0; c < 3; c++) {
        const float albedo = albedo_at(in, c, y, x);
        const float light = clean(kpn_value(&in->color, c, y, x) - emission_at(in, c, y, x));
        out->light[c] = light / albedo;
        /* Without a variance a pixel is as uncertain as it is bright. */
        out->variance[c] =
            clean_variance(value_or(&in->variance, c, y, x, light * light)) / (albedo * albedo);
        out->albedo[c] = value_or(&in->albedo, c, y, x, 0);
        out->normal[c] = value_or(&in->normal, c, y, x, 0);
    }
    out->depth = value_or(&in->depth, 0, y, x, 0);
    out->frames = 1;
}

static void read_frame(struct fewray_denoise_history *h, const struct fewray_denoise_input *in,
                       int threads) {
    const size_t pixels = (size_t)h->width * (size_t)h->height;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int y = 0; y < h->height; y++)
        for (int x = 0; x < h->width; x++) {
            const size_t i = (size_t)y * (size_t)h->width + (size_t)x;
            read_pixel(in, y, x, &h->now[i]);
            for (int k = 0; k < h->layer_count; k++) {
                const struct fewray_denoise_layer *layer = radiance_layer(in, k);
                for (int c = 0; c < 3; c++)
                    h->now_layers[3 * ((size_t)k * pixels + i) + (size_t)c] =
                        clean(kpn_value(&layer->in, c, y, x) -
                              layer_emission_at(in, layer, c, y, x)) /
                        albedo_at(in, c, y, x);
            }
        }
}

static struct temporal_taps find(const struct fewray_denoise_history *h,
                                 const struct fewray_denoise_motion *motion, int y, int x) {
    const float position[2] = {(float)x + 0.5f + kpn_value(&motion->offset, 0, y, x),
                               (float)y + 0.5f + kpn_value(&motion->offset, 1, y, x)};
    return temporal_find(h->past, h->now, h->width, h->height, x, y, position,
                         kpn_value(&motion->previous_depth, 0, y, x));
}

/* The mean over the frames: with n frames before, this one counts 1 / (n + 1). */
static void join_pixel(const struct temporal_pixel *warped, float most,
                       struct temporal_pixel *now) {
    const float frames = fminf(warped->frames, most - 1), share = 1 / (frames + 1);
    for (int c = 0; c < 3; c++) {
        now->light[c] = share * now->light[c] + (1 - share) * warped->light[c];
        now->variance[c] =
            share * share * now->variance[c] + (1 - share) * (1 - share) * warped->variance[c];
    }
    now->frames = frames + 1;
}

static void join_layers(struct fewray_denoise_history *h, const struct temporal_taps *taps,
                        size_t i, float share) {
    const size_t pixels = (size_t)h->width * (size_t)h->height;
    for (int k = 0; k < h->layer_count; k++) {
        const float *past = h->past_layers + 3 * (size_t)k * pixels;
        float *now = h->now_layers + 3 * ((size_t)k * pixels + i);
        for (int c = 0; c < 3; c++) {
            float light = 0;
            for (int t = 0; t < taps->count; t++)
                light += taps->weight[t] * past[3 * taps->index[t] + (size_t)c];
            now[c] = share * now[c] + (1 - share) * light;
        }
    }
}

static void join_frame(struct fewray_denoise_history *h, const struct fewray_denoise_motion *motion,
                       int threads) {
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int y = 0; y < h->height; y++)
        for (int x = 0; x < h->width; x++) {
            const struct temporal_taps taps = find(h, motion, y, x);
            temporal_mix(h->past, &taps, &h->warped[(size_t)y * (size_t)h->width + (size_t)x]);
        }
    temporal_trust(h->now, h->warped, h->width, h->height, h->options.sigmas, threads, h->scratch);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int y = 0; y < h->height; y++)
        for (int x = 0; x < h->width; x++) {
            const size_t i = (size_t)y * (size_t)h->width + (size_t)x;
            if (!(h->warped[i].frames > 0))
                continue;
            if (h->layer_count > 0) {
                const struct temporal_taps taps = find(h, motion, y, x);
                const float frames = fminf(h->warped[i].frames, h->options.frames - 1);
                join_layers(h, &taps, i, 1 / (frames + 1));
            }
            join_pixel(&h->warped[i], h->options.frames, &h->now[i]);
        }
}

/* Light back to colour. */
static void write_result(struct fewray_denoise_history *h, const struct fewray_denoise_input *in,
                         int threads) {
    const size_t pixels = (size_t)h->width * (size_t)h->height;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int y = 0; y < h->height; y++)
        for (int x = 0; x < h->width; x++) {
            const size_t i = (size_t)y * (size_t)h->width + (size_t)x;
            struct temporal_pixel *out = &h->warped[i];
            *out = h->now[i];
            for (int c = 0; c < 3; c++) {
                const float albedo = albedo_at(in, c, y, x);
                out->light[c] = out->light[c] * albedo + emission_at(in, c, y, x);
                out->variance[c] *= albedo * albedo;
                for (int k = 0; k < h->layer_count; k++) {
                    const size_t j = 3 * ((size_t)k * pixels + i) + (size_t)c;
                    h->result_layers[j] = h->now_layers[j] * albedo +
                                          layer_emission_at(in, radiance_layer(in, k), c, y, x);
                }
            }
        }
}

/* count values of each pixel of the result, from `first` on. */
static struct fewray_channels result_channels(const struct fewray_denoise_history *h,
                                              const float *first, int count) {
    struct fewray_channels channels = {.pixel_stride = PIXEL_FLOATS,
                                       .row_stride = (ptrdiff_t)PIXEL_FLOATS * h->width};
    for (int c = 0; c < count; c++)
        channels.channel[c] = first + c;
    return channels;
}

static void describe_result(struct fewray_denoise_history *h, const struct fewray_denoise_input *in,
                            struct fewray_denoise_input *out) {
    struct fewray_denoise_input result = *in;
    const struct temporal_pixel *first = h->warped;
    result.color = result_channels(h, first->light, 3);
    if (kpn_has(&in->variance))
        result.variance = result_channels(h, first->variance, 3);
    const size_t layer_floats = 3 * (size_t)h->width * (size_t)h->height;
    const float *light = h->result_layers;
    for (int k = 0; k < in->layer_count; k++) {
        h->layers[k] = in->layers[k];
        if (h->layers[k].coverage)
            continue;
        h->layers[k].in = fewray_interleaved(light, h->width);
        light += layer_floats;
    }
    result.layers = h->layers;
    *out = result;
}

int fewray_denoise_history_add(struct fewray_denoise_history *history,
                               const struct fewray_denoise_input *in,
                               const struct fewray_denoise_motion *motion,
                               struct fewray_denoise_input *out, struct fewray_error *error) {
    struct fewray_denoise_history *h = history;
    const float *const *color = in->color.channel;
    if (in->width <= 0 || in->height <= 0 || !color[0] || !color[1] || !color[2])
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0, "a frame without colour");
    if (motion && motion->offset.channel[0] && !motion->offset.channel[1])
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0, "motion in x without that in y");
    int status = prepare(h, in, error);
    if (status)
        return status;
    const int threads = h->options.threads > 0 ? h->options.threads : omp_get_num_procs();
    read_frame(h, in, threads);
    if (h->has_past && motion && motion->offset.channel[0] && motion->previous_depth.channel[0] &&
        kpn_has(&in->depth))
        join_frame(h, motion, threads);
    write_result(h, in, threads);
    describe_result(h, in, out);

    struct temporal_pixel *pixels = h->past;
    float *layers = h->past_layers;
    h->past = h->now;
    h->now = pixels;
    h->past_layers = h->now_layers;
    h->now_layers = layers;
    h->has_past = true;
    return FEWRAY_OK;
}
