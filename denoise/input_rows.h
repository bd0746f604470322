/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_INPUT_ROWS_H
#define FEWRAY_DENOISE_INPUT_ROWS_H

/* Rows of the denoiser's input, whatever their format, and what light is divided by; inline, so
 * that each CLONED function has them for its own instruction set. */

#include <string.h>

#include "denoise/clones.h"
#include "denoise/emitters.h"
#include "denoise/features_kpn.h"

#define RADIANCE_MAX 1e12f /* more is damage */
#define VARIANCE_MAX 1e24f /* of such radiance */

/* NaN and negative values become 0. */
CLONED_INLINE float clean(float v) {
    return v > 0.0f ? (v < RADIANCE_MAX ? v : RADIANCE_MAX) : 0.0f;
}

/* Of a variance, radiance^2, likewise. */
CLONED_INLINE float clean_variance(float v) {
    return v > 0.0f ? (v < VARIANCE_MAX ? v : VARIANCE_MAX) : 0.0f;
}

CLONED_INLINE float divisor(float albedo) {
    return albedo > KPN_ALBEDO_MIN ? (albedo < 1e3f ? albedo : 1e3f) : KPN_ALBEDO_MIN;
}

CLONED_INLINE float luminance(float r, float g, float b) {
    return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}

/* Copies channel c of a row to out, repeating the last pixel beyond the picture; missing layers
 * give `missing`. */
CLONED_INLINE void gather(const struct fewray_channels *layer, int c, int width, int y, int x0,
                          int count, float missing, float *out) {
    if (!layer->channel[c] && !layer->half[c]) {
        for (int i = 0; i < count; i++)
            out[i] = missing;
        return;
    }
    const ptrdiff_t first = y * layer->row_stride + x0 * layer->pixel_stride;
    int inside = width - x0 < count ? width - x0 : count;
    if (inside < 0)
        inside = 0;
    if (layer->half[c]) {
        const uint16_t *from = layer->half[c] + first;
        for (int i = 0; i < inside; i++)
            out[i] = fewray_half_value(from[i * layer->pixel_stride]);
    } else {
        const float *from = layer->channel[c] + first;
        if (layer->pixel_stride == 1)
            memcpy(out, from, (size_t)inside * sizeof *out);
        else
            for (int i = 0; i < inside; i++)
                out[i] = from[i * layer->pixel_stride];
    }
    const float last = inside < count ? kpn_value(layer, c, y, width - 1) : 0.0f;
    for (int i = inside; i < count; i++)
        out[i] = last;
}

/* A row of the albedo, raised where emitters are near. */
CLONED_INLINE void albedo_row(const struct fewray_denoise_input *in, int c, int y, int x0,
                              int count, float *out) {
    gather(&in->albedo, c, in->width, y, x0, count, 1.0f, out);
    if (in->emitters)
        emitters_raise_albedo(in->emitters, y, x0, count, out);
}

/* A row of the emission, as the layer or the emitters that were found have it. */
CLONED_INLINE void emission_row(const struct fewray_denoise_input *in, int c, int y, int x0,
                                int count, float *out) {
    gather(&in->emission, c, in->width, y, x0, count, 0.0f, out);
    if (in->emitters)
        emitters_add_emission(in->emitters, in, c, y, x0, count, out);
}

/* A row of the albedo by which the colour is divided. */
CLONED_INLINE void shaded_albedo_row(const struct fewray_denoise_input *in, int c, int y, int x0,
                                     int count, float *out) {
    if (kpn_has(&in->shaded_albedo))
        gather(&in->shaded_albedo, c, in->width, y, x0, count, 1.0f, out);
    else
        albedo_row(in, c, y, x0, count, out);
}

#endif
