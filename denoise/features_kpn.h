/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_FEATURES_KPN_H
#define FEWRAY_DENOISE_FEATURES_KPN_H

/* What the kernel-predicting network sees of a picture. Training uses these functions too, so that
 * the network never meets features made by other code.
 *
 * Irradiance (up to a factor pi) is E = (color - emission) / max(albedo, KPN_ALBEDO_MIN) per
 * channel; albedo is 1 and emission 0 where the layer is missing. */

#include <stdbool.h>

#include "fewray/denoise.h"

#define KPN_FEATURES   16
#define KPN_ALBEDO_MIN 0.01f
/* Floats of scratch that kpn_feature_row() needs for a row of count pixels. */
#define KPN_FEATURE_SCRATCH(count) ((size_t)9 * ((size_t)(count) + 2))

/* Whether the picture has this layer. */
static inline bool kpn_has(const struct fewray_channels *layer) {
    return layer->channel[0] || layer->half[0];
}
/* A value of a layer that the picture has. */
static inline float kpn_value(const struct fewray_channels *layer, int c, int y, int x) {
    const ptrdiff_t i = y * layer->row_stride + x * layer->pixel_stride;
    return layer->channel[c] ? layer->channel[c][i] : fewray_half_value(layer->half[c][i]);
}

/* Numbers of the whole picture, which bring pictures of any exposure and size to one range. */
struct kpn_scale {
    float exposure;    /* 1 / median of the irradiance's luminance over 4x4 blocks with light; 0: no
                          light at all */
    float log2_depth;  /* log2 of the median depth of the pixels that hit something */
    bool has_variance; /* false: the layer is missing, or zero everywhere (one sample has no
                          variance) */
};

/* Medians from histograms: one outlier moves them by less than a thousandth, and the number of
 * threads doesn't matter. Fails only without memory. */
int kpn_measure(const struct fewray_denoise_input *in, int threads, struct kpn_scale *scale,
                struct fewray_error *error);

/* Pixels x0 <= x < x0 + count of row y; coordinates beyond the picture's right and lower edges take
 * the nearest pixel. irradiance gets (3, count) planes, features (KPN_FEATURES, count): 0-2
 * irradiance, exposed and log-compressed   3 relative standard error of its luminance,
 * log-compressed 4-6 albedo   7-9 normal   10 log2 of depth over the median   11 luminance of
 * emission, log-compressed 12-14 the guide's irradiance, as 0-2   15 its confidence; 0 without a
 * guide */
void kpn_feature_row(const struct fewray_denoise_input *in, const struct kpn_scale *scale, int y,
                     int x0, int count, float *scratch, float *irradiance, float *features);

/* out_rgb (count, 3) = filtered * max(albedo, KPN_ALBEDO_MIN) + emission; filtered is (count, 4),
 * all pixels inside the picture. filtered NULL means zero. */
void kpn_remodulate_row(const struct fewray_denoise_input *in, int y, int x0, int count,
                        const float *filtered, float *out_rgb);

/* The part of a layer that is filtered, as kpn_feature_row() has it of the colour: (3, count).
 * scratch: 3 * count floats. */
void kpn_layer_row(const struct fewray_denoise_input *in, const struct fewray_denoise_layer *layer,
                   int y, int x0, int count, float *scratch, float *irradiance);
/* Writes pixels of a layer's row, all inside the picture: filtered, (count, 4), with albedo and
 * emission as in kpn_remodulate_row(). NULL: the layer's own values. */
void kpn_layer_put_row(const struct fewray_denoise_input *in,
                       const struct fewray_denoise_layer *layer, int y, int x0, int count,
                       const float *filtered);

#endif
