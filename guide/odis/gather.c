/* SPDX-License-Identifier: Apache-2.0 */
/* Binning of the first look. A picture has thousands of grid points with hundreds of records each:
 * sums are vectors of four floats, and logarithms are taken four bins at a time. */

#include "guide/odis/gather.h"

#include <stddef.h>
#include <string.h>

#include "guide/odis/float4.h"

#define MU         5000.0f
#define LOG_MU     8.517393171f /* log(1 + MU) */
#define LN_2       0.693147181f
#define FILL_PRIOR 1.0f  /* samples that the coarser estimate counts for against a bin's own */
#define FILL_FLOOR 1e-3f /* of the scale: no bin is taken for darker */

/* Lanes of a where the mask is all ones, else 0. */
static inline float4 keep(int4 mask, float4 a) {
    return (float4)(mask & (int4)a);
}

static inline float4 least(float4 a, float4 b) {
    return pick(a < b, a, b);
}

static inline float4 root(float4 a) {
    return (float4){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3])};
}

/* Logarithm of positive, normal x, given x - 1 as exactly as the caller knows it. x = 2^k m with
 * sqrt(1/2) <= m < sqrt(2), and log m = 2 artanh((m - 1) / (m + 1)) by four terms of the series:
 * the relative error is below 3e-7. */
static inline float4 log_near(float4 x, float4 less_one) {
    int4 bits = (int4)x, k = (bits - 0x3f3504f3) >> 23, whole = k == 0;
    float4 f = (float4)(bits - (k << 23)) - 1;
    f = (float4)((whole & (int4)less_one) | (~whole & (int4)f));
    float4 s = f / (f + 2), s2 = s * s;
    float4 series = 1 + s2 * ((1.0f / 3) + s2 * ((1.0f / 5) + s2 * (1.0f / 7)));
    return __builtin_convertvector(k, float4) * LN_2 + 2 * s * series;
}

static inline float4 log1p4(float4 x) {
    return log_near(1 + x, x);
}

static inline float4 compress4(float4 radiance) {
    return log1p4(radiance * MU) * (1 / LOG_MU);
}

float range_compress(float radiance) {
    return log1pf(MU * radiance) / LOG_MU;
}

float range_expand(float compressed) {
    return expm1f(compressed * LOG_MU) / MU;
}

/* Sums over the samples of a bin; the first two hold what lies side by side in a record. */
struct bin_sums {
    float4 normal_depth;
    float4 distance_normal; /* of the second hits */
    float4 values;          /* 1, pooled mean, pooled second moment, own second moment */
};

_Static_assert(offsetof(struct look_record, depth) ==
                   offsetof(struct look_record, normal) + 3 * sizeof(float),
               "normal and depth are read at once");
_Static_assert(offsetof(struct look_record, second_normal) ==
                   offsetof(struct look_record, distance) + sizeof(float),
               "distance and second normal are read at once");
_Static_assert(offsetof(struct look_record, emitted) ==
                   offsetof(struct look_record, radiance) + 3 * sizeof(float),
               "radiance is read with the float behind it");

/* A grid point's sums: by bin, and what the planes are made of. */
struct sums {
    struct bin_sums bins[SPHERE_BINS];
    float hits[SPHERE_BINS]; /* second hits */

