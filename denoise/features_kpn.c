/* SPDX-License-Identifier: Apache-2.0 */
/* Features of the kernel-predicting network: demodulation, range compression, and the picture's own
 * scales. */

#include "denoise/features_kpn.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "denoise/input_rows.h"

#define COMPRESS_MAX 1e6f /* times the median; brighter pixels all look the same to the network */

/* log2 of a positive normal number, error below 2e-5; unlike libm's it vectorises. */
CLONED_INLINE float log2_fast(float x) {
    union {
        float f;
        uint32_t u;
    } bits = {x};
    float exponent = (float)((int32_t)(bits.u >> 23) - 127);
    bits.u = (bits.u & 0x7fffffu) | 0x3f800000u;
    float t = bits.f - 1.0f;
    float p = -0.03417683f;
    p = p * t + 0.14468563f;
    p = p * t - 0.301049f;
    p = p * t + 0.46802857f;
    p = p * t - 0.72017612f;
    p = p * t + 1.44266891f;
    return exponent + p * t;
}

/* 0 to about 6: 0.8 at 1, a quarter more for each doubling far above. */
CLONED_INLINE float compress(float v) {
    return 0.25f * log2_fast(1.0f + 8.0f * (v < COMPRESS_MAX ? v : COMPRESS_MAX));
}

/* irradiance (3, count); albedo and emission get one channel's row each, for scratch. */
CLONED_INLINE void irradiance_row(const struct fewray_denoise_input *in, int y, int x0, int count,
                                  float *albedo, float *emission, float *irradiance) {
    for (int c = 0; c < 3; c++) {
        float *e = irradiance + (size_t)c * (size_t)count;
        gather(&in->color, c, in->width, y, x0, count, 0.0f, e);
        emission_row(in, c, y, x0, count, emission);
        shaded_albedo_row(in, c, y, x0, count, albedo);
        for (int i = 0; i < count; i++)
            e[i] = clean(clean(e[i]) - clean(emission[i])) / divisor(albedo[i]);
    }
}

/* --- scales of the whole picture */

#define BIN_MIN         (-64)
#define BINS_PER_OCTAVE 32
#define BIN_COUNT       (128 * BINS_PER_OCTAVE)

struct histograms {
    uint32_t light[BIN_COUNT], depth[BIN_COUNT];
    bool has_variance;
};

CLONED_INLINE int bin_of(float v) {
    float position = (log2_fast(v) - (float)BIN_MIN) * BINS_PER_OCTAVE;
    return position < 0 ? 0 : (position >= BIN_COUNT ? BIN_COUNT - 1 : (int)position);
}

/* log2 of the median, linear inside its bin; 0 from an empty histogram. */
static float log2_median(const uint32_t *bins) {
    double total = 0;
    for (int i = 0; i < BIN_COUNT; i++)
        total += bins[i];
    double below = 0;
    for (int i = 0; i < BIN_COUNT; i++) {
        if (bins[i] && below + bins[i] >= 0.5 * total)
            return (float)(BIN_MIN + (i + (0.5 * total - below) / bins[i]) / BINS_PER_OCTAVE);
        below += bins[i];
    }
    return 0.0f;
}

/* Rows y0 to y0 + 3. rows: 6 * width floats. */
CLONED static void count_blocks(const struct fewray_denoise_input *in, int y0, float *rows,
                                struct histograms *h) {
    int width = in->width;
    size_t w = (size_t)width;
    float *sum = rows, *irradiance = rows + w, *albedo = rows + 4 * w, *row = rows + 5 * w;
    int y1 = y0 + 4 < in->height ? y0 + 4 : in->height;
    memset(sum, 0, sizeof(float) * w);
    for (int y = y0; y < y1; y++) {
        irradiance_row(in, y, 0, width, albedo, row, irradiance);
        for (size_t x = 0; x < w; x++)
            sum[x] += luminance(irradiance[x], irradiance[w + x], irradiance[2 * w + x]);
        if (kpn_has(&in->depth)) {
            gather(&in->depth, 0, width, y, 0, width, 0.0f, row);
            for (int x = 0; x < width; x++)
                if (clean(row[x]) > 1e-18f)
                    h->depth[bin_of(clean(row[x]))]++;
        }
        for (int c = 0; c < 3 && kpn_has(&in->variance) && !h->has_variance; c++) {
            gather(&in->variance, c, width, y, 0, width, 0.0f, row);
            for (int x = 0; x < width; x++)
                h->has_variance |= row[x] > 0.0f;
        }
    }
    for (int x = 0; x < width; x += 4) {
        float total = 0;
        int end = x + 4 < width ? x + 4 : width;
        for (int i = x; i < end; i++)
            total += sum[i];
        total /= (float)((end - x) * (y1 - y0));
        if (total > 1e-18f)
            h->light[bin_of(total)]++;
    }
}

