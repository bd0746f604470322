/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_H
#define FEWRAY_DENOISE_H

/* The kernel-predicting denoiser. A stranger's ten lines:
 *
 *     struct fewray_denoise_options options;
 *     fewray_denoise_options_init(&options);
 *     struct fewray_denoiser *denoiser = NULL;
 *     struct fewray_error error;
 *     struct fewray_denoise_input in = {.width = w, .height = h, .color = fewray_interleaved(rgb,
 * w), .albedo = fewray_interleaved(albedo, w), .normal = fewray_interleaved(normal, w)}; if
 * (fewray_denoiser_create(&options, &denoiser, &error) || fewray_denoiser_run(denoiser, &in,
 * out_rgb, NULL, &error)) puts(error.what); fewray_denoiser_destroy(&denoiser);
 */

#include "fewray/features.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The networks that are built into the library. */
enum fewray_denoise_model {
    FEWRAY_DENOISE_DEFAULT,
    FEWRAY_DENOISE_FAST /* a third of the arithmetic, less exact */
};

struct fewray_denoise_options {
    int threads;                     /* 0 = all cores that the picture has work for */
    enum fewray_denoise_model model; /* ignored where weights_path is given */
    const char *weights_path; /* NULL: those built into the library; any number of channels */
    const char
        *isa; /* NULL or "auto", "plain", "avx2", "avx512": the highest instruction set to use */
    size_t max_memory; /* bytes for the network's buffers; wider pictures go column by column; 0 =
                          256 MiB */
    /* Tiles in which the standard error of every pixel, by the variance layer, is at most this part
     * of its radiance are copied as they are; 0 = 0.001, negative: none are. */
    float settled_error;
    void (*progress)(void *user, double fraction); /* NULL; called from one thread */
    void *progress_user;
    const volatile int *cancel; /* NULL; non-zero stops the work with FEWRAY_ERROR_CANCELLED */
};
FEWRAY_API void fewray_denoise_options_init(struct fewray_denoise_options *options);

/* Three channels of a picture: value c of pixel (x, y) is channel[c][y * row_stride + x *
 * pixel_stride], in floats. */
struct fewray_channels {
    const float *channel[3]; /* channel[0] and half[0] NULL: the picture lacks this layer */
    ptrdiff_t pixel_stride, row_stride;
    const uint16_t *half[3]; /* instead of channel: finite IEEE binary16, with the same strides */
};
/* A (height, width, 3) array, rows without gaps. */
FEWRAY_API struct fewray_channels fewray_interleaved(const float *rgb, int width);
/* Three (height, width) planes. */
FEWRAY_API struct fewray_channels fewray_planar(float *const planes[3], int width);

struct fewray_denoise_layer;

/* Everything but color may be missing. Values should be finite and color, variance, albedo, depth
 * and emission not negative: fewray_frame_repair() sees to that. What isn't does no harm beyond its
 * surroundings: NaN and negative values count as 0, radiance above 1e12 as 1e12, its variance above
 * 1e24 as that, and what comes out is finite. */
struct fewray_denoise_input {
    int width, height;
    struct fewray_channels color;         /* radiance, linear; no half floats */
    struct fewray_channels variance;      /* of the pixel's mean, radiance^2 */
    struct fewray_channels albedo;        /* 0..1 */
    struct fewray_channels shaded_albedo; /* of the samples that color is made of, where albedo
                                             comes from more camera rays; missing: albedo */
    struct fewray_channels normal;        /* world space, -1..1 */
    struct fewray_channels
        emission; /* the part of color that the camera rays' first hits emit; not filtered */
    struct fewray_channels depth;      /* channel[0] alone */
    struct fewray_channels irradiance; /* over pi: another estimate of the irradiance, a guide's */
    struct fewray_channels
        confidence; /* in it, 0..1; channel[0] alone; missing: irradiance isn't used */
    const struct emitters *emitters;           /* the denoiser's own; leave it NULL */
    const struct fewray_denoise_layer *layers; /* more to filter alike; they change no weight */
    int layer_count;
};

/* Where the unfiltered emission of the input belongs. */
enum fewray_emission_part {
    FEWRAY_EMISSION_ELSEWHERE, /* not in this layer */
    FEWRAY_EMISSION_INSIDE,    /* all of it is in this layer, as in direct light */
    FEWRAY_EMISSION_SHARED /* in every layer by its share of the colour: where nobody knows, also
                              what the denoiser itself takes for emission */
};

/* Another layer of the picture, filtered by the very weights that the beauty is filtered by: layers
 * of which the colour is the sum still add up to it. */
struct fewray_denoise_layer {
    struct fewray_channels in; /* radiance that is part of color, finite and not negative; or
                                  coverage: channel[0] alone, 0..1 */
    bool coverage; /* filtered as it is, without albedo and emission, and kept in 0..1 */
    enum fewray_emission_part emission; /* of radiance */
    /* Where it goes: as struct fewray_channels has it; may not overlap the input. */
    float *out[3];
    ptrdiff_t out_pixel_stride, out_row_stride;
};

