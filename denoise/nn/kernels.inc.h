/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels' one source, compiled once for each instruction set by kernels_*.c, which define
 *   VEC_LANES             floats of a vector: 4, 8 or 16
 *   MAX_PIXELS            pixels of the largest register block: 2, 6 or 14
 *   MAX_BLOCKS            blocks of NN_LANES output channels in it: 1 or 2
 *   MAX_HALF_PIXELS       pixels of the largest register block of NN_LANES / 2 channels: 4, 12, 14
 *   KERNELS, KERNELS_ISA, KERNELS_NAME   the table and what it says of itself.
 * a * b + c becomes one instruction where the compile options have FMA. */

#include <assert.h>
#include <float.h>
#include <string.h>
#if VEC_LANES > 4
#include <immintrin.h>
#endif

#include "denoise/nn/kernels.h"

#define SOFTMAX_ROWS 8                      /* softmaxed together; even */
#define VECS         (NN_LANES / VEC_LANES) /* vectors of a block of output channels */
#define INLINE       static inline __attribute__((always_inline))
#define UNROLL       _Pragma("GCC unroll 32")

typedef float vec __attribute__((vector_size(VEC_LANES * 4), may_alias));
typedef int32_t ivec __attribute__((vector_size(VEC_LANES * 4), may_alias));

INLINE vec splat(float x) {
    return x - (vec){0};
}
INLINE vec pick(ivec mask, vec a, vec b) {
    return (vec)((mask & (ivec)a) | (~mask & (ivec)b));
}

#include "denoise/nn/conv.inc.h"

/* --- between the scales of a U-Net */

static void average_pool(const struct nn_tensor *in, const struct nn_tensor *out, int y0, int y1) {
    assert(in->channels == out->channels);
    assert(in->height == 2 * out->height && in->width == 2 * out->width);
    const int vecs = out->channels / VEC_LANES;
    for (int y = y0; y < y1; ++y)
        for (int x = 0; x < out->width; ++x) {
            const vec *a = (const vec *)nn_at(in, 2 * y, 2 * x), *b = a + vecs;
            const vec *c = (const vec *)nn_at(in, 2 * y + 1, 2 * x), *d = c + vecs;
            vec *mean = (vec *)nn_at(out, y, x);
            for (int v = 0; v < vecs; ++v)
                mean[v] = ((a[v] + b[v]) + (c[v] + d[v])) * 0.25f;
        }
}

static void upsample_add(const struct nn_tensor *in, const struct nn_tensor *out, int y0, int y1) {
    assert(in->channels == out->channels);
    assert(out->height == 2 * in->height && out->width == 2 * in->width);
    const int vecs = out->channels / VEC_LANES;
    for (int y = y0; y < y1; ++y)
        for (int x = 0; x < in->width; ++x) {
            const vec *add = (const vec *)nn_at(in, y / 2, x);
            vec *left = (vec *)nn_at(out, y, 2 * x), *right = left + vecs;
            for (int v = 0; v < vecs; ++v) {
                left[v] += add[v];
                right[v] += add[v];
            }
        }
}

/* --- softmax */

INLINE vec load(const float *from) {
    vec x;
    memcpy(&x, from, sizeof x);
    return x;
}

INLINE void store(float *to, vec x) {
    memcpy(to, &x, sizeof x);
}

/* load_some() reads the first count floats only, 0 < count < VEC_LANES; the other lanes are
 * -FLT_MAX. */
#if VEC_LANES == 16
INLINE vec larger(vec a, vec b) {
    return (vec)_mm512_max_ps((__m512)a, (__m512)b);
}
INLINE vec load_some(const float *from, int count) {
    return (vec)_mm512_mask_loadu_ps(_mm512_set1_ps(-FLT_MAX), (__mmask16)((1u << count) - 1),
                                     from);
}
#elif VEC_LANES == 8
INLINE vec larger(vec a, vec b) {
    return (vec)_mm256_max_ps((__m256)a, (__m256)b);
}
INLINE vec load_some(const float *from, int count) {
    ivec mask = (ivec){0, 1, 2, 3, 4, 5, 6, 7} < count;
    return pick(mask, (vec)_mm256_maskload_ps(from, (__m256i)mask), splat(-FLT_MAX));
}
#else
INLINE vec larger(vec a, vec b) {
    return pick(a > b, a, b);
}
INLINE vec load_some(const float *from, int count) {
    return (vec){from[0], count > 1 ? from[1] : -FLT_MAX, count > 2 ? from[2] : -FLT_MAX, -FLT_MAX};
}
#endif

/* Stores the first count lanes. Not by a masked store: those make a load of the floats behind them,
 * the next row's, wait. */
INLINE void store_some(float *to, vec x, int count) {
    float lanes[VEC_LANES];
    store(lanes, x);
    int i = 0;
    for (; i + 4 <= count; i += 4)
        memcpy(to + i, lanes + i, 16);
    for (; i < count; ++i)
        to[i] = lanes[i];
}