int kpn_measure(const struct fewray_denoise_input *in, int threads, struct kpn_scale *scale,
                struct fewray_error *error) {
    size_t width = (size_t)in->width;
    struct histograms *h = calloc((size_t)threads, sizeof *h);
    float *rows = malloc((size_t)threads * 6 * width * sizeof *rows);
    int status = FEWRAY_OK;
    if (!h || !rows) {
        status =
            fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory to measure the picture");
        goto done;
    }
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int y = 0; y < in->height; y += 4) {
        int t = omp_get_thread_num();
        count_blocks(in, y, rows + (size_t)t * 6 * width, &h[t]);
    }
    bool lit = false;
    for (int t = 0; t < threads; t++)
        for (int i = 0; i < BIN_COUNT; i++) {
            if (t > 0) {
                h[0].light[i] += h[t].light[i];
                h[0].depth[i] += h[t].depth[i];
                h[0].has_variance |= h[t].has_variance;
            }
            lit |= h[t].light[i] > 0;
        }
    scale->exposure = lit ? exp2f(-log2_median(h[0].light)) : 0.0f;
    scale->log2_depth = log2_median(h[0].depth);
    scale->has_variance = h[0].has_variance;
done:
    free(h);
    free(rows);
    return status;
}

/* --- rows of features */

/* Luminance of irradiance of row y, pixels x0 - 1 to x0 + count, clamped to the picture; rows: 5 *
 * count + 10 floats */
CLONED_INLINE void luminance_row(const struct fewray_denoise_input *in, int y, int x0, int count,
                                 float *rows, float *out) {
    y = y < 0 ? 0 : (y < in->height ? y : in->height - 1);
    int left = x0 > 0 ? x0 - 1 : 0, n = count + 1 + x0 - left;
    irradiance_row(in, y, left, n, rows + 3 * n, rows + 4 * n, rows);
    float *to = out + (x0 > 0 ? 0 : 1);
    for (int i = 0; i < n; i++)
        to[i] = luminance(rows[i], rows[n + i], rows[2 * n + i]);
    if (x0 == 0)
        out[0] = out[1];
}

/* Where variance is missing, the deviation from the mean of 3x3 pixels stands in for the standard
 * error. */
CLONED_INLINE void spatial_deviation_row(const struct fewray_denoise_input *in, int y, int x0,
                                         int count, float *scratch, float *deviation) {
    int pitch = count + 2;
    float *line = scratch;
    for (int dy = 0; dy < 3; dy++)
        luminance_row(in, y + dy - 1, x0, count, scratch + 3 * pitch, line + dy * pitch);
    for (int i = 0; i < count; i++) {
        float mean = 0, square = 0;
        for (int dy = 0; dy < 3; dy++)
            for (int dx = 0; dx < 3; dx++)
                mean += line[dy * pitch + i + dx];
        mean *= 1.0f / 9.0f;
        for (int dy = 0; dy < 3; dy++)
            for (int dx = 0; dx < 3; dx++) {
                float d = line[dy * pitch + i + dx] - mean;
                square += d * d;
            }
        deviation[i] = sqrtf(square * (1.0f / 8.0f));
    }
}

/* Standard error of the irradiance's luminance; the channels of a path are taken as fully
 * correlated. */
