/* SPDX-License-Identifier: Apache-2.0 */
/* Filtered light times albedo plus emission, of the beauty and of other layers. */

#include "denoise/input_rows.h"

enum { REMODULATED = 64 }; /* pixels at a time */

CLONED void kpn_remodulate_row(const struct fewray_denoise_input *in, int y, int x0, int count,
                               const float *filtered, float *out_rgb) {
    const bool has_emission = kpn_has(&in->emission) || in->emitters;
    float albedo[REMODULATED], emission[REMODULATED];
    for (int x = 0; x < count; x += REMODULATED) {
        const int n = count - x < REMODULATED ? count - x : REMODULATED;
        for (int c = 0; c < 3; c++) {
            float *out = out_rgb + 3 * x + c;
            for (int i = 0; i < n; i++)
                out[3 * i] = filtered ? filtered[4 * (x + i) + c] : 0.0f;
            if (kpn_has(&in->albedo)) {
                albedo_row(in, c, y, x0 + x, n, albedo);
                for (int i = 0; i < n; i++)
                    out[3 * i] *= divisor(albedo[i]);
            }
            if (has_emission) {
                emission_row(in, c, y, x0 + x, n, emission);
                for (int i = 0; i < n; i++)
                    out[3 * i] += clean(emission[i]);
            }
        }
    }
}

/* --- other layers */

/* Of a layer's value what isn't filtered. */
static float unfiltered(enum fewray_emission_part part, float value, float color, float emission) {
    if (part == FEWRAY_EMISSION_ELSEWHERE || !(emission > 0.0f))
        return 0.0f;
    if (part == FEWRAY_EMISSION_INSIDE)
        return emission;
    return value < color ? emission * (value / color) : value > 0.0f ? emission : 0.0f;
}

void kpn_layer_row(const struct fewray_denoise_input *in, const struct fewray_denoise_layer *layer,
                   int y, int x0, int count, float *scratch, float *irradiance) {
    y = y < in->height ? y : in->height - 1;
    x0 = x0 < in->width ? x0 : in->width - 1;
    float *color = scratch, *emission = color + count, *albedo = emission + count;
    for (int c = 0; c < 3; c++) {
        float *e = irradiance + (size_t)c * (size_t)count;
        gather(&layer->in, c, in->width, y, x0, count, 0.0f, e);
        gather(&in->color, c, in->width, y, x0, count, 0.0f, color);
        emission_row(in, c, y, x0, count, emission);
        shaded_albedo_row(in, c, y, x0, count, albedo);
        for (int i = 0; i < count; i++) {
            float value = clean(e[i]);
            float kept = unfiltered(layer->emission, value, clean(color[i]), clean(emission[i]));
            e[i] = clean(value - kept) / divisor(albedo[i]);
        }
    }
}

/* A channel of at most REMODULATED pixels. */
static void put_piece(const struct fewray_denoise_input *in,
                      const struct fewray_denoise_layer *layer, int c, int y, int x0, int count,
                      const float *filtered) {
    float *to = layer->out[c] + y * layer->out_row_stride + x0 * layer->out_pixel_stride;
    float values[REMODULATED], color[REMODULATED], emission[REMODULATED], albedo[REMODULATED];
    gather(&layer->in, c, in->width, y, x0, count, 0.0f, values);
    gather(&in->color, c, in->width, y, x0, count, 0.0f, color);
    emission_row(in, c, y, x0, count, emission);
    albedo_row(in, c, y, x0, count, albedo);
    for (int i = 0; i < count; i++) {
        float value = clean(values[i]);
        const float kept = unfiltered(layer->emission, value, clean(color[i]), clean(emission[i]));
        if (filtered)
            value = filtered[4 * i + c] * divisor(albedo[i]) + kept;
        else if (value < kept)
            value = kept;
        to[i * layer->out_pixel_stride] = value;
    }
}

void kpn_layer_put_row(const struct fewray_denoise_input *in,
                       const struct fewray_denoise_layer *layer, int y, int x0, int count,
                       const float *filtered) {
    for (int x = 0; x < count; x += REMODULATED)
        for (int c = 0; c < 3; c++)
            put_piece(in, layer, c, y, x0 + x, count - x < REMODULATED ? count - x : REMODULATED,
                      filtered ? filtered + 4 * x : NULL);
}