/* e^x for -80 <= x <= 0, smaller x as -80 (no denormals later); relative error below 2e-7. e^x =
 * 2^n e^r with |r| <= ln(2) / 2 (Cody and Waite's reduction), e^r by its Taylor series to r^7. */
INLINE vec exp_negative(vec x) {
    x = larger(x, splat(-80.0f));
    const float to_integer = 0x1.8p23f; /* adding it leaves the rounded integer in the low bits */
    vec shifted = x * 0x1.715476p0f + to_integer;
    vec n = shifted - to_integer;
    vec r = x - n * 0x1.62e4p-1f; /* ln 2 in two parts; products with the first are exact */
    r = r - n * 0x1.7f7d1cp-20f;
    vec e = r * (1.0f / 5040) + (1.0f / 720);
    e = e * r + (1.0f / 120);
    e = e * r + (1.0f / 24);
    e = e * r + (1.0f / 6);
    e = e * r + 0.5f;
    e = e * r + 1.0f;
    e = e * r + 1.0f;
    return (vec)((ivec)e + ((ivec)shifted << 23));
}

typedef float quad __attribute__((vector_size(16)));
typedef int32_t iquad __attribute__((vector_size(16)));

/* The lanes, by fours, neighbouring quads combined first. */
INLINE float sum_lanes(vec x) {
    quad q[VEC_LANES / 4];
    memcpy(q, &x, sizeof x);
    UNROLL for (int half = VEC_LANES / 8; half > 0; half /= 2) {
        UNROLL for (int i = 0; i < half; ++i) q[i] += q[i + half];
    }
    return (q[0][0] + q[0][2]) + (q[0][1] + q[0][3]);
}

INLINE float largest_lane(vec x) {
    quad q[VEC_LANES / 4];
    memcpy(q, &x, sizeof x);
    UNROLL for (int i = 1; i < VEC_LANES / 4; ++i) {
        iquad more = q[i] > q[0];
        q[0] = (quad)((more & (iquad)q[i]) | (~more & (iquad)q[0]));
    }
    float a = q[0][0] > q[0][1] ? q[0][0] : q[0][1];
    float b = q[0][2] > q[0][3] ? q[0][2] : q[0][3];
    return a > b ? a : b;
}

/* What a row beyond its whole vectors holds is kept in a register: its padding lanes' e^-80 are
 * too small to change the sum, which is at least 1. */
INLINE void softmax_row(float *values, int n) {
    const int whole = n / VEC_LANES * VEC_LANES, rest = n - whole;
    vec tail = splat(-FLT_MAX);
    if (rest)
        tail = load_some(values + whole, rest);
    vec largest = larger(tail, splat(-FLT_MAX)); /* larger() drops a NaN on its left */
    for (int i = 0; i < whole; i += VEC_LANES)
        largest = larger(load(values + i), largest);
    const float maximum = largest_lane(largest);

    vec sum = {0};
    for (int i = 0; i < whole; i += VEC_LANES) {
        vec e = exp_negative(load(values + i) - maximum);
        store(values + i, e);
        sum += e;
    }
    if (rest) {
        tail = exp_negative(tail - maximum);
        sum += tail;
    }
    const float scale = 1.0f / sum_lanes(sum);
    for (int i = 0; i < whole; i += VEC_LANES)
        store(values + i, load(values + i) * scale);
    if (rest)
        store_some(values + whole, tail * scale, rest);
}

static void softmax(float *values, int n) {
    if (n > 0)
        softmax_row(values, n);
}

static void softmax_rows(float *values, int rows, int stride, int n) {
    for (int i = 0; i < rows; ++i)
        softmax(values + (size_t)i * (size_t)stride, n);
}

INLINE vec load_logits(const float *logits, const float *bias, const int n, const int v) {
    const int rest = n - v * VEC_LANES;
    logits += v * VEC_LANES;
    vec x = rest < VEC_LANES ? load_some(logits, rest) : load(logits);
    if (bias)
        x += load(bias + v * VEC_LANES);
    return x;
}

/* A few rows, n a constant. Step by step for all of them, because the steps of one row wait for
 * each other. */
INLINE void softmax_block(const float *logits, int rows, int stride, const float *bias, const int n,
                          float *weights) {
    const int vecs = (n + VEC_LANES - 1) / VEC_LANES;
    const int room = (n + NN_LANES - 1) / NN_LANES * NN_LANES;
    float maximum[SOFTMAX_ROWS], scale[SOFTMAX_ROWS];
    for (int r = 0; r < rows; ++r) {
        const float *from = logits + (size_t)r * (size_t)stride,
                    *add = bias ? bias + (r & 1) * room : NULL;
        vec largest = splat(-FLT_MAX);
        UNROLL for (int v = 0; v < vecs; ++v) largest =
            larger(load_logits(from, add, n, v), largest);
        maximum[r] = largest_lane(largest);
    }
    for (int r = 0; r < rows; ++r) {
        const float *from = logits + (size_t)r * (size_t)stride,
                    *add = bias ? bias + (r & 1) * room : NULL;
        vec sum = {0};
        UNROLL for (int v = 0; v < vecs; ++v) {
            vec e = exp_negative(load_logits(from, add, n, v) - maximum[r]);
            store(weights + r * room + v * VEC_LANES, e);
            sum += e;
        }
        scale[r] = 1.0f / sum_lanes(sum);
    }
    for (int r = 0; r < rows; ++r) {
        float *to = weights + r * room;
        UNROLL for (int v = 0; v < vecs; ++v)
            store(to + v * VEC_LANES, load(to + v * VEC_LANES) * scale[r]);
    }
}