struct fewray_denoise_stats {
    int tiles, tiles_denoised; /* of 64x64 pixels; tiles_denoised is less where tiles had nothing to
                                  filter (background, black, no noise) */
    int regions;               /* parts of the picture that the network saw one after another */
    double seconds;            /* wall time */
    size_t buffer_bytes;       /* peak of the network's buffers */
};

struct fewray_denoiser;

/* Loads the weights and picks the kernels. *out is owned by the caller. A denoiser can be used
 * again, by one thread at a time. */
FEWRAY_API int fewray_denoiser_create(const struct fewray_denoise_options *options,
                                      struct fewray_denoiser **out, struct fewray_error *error);
/* Filters in->color into out_rgb, (height, width, 3), rows without gaps; it may not overlap the
 * input. Each output pixel is emission + albedo * a weighted mean of (color - emission) /
 * shaded_albedo around it, with weights that are non-negative and sum to one. stats may be NULL. */
FEWRAY_API int fewray_denoiser_run(struct fewray_denoiser *denoiser,
                                   const struct fewray_denoise_input *in, float *out_rgb,
                                   struct fewray_denoise_stats *stats, struct fewray_error *error);
FEWRAY_API void fewray_denoiser_destroy(struct fewray_denoiser **denoiser);

/* Denoises the R, G, B of a frame by its known layers, compact or not, keeping the old values as
 * noisy.R/G/B; and its A, where that isn't 1 everywhere, keeping noisy.A. */
FEWRAY_API int fewray_denoise_frame(struct fewray_denoiser *denoiser, struct fewray_frame *frame,
                                    struct fewray_denoise_stats *stats, struct fewray_error *error);
/* The same, and the layers of these names with the same weights, keeping noisy.NAME.R/G/B. A name
 * means NAME.R, NAME.G, NAME.B, radiance that is part of the colour. The frame's emission is in the
 * layer "direct" and in those called "NAME:emission", and in those called "NAME:shared" by their
 * shares of the colour; without an emission layer, in all by their shares. A single channel of the
 * name is coverage, 0..1. */
FEWRAY_API int fewray_denoise_frame_layers(struct fewray_denoiser *denoiser,
                                           struct fewray_frame *frame, const char *const *names,
                                           int name_count, struct fewray_denoise_stats *stats,
                                           struct fewray_error *error);

/* --- frames of a sequence */

/* What the frames before leave for the next: light over albedo, its variance, and the surfaces that
 * it was seen on. About 180 bytes a pixel. */
struct fewray_denoise_history;

struct fewray_denoise_history_options {
    float frames; /* at most so many count in the mean, >= 1; older ones fade (8) */
    float sigmas; /* the past counts less where the light around a pixel changed by more than so
                     many standard errors of the noisy frames, and not at all from twice as
                     many on (1.5) */
    int threads;  /* 0 = all cores */
};
FEWRAY_API void fewray_denoise_history_options_init(struct fewray_denoise_history_options *options);

/* Where the surface that a pixel shows was in the previous frame. */
struct fewray_denoise_motion {
    struct fewray_channels offset;         /* channel[0], [1]: its place there less the pixel's own,
                                              pixels, x to the right, y down */
    struct fewray_channels previous_depth; /* channel[0]: the way to it from the camera there, as
                                              the depth layer counts; 0: it wasn't there */
};

/* *out is owned by the caller. One history for each sequence of one camera, used by one thread at a
 * time. options may be NULL. */
FEWRAY_API int fewray_denoise_history_create(const struct fewray_denoise_history_options *options,
                                             struct fewray_denoise_history **out,
                                             struct fewray_error *error);
FEWRAY_API void fewray_denoise_history_destroy(struct fewray_denoise_history **history);
/* Takes the next frame: the layers as they were handed to fewray_denoiser_run(), but for color and
 * layers, which hold what it returned. *out (it may be in itself) gets the same with color,
 * variance and layers of radiance being means over the frames so far, surface by surface; they stay
 * the history's, valid until its next frame. Without depth nothing is found again. motion NULL, or
 * a frame of another size or other layers of radiance: a new sequence begins. */
FEWRAY_API int fewray_denoise_history_add(struct fewray_denoise_history *history,
                                          const struct fewray_denoise_input *in,
                                          const struct fewray_denoise_motion *motion,
                                          struct fewray_denoise_input *out,
                                          struct fewray_error *error);
/* fewray_denoise_frame_layers() of the next frame of a sequence, then the mean over the frames so
 * far. history NULL: a frame by itself. noisy.R/G/B and variance stay those of this frame. */
FEWRAY_API int fewray_denoise_frame_after(struct fewray_denoiser *denoiser,
                                          struct fewray_denoise_history *history,
                                          const struct fewray_denoise_motion *motion,
                                          struct fewray_frame *frame, const char *const *names,
                                          int name_count, struct fewray_denoise_stats *stats,
                                          struct fewray_error *error);

#ifdef __cplusplus
}
#endif
#endif