    float count[SPHERE_BINS], mean[SPHERE_BINS], moment[SPHERE_BINS], own_moment[SPHERE_BINS];
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

static void add_records(const struct look_record *r, const struct look_record *end,
                        struct vec3 normal, struct sums *sums) {
    for (; r < end; r++) {
        float cos_theta = dot(r->direction, normal);
        if (!(r->depth > 0) || !(cos_theta > 0))
            continue;
        const char *bytes = (const char *)r;
        struct bin_sums *bin = &sums->bins[r->bin];
        float own = r->emitted + r->reflected;
        bin->normal_depth += load(bytes + offsetof(struct look_record, normal));
        bin->distance_normal += load(bytes + offsetof(struct look_record, distance));
        bin->values += (float4){1, r->mean, r->moment * r->moment, own * own};
        sums->hits[r->bin] += r->distance > 0 ? 1.0f : 0.0f;
    }
}

static void add_blocks(const struct fewray_look *look, int i0, int j0, int i1, int j1,
                       struct vec3 normal, struct sums *sums) {
    int x0 = clamp_int(i0 * BLOCK_SIZE, 0, look->width);
    int x1 = clamp_int(i1 * BLOCK_SIZE, x0, look->width);
    int y0 = clamp_int(j0 * BLOCK_SIZE, 0, look->height);
    int y1 = clamp_int(j1 * BLOCK_SIZE, y0, look->height);
    size_t samples = (size_t)look->samples, count = (size_t)(x1 - x0) * samples;
    for (int y = y0; y < y1; y++) {
        const struct look_record *r =
            look->records + ((size_t)y * (size_t)look->width + (size_t)x0) * samples;
        add_records(r, r + count, normal, sums);
    }
}

/* Lays out the values plane by plane; returns the mean pooled radiance over the filled bins. */
static float split_values(struct sums *sums, struct gathered *out) {
    float4 filled = splat(0), radiance = splat(0);
    for (int b = 0; b < SPHERE_BINS; b += 4) {
        const struct bin_sums *bin = sums->bins + b;
        float4 v[4] = {bin[0].values, bin[1].values, bin[2].values, bin[3].values};
        transpose(v);
        store(sums->count + b, v[0]);
        store(sums->mean + b, v[1]);
        store(sums->moment + b, v[2]);
        store(sums->own_moment + b, v[3]);
        int4 mask = (v[0] > 0) & (load(out->cosine + b) > 0);
        float4 one = keep(mask, splat(1));
        store(out->mask + b, one);
        filled += one;
        radiance += keep(mask, v[1] / (v[0] + (1 - one)));
    }
    float count = (filled[0] + filled[1]) + (filled[2] + filled[3]);
    return count > 0 ? ((radiance[0] + radiance[1]) + (radiance[2] + radiance[3])) / count : 0;
}

/* The planes of bins b to b + 3. */
static inline void fill_planes(const struct sums *sums, int b, float inverse_scale,
                               float inverse_depth, struct gathered *out) {
    const struct bin_sums *bin = sums->bins + b;
    float4 first[4] = {bin[0].normal_depth, bin[1].normal_depth, bin[2].normal_depth,
                       bin[3].normal_depth};
    float4 second[4] = {bin[0].distance_normal, bin[1].distance_normal, bin[2].distance_normal,
                        bin[3].distance_normal};
    transpose(first);
    transpose(second);
    /* zeros divided by the small number that stands for none stay zeros */
    float4 count = load(sums->count + b), hits = load(sums->hits + b);
    int4 mask = load(out->mask + b) > 0;
    float4 n = keep(mask, 1 / (count + 1e-20f)), h = keep(mask, 1 / (hits + 1e-20f));
    float4 mean = load(sums->mean + b) * n;
    float4 moment = root(load(sums->moment + b) * n), own = root(load(sums->own_moment + b) * n);
    float(*plane)[SPHERE_BINS] = out->planes;
    store(plane[GATHER_RADIANCE] + b, compress4(mean * inverse_scale));
    store(plane[GATHER_POOLED_MOMENT] + b, compress4(moment * inverse_scale));
    store(plane[GATHER_MOMENT] + b, compress4(own * inverse_scale));
    store(plane[GATHER_COUNT] + b, keep(mask, log1p4(count) * (0.25f / LN_2)));
    store(plane[GATHER_DEPTH] + b, least(first[3] * n * inverse_depth, splat(4)));
    store(plane[GATHER_DISTANCE] + b, log1p4(least(second[0] * h * inverse_depth, splat(1e4f))));
    for (int i = 0; i < 3; i++) {
        store(plane[GATHER_NORMAL + i] + b, first[i] * n);
        store(plane[GATHER_SECOND_NORMAL + i] + b, second[1 + i] * h);
    }
}

/* Sums of 2 x 2: a (size, size) level to a (size / 2, size / 2) one. */
static inline void pull(const float *restrict fine, int size, float *restrict coarse) {
    for (int y = 0; y < size / 2; y++, fine += 2 * size, coarse += size / 2)
        for (int x = 0; x < size / 2; x++)
            coarse[x] =
                (fine[2 * x] + fine[2 * x + 1]) + (fine[size + 2 * x] + fine[size + 2 * x + 1]);
}

/* Means of a (size, size) level, drawn towards the coarser one's as if that were FILL_PRIOR
 * samples. */
static inline void push(const float *restrict count, const float *restrict sum, int size,
                        const float *restrict coarse, float *restrict mean) {
    for (int y = 0; y < size; y++)
        for (int x = 0; x < size / 2; x++) {
            int i = y * size + 2 * x;
            float prior = FILL_PRIOR * coarse[y / 2 * (size / 2) + x];
            mean[i] = (sum[i] + prior) / (count[i] + FILL_PRIOR);
            mean[i + 1] = (sum[i + 1] + prior) / (count[i + 1] + FILL_PRIOR);
        }
}

/* Push-pull over a pyramid of 2 x 2 bins. */
static void fill_holes(const struct sums *sums, struct gathered *out) {
    enum { LEVELS = 6 }; /* 32 x 32 bins down to 1 */
    float counts[LEVELS][SPHERE_BINS / 4], moments[LEVELS][SPHERE_BINS / 4];
    float mean[LEVELS][SPHERE_BINS];
    const float *count = sums->count, *moment = sums->moment;
    for (int l = 1, size = SPHERE_ROWS; l < LEVELS; l++, size /= 2) {
        pull(count, size, counts[l]);
        pull(moment, size, moments[l]);
        count = counts[l];
        moment = moments[l];
    }
    mean[LEVELS - 1][0] = count[0] > 0 ? moment[0] / count[0] : 0;
    for (int l = LEVELS - 2, size = 2; l > 0; l--, size *= 2)
        push(counts[l], moments[l], size, mean[l + 1], mean[l]);
    push(sums->count, sums->moment, SPHERE_ROWS, mean[1], mean[0]);
    float inverse_scale = 1 / out->scale;
    for (int b = 0; b < SPHERE_BINS; b += 4) {
        float4 x = root(load(mean[0] + b)) * inverse_scale + FILL_FLOOR;
        store(out->fill + b, log_near(x, x - 1));
    }
}

void gather(const struct fewray_look *look, int i0, int j0, int i1, int j1, int x, int y,
            struct gathered *out) {
    float point_depth;
    out->valid = false;
    if (!find_point(look, x, y, out, &point_depth))
        return;
    struct sums sums;
    memset(sums.bins, 0, sizeof(sums.bins));
    memset(sums.hits, 0, sizeof(sums.hits));
    add_blocks(look, i0, j0, i1, j1, out->normal, &sums);
    sphere_cosines(out->normal, out->cosine);
    out->scale = split_values(&sums, out);
    if (!(out->scale > 0) || !isfinite(out->scale))
        return;
    out->valid = true;
    memset(out->planes, 0, sizeof(out->planes));
    for (int b = 0; b < SPHERE_BINS; b += 4) {
        float4 mask = load(out->mask + b);
        if (mask[0] + mask[1] + mask[2] + mask[3] > 0)
            fill_planes(&sums, b, 1 / out->scale, 1 / point_depth, out);
    }
    fill_holes(&sums, out);
}