CLONED_INLINE void standard_error_row(const struct fewray_denoise_input *in, int y, int x0,
                                      int count, float *scratch, float *out) {
    static const float weight[3] = {0.2126f, 0.7152f, 0.0722f};
    float *variance = scratch, *albedo = scratch + count;
    memset(out, 0, sizeof(float) * (size_t)count);
    for (int c = 0; c < 3; c++) {
        gather(&in->variance, c, in->width, y, x0, count, 0.0f, variance);
        shaded_albedo_row(in, c, y, x0, count, albedo);
        for (int i = 0; i < count; i++)
            out[i] += weight[c] * sqrtf(clean_variance(variance[i])) / divisor(albedo[i]);
    }
}

CLONED_INLINE float limit(float v, float bound) {
    return v > -bound ? (v < bound ? v : bound) : (v < 0.0f ? -bound : 0.0f);
}

/* The guide's irradiance and its confidence; rows (4, count). */
CLONED_INLINE void guide_rows(const struct fewray_denoise_input *in, float exposure, int y, int x0,
                              int count, float *rows) {
    size_t n = (size_t)count;
    memset(rows, 0, 4 * n * sizeof *rows);
    if (!kpn_has(&in->irradiance) || !kpn_has(&in->confidence))
        return;
    float *confidence = rows + 3 * n;
    gather(&in->confidence, 0, in->width, y, x0, count, 0.0f, confidence);
    for (size_t i = 0; i < n; i++)
        confidence[i] = limit(clean(confidence[i]), 1.0f);
    for (size_t c = 0; c < 3; c++) {
        gather(&in->irradiance, (int)c, in->width, y, x0, count, 0.0f, rows + c * n);
        for (size_t i = 0; i < n; i++)
            rows[c * n + i] =
                confidence[i] > 0.0f ? compress(clean(rows[c * n + i]) * exposure) : 0.0f;
    }
}

CLONED void kpn_feature_row(const struct fewray_denoise_input *in, const struct kpn_scale *scale,
                            int y, int x0, int count, float *scratch, float *irradiance,
                            float *features) {
    y = y < in->height ? y : in->height - 1;
    x0 = x0 < in->width ? x0 : in->width - 1;
    size_t n = (size_t)count;
    float exposure = scale->exposure;
    irradiance_row(in, y, x0, count, scratch, scratch + n, irradiance);
    for (size_t i = 0; i < 3 * n; i++)
        features[i] = compress(irradiance[i] * exposure);

    float *error = features + 3 * n;
    if (scale->has_variance)
        standard_error_row(in, y, x0, count, scratch, error);
    else
        spatial_deviation_row(in, y, x0, count, scratch, error);
    for (size_t i = 0; i < n; i++) {
        float light = exposure * luminance(irradiance[i], irradiance[n + i], irradiance[2 * n + i]);
        float ratio = exposure * error[i] / (light + 0.05f);
        error[i] = compress(ratio < 64.0f ? ratio : 64.0f);
    }

    for (int c = 0; c < 3; c++) {
        float *albedo = features + (4 + (size_t)c) * n, *normal = features + (7 + (size_t)c) * n;
        albedo_row(in, c, y, x0, count, albedo);
        gather(&in->normal, c, in->width, y, x0, count, 0.0f, normal);
        for (size_t i = 0; i < n; i++) {
            float a = clean(albedo[i]);
            albedo[i] = a < 1.0f ? a : 1.0f;
            normal[i] = limit(normal[i], 1.0f);
        }
    }

    float *depth = features + 10 * n, *emission = features + 11 * n;
    gather(&in->depth, 0, in->width, y, x0, count, 0.0f, depth);
    for (size_t i = 0; i < n; i++) {
        float d = clean(depth[i]);
        float relative =
            limit(0.5f * (log2_fast(d > 1e-18f ? d : 1e-18f) - scale->log2_depth), 2.0f);
        depth[i] = d > 1e-18f ? relative : 0.0f;
    }
    for (int c = 0; c < 3; c++)
        emission_row(in, c, y, x0, count, scratch + (size_t)c * n);
    for (size_t i = 0; i < n; i++)
        emission[i] = compress(exposure * luminance(clean(scratch[i]), clean(scratch[n + i]),
                                                    clean(scratch[2 * n + i])));
    guide_rows(in, exposure, y, x0, count, features + 12 * n);
}
