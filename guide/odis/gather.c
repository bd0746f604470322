/* SPDX-License-Identifier: Apache-2.0 */
/* Binning of the first look. */

#include "guide/odis/gather.h"

#include <string.h>

#define MU         5000.0f
#define FILL_PRIOR 1.0f  /* samples that the coarser estimate counts for against a bin's own */
#define FILL_FLOOR 1e-3f /* of the scale: no bin is taken for darker */

float range_compress(float radiance) {
    return log1pf(MU * radiance) / log1pf(MU);
}

float range_expand(float compressed) {
    return expm1f(compressed * log1pf(MU)) / MU;
}

/* Sums over the samples of each bin. */
struct bin_sums {
    float count, radiance, moment, depth, distance, hits;
    struct vec3 normal, second_normal;
};

static bool find_point(const struct fewray_look *look, int x, int y, struct gathered *out,
                       float *depth) {
    const struct look_record *r =
        look->records + ((size_t)y * (size_t)look->width + (size_t)x) * (size_t)look->samples;
    for (int s = 0; s < look->samples; s++)
        if (r[s].depth > 0) {
            out->position = r[s].position;
            out->normal = r[s].normal;
            *depth = r[s].depth;
            return true;
        }
    return false;
}

static void add_record(const struct look_record *r, struct bin_sums *bin) {
    bin->count += 1;
    bin->radiance += mean_component(r->radiance);
    bin->moment += r->weighted * r->weighted;
    bin->depth += r->depth;
    bin->normal = add(bin->normal, r->normal);
    if (r->distance > 0) {
        bin->hits += 1;
        bin->distance += r->distance;
        bin->second_normal = add(bin->second_normal, r->second_normal);
    }
}

static int clamp_int(int i, int low, int high) {
    return i < low ? low : i > high ? high : i;
}

/* Bins all records of the window; *color gets the cosine-weighted sum of their radiance. */
static void bin_window(const struct fewray_look *look, int x, int y, const struct gathered *point,
                       struct bin_sums bins[SPHERE_BINS], struct vec3 *color) {
    int half = look->samples < 8 ? 10 : 5;
    int x0 = clamp_int(x - half, 0, look->width - 1), x1 = clamp_int(x + half, 0, look->width - 1);
    int y0 = clamp_int(y - half, 0, look->height - 1),
        y1 = clamp_int(y + half, 0, look->height - 1);
    for (int j = y0; j <= y1; j++) {
        size_t row = (size_t)j * (size_t)look->width;
        const struct look_record *r = look->records + (row + (size_t)x0) * (size_t)look->samples;
        const struct look_record *end =
            look->records + (row + (size_t)x1 + 1) * (size_t)look->samples;
        for (; r < end; r++) {
            float cos_theta = dot(r->direction, point->normal);
            if (!(r->depth > 0) || !(cos_theta > 0))
                continue;
            add_record(r, &bins[sphere_bin(r->direction)]);
            *color = add(*color, scale(r->radiance, cos_theta));
        }
    }
}

static void fill_planes(const struct bin_sums *bin, int b, float inverse_scale, float point_depth,
                        struct gathered *out) {
    float n = 1 / bin->count;
    out->mask[b] = 1;
    out->planes[GATHER_RADIANCE][b] = range_compress(bin->radiance * n * inverse_scale);
    out->planes[GATHER_MOMENT][b] = range_compress(sqrtf(bin->moment * n) * inverse_scale);
    out->planes[GATHER_DEPTH][b] = fminf(bin->depth * n / point_depth, 4);
    out->planes[GATHER_NORMAL][b] = bin->normal.x * n;
    out->planes[GATHER_NORMAL + 1][b] = bin->normal.y * n;
    out->planes[GATHER_NORMAL + 2][b] = bin->normal.z * n;
    if (bin->hits > 0) {
        float h = 1 / bin->hits;
        out->planes[GATHER_DISTANCE][b] = log1pf(fminf(bin->distance * h / point_depth, 1e4f));
        out->planes[GATHER_SECOND_NORMAL][b] = bin->second_normal.x * h;
        out->planes[GATHER_SECOND_NORMAL + 1][b] = bin->second_normal.y * h;
        out->planes[GATHER_SECOND_NORMAL + 2][b] = bin->second_normal.z * h;
    }
}

