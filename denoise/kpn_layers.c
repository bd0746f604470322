/* SPDX-License-Identifier: Apache-2.0 */
/* Layers on their way into the slots of the pyramid's pixels and out of them. */

#include "denoise/kpn_layers.h"

int kpn_layers_check(const struct fewray_denoise_input *in, struct fewray_error *error) {
    for (int k = 0; k < in->layer_count; k++) {
        const struct fewray_denoise_layer *layer = &in->layers[k];
        for (int c = 0; c < (layer->coverage ? 1 : 3); c++)
            if (!layer->in.channel[c] || !layer->out[c])
                return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                                   "layer %d of the denoiser lacks channel %d", k, c);
    }
    return FEWRAY_OK;
}

int kpn_layers_slots(const struct fewray_denoise_input *in) {
    int radiance = 0, coverage = 0;
    for (int k = 0; k < in->layer_count; k++)
        if (in->layers[k].coverage)
            coverage++;
        else
            radiance++;
    return coverage > radiance + 1 ? coverage : radiance + 1;
}

/* NaN becomes 0. */
static float unit(float v) {
    return v > 0.0f ? (v < 1.0f ? v : 1.0f) : 0.0f;
}

static int nearest(int v, int size) {
    return v < size ? v : size - 1;
}

static void clear_row(int count, int slots, float *light) {
    size_t pixel = 4 * (size_t)slots;
    for (size_t x = 0; x < (size_t)count; x++)
        for (size_t c = 4; c < pixel; c++)
            light[x * pixel + c] = 0.0f;
}

void kpn_layers_light_row(const struct fewray_denoise_input *in, int y, int x0, int count,
                          float *scratch, int slots, float *light) {
    const size_t n = (size_t)count, pixel = 4 * (size_t)slots;
    float *rows = scratch, *to_radiance = light, *to_coverage = light + 3;
    clear_row(count, slots, light);
    for (int k = 0; k < in->layer_count; k++) {
        const struct fewray_denoise_layer *layer = &in->layers[k];
        if (layer->coverage) {
            const float *from =
                layer->in.channel[0] + nearest(y, in->height) * layer->in.row_stride;
            for (int x = 0; x < count; x++)
                to_coverage[(size_t)x * pixel] =
                    unit(from[nearest(x0 + x, in->width) * layer->in.pixel_stride]);
            to_coverage += 4;
        } else {
            to_radiance += 4;
            kpn_layer_row(in, layer, y, x0, count, rows + 3 * n, rows);
            for (size_t x = 0; x < n; x++)
                for (size_t c = 0; c < 3; c++)
                    to_radiance[x * pixel + c] = rows[c * n + x];
        }
    }
}

void kpn_layers_put_row(const struct fewray_denoise_input *in, int y, int x0, int count,
                        const float *filtered, size_t slot_floats) {
    size_t radiance = 0, coverage = 0;
    for (int k = 0; k < in->layer_count; k++) {
        const struct fewray_denoise_layer *layer = &in->layers[k];
        if (!layer->coverage) {
            radiance += slot_floats;
            kpn_layer_put_row(in, layer, y, x0, count, filtered ? filtered + radiance : NULL);
            continue;
        }
        const float *from = layer->in.channel[0] + y * layer->in.row_stride;
        float *to = layer->out[0] + y * layer->out_row_stride;
        for (int i = 0; i < count; i++)
            to[(x0 + i) * layer->out_pixel_stride] =
                unit(filtered ? filtered[coverage + 4 * (size_t)i + 3]
                              : from[(x0 + i) * layer->in.pixel_stride]);
        coverage += slot_floats;
    }
}