static void softmax_to(const float *logits, int rows, int stride, const float *bias, int n,
                       float *weights) {
    const int room = (n + NN_LANES - 1) / NN_LANES * NN_LANES;
    for (int r = 0; r < rows; r += SOFTMAX_ROWS) {
        int count = rows - r < SOFTMAX_ROWS ? rows - r : SOFTMAX_ROWS;
        const float *from = logits + (size_t)r * (size_t)stride;
        float *to = weights + r * room;
        /* The taps of the denoiser's kernels, with and without a coarser level. */
        if (n == 34) {
            if (bias)
                softmax_block(from, count, stride, bias, 34, to);
            else
                softmax_block(from, count, stride, NULL, 34, to);
        } else if (n == 25 && !bias) {
            softmax_block(from, count, stride, NULL, 25, to);
        } else {
            for (int k = 0; k < count; ++k) {
                for (int i = 0; i < n; ++i)
                    to[k * room + i] = from[k * stride + i] + (bias ? bias[k % 2 * room + i] : 0);
                softmax(to + k * room, n);
            }
        }
    }
}

/* --- affinity */

typedef float key __attribute__((vector_size(NN_KEY * 4)));

/* Lane i of keys[0] becomes the sum of the lanes of keys[i]: pairs of vectors are added until one
 * is left, three times. */
INLINE void sum_lanes_of_eight(key *keys) {
    UNROLL for (int n = 4; n > 1; n /= 2) {
        UNROLL for (int i = 0; i < n; ++i) keys[i] =
            __builtin_shufflevector(keys[2 * i], keys[2 * i + 1], 0, 2, 8, 10, 4, 6, 12, 14) +
            __builtin_shufflevector(keys[2 * i], keys[2 * i + 1], 1, 3, 9, 11, 5, 7, 13, 15);
    }
    /* What is left to add lies in the other half of each vector. */
    keys[0] = __builtin_shufflevector(keys[0], keys[1], 0, 1, 2, 3, 8, 9, 10, 11) +
              __builtin_shufflevector(keys[0], keys[1], 4, 5, 6, 7, 12, 13, 14, 15);
}

INLINE void affinity_of_pixel(const struct nn_affinity *job, const int size, const float *own_key,
                              const float *first_tap, float *logits) {
    const key last = {0, 0, 0, 0, 0, 0, 0, 1}; /* where the scale is 0 */
    const int taps = size * size;
    key own, scale;
    memcpy(&own, own_key, sizeof own);
    memcpy(&scale, job->scale, sizeof scale);
    UNROLL for (int t = 0; t < taps; t += NN_KEY) {
        key terms[NN_KEY];
        const int n = taps - t < NN_KEY ? taps - t : NN_KEY;
        UNROLL for (int i = 0; i < NN_KEY; ++i) {
            terms[i] = (key){0};
            if (i < n) {
                key tap, difference;
                memcpy(&tap,
                       first_tap + (size_t)((t + i) / size) * job->taps_row +
                           (size_t)((t + i) % size) * NN_KEY,
                       sizeof tap);
                difference = own - tap;
                terms[i] = tap * last - scale * difference * difference;
            }
        }
        sum_lanes_of_eight(terms);
        if (n == NN_KEY) {
            key sum;
            memcpy(&sum, logits + t, sizeof sum);
            sum += terms[0];
            memcpy(logits + t, &sum, sizeof sum);
        } else {
            UNROLL for (int i = 0; i < n; ++i) logits[t + i] += terms[0][i];
        }
    }
}

static void add_affinity(const struct nn_affinity *job) {
    assert(job->size == 3 || job->size == 5);
    for (int i = 0; i < job->count; ++i) {
        const float *own = job->own + (size_t)i * job->own_step;
        const float *taps = job->taps + (size_t)i * job->taps_step;
        float *logits = job->logits + (size_t)i * job->pitch;
        if (job->size == 5)
            affinity_of_pixel(job, 5, own, taps, logits);
        else
            affinity_of_pixel(job, 3, own, taps, logits);
    }
}

const struct nn_kernels KERNELS = {
    .isa = KERNELS_ISA,
    .name = KERNELS_NAME,
    .conv = conv,
    .average_pool = average_pool,
    .upsample_add = upsample_add,
    .softmax = softmax,
    .softmax_rows = softmax_rows,
    .softmax_to = softmax_to,
    .add_affinity = add_affinity,
};