/* Push-pull over a pyramid of 2 x 2 bins: each level's estimate is drawn towards the coarser one's
 * as if that were FILL_PRIOR samples. count and sum are (size, size) and hold the samples and their
 * summed second moments; estimate gets the filled mean. */
static void fill_level(const float *count, const float *sum, int size, float *estimate) {
    if (size == 1) {
        estimate[0] = count[0] > 0 ? sum[0] / count[0] : 0;
        return;
    }
    int half = size / 2;
    float coarse_count[SPHERE_BINS / 4] = {0}, coarse_sum[SPHERE_BINS / 4] = {0};
    float coarse[SPHERE_BINS / 4];
    for (int y = 0; y < half; y++)
        for (int x = 0; x < half; x++) {
            int i = 2 * y * size + 2 * x;
            coarse_count[y * half + x] =
                count[i] + count[i + 1] + count[i + size] + count[i + size + 1];
            coarse_sum[y * half + x] = sum[i] + sum[i + 1] + sum[i + size] + sum[i + size + 1];
        }
    fill_level(coarse_count, coarse_sum, half, coarse);
    for (int y = 0; y < size; y++)
        for (int x = 0; x < size; x++) {
            int i = y * size + x;
            estimate[i] =
                (sum[i] + FILL_PRIOR * coarse[y / 2 * half + x / 2]) / (count[i] + FILL_PRIOR);
        }
}

static void fill_holes(const struct bin_sums bins[SPHERE_BINS], struct gathered *out) {
    float count[SPHERE_BINS], sum[SPHERE_BINS], estimate[SPHERE_BINS];
    for (int b = 0; b < SPHERE_BINS; b++) {
        count[b] = bins[b].count;
        sum[b] = bins[b].moment;
    }
    fill_level(count, sum, SPHERE_ROWS, estimate);
    for (int b = 0; b < SPHERE_BINS; b++)
        out->fill[b] = logf(sqrtf(estimate[b]) / out->scale + FILL_FLOOR);
}

/* Cosine of each bin's centre to the normal, 0 below the horizon; a sine a column instead of one a
 * bin. */
static void fill_cosines(struct vec3 normal, float cosine[SPHERE_BINS]) {
    float x[SPHERE_COLUMNS], z[SPHERE_COLUMNS];
    for (int c = 0; c < SPHERE_COLUMNS; c++) {
        float phi = ((float)c + 0.5f) * (2 * PI_F / SPHERE_COLUMNS);
        x[c] = sinf(phi);
        z[c] = cosf(phi);
    }
    for (int row = 0; row < SPHERE_ROWS; row++) {
        float y = 1 - ((float)row + 0.5f) * (2.0f / SPHERE_ROWS), r = sqrtf(fmaxf(0, 1 - y * y));
        for (int c = 0; c < SPHERE_COLUMNS; c++)
            cosine[row * SPHERE_COLUMNS + c] = fmaxf(0, dot(normal, vec(r * x[c], y, r * z[c])));
    }
}

void gather(const struct fewray_look *look, int x, int y, struct gathered *out) {
    memset(out, 0, sizeof(*out));
    float point_depth;
    if (!find_point(look, x, y, out, &point_depth))
        return;
    struct bin_sums bins[SPHERE_BINS] = {0};
    struct vec3 color = vec(0, 0, 0);
    bin_window(look, x, y, out, bins, &color);
    fill_cosines(out->normal, out->cosine);
    float filled = 0, radiance = 0;
    for (int b = 0; b < SPHERE_BINS; b++) {
        if (bins[b].count > 0 && out->cosine[b] > 0) {
            filled += 1;
            radiance += bins[b].radiance / bins[b].count;
        }
    }
    if (!(radiance > 0) || !isfinite(radiance))
        return;
    out->valid = true;
    out->scale = radiance / filled;
    float mean = mean_component(color);
    out->tint = mean > 0 ? scale(color, 1 / mean) : vec(1, 1, 1);
    for (int b = 0; b < SPHERE_BINS; b++)
        if (bins[b].count > 0 && out->cosine[b] > 0)
            fill_planes(&bins[b], b, 1 / out->scale, point_depth, out);
    fill_holes(bins, out);
}
