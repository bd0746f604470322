/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels' one source, compiled once for each instruction set by kernels_*.c, which define
 *   VEC_LANES             floats of a vector: 4, 8 or 16
 *   MAX_PIXELS            pixels of the largest register block: 2, 6 or 14
 *   MAX_BLOCKS            blocks of NN_LANES output channels in it: 1 or 2
 *   KERNELS, KERNELS_ISA, KERNELS_NAME   the table and what it says of itself.
 * a * b + c becomes one instruction where the compile options have FMA. */

#include <assert.h>
#include <float.h>
#include <string.h>
#if VEC_LANES > 4
#include <immintrin.h>
#endif

#include "denoise/nn/kernels.h"

#define VECS   (NN_LANES / VEC_LANES) /* vectors of a block of output channels */
#define INLINE static inline __attribute__((always_inline))
#define UNROLL _Pragma("GCC unroll 32")

typedef float vec __attribute__((vector_size(VEC_LANES * 4), may_alias));
typedef int32_t ivec __attribute__((vector_size(VEC_LANES * 4), may_alias));

INLINE vec splat(float x) {
    return x - (vec){0};
}
INLINE vec pick(ivec mask, vec a, vec b) {
    return (vec)((mask & (ivec)a) | (~mask & (ivec)b));
}

/* --- convolution
 *
 * A tile of a row of output pixels times some blocks of output channels stays in registers while
 * the loops run over the taps and input channels: each step multiplies one row of weights by one
 * input of each pixel. Every output is bias + the products in the order (ky, kx, channel), wherever
 * it lies in its tile, so that all ways to cut the work give the same bits. */

struct tile_job {
    const float *in;      /* the upper left tap of the first pixel */
    size_t in_pixel;      /* floats from pixel to pixel */
    size_t in_row;        /* and from row to row */
    int runs;             /* stretches of a tap row that are contiguous in memory: 1 or kernel */
    int run_length;       /* floats of a run */
    int kernel;           /* 1 or 3 */
    const float *weights; /* of the first block */
    size_t run_weights;   /* floats from run to run */
    size_t block_weights; /* and from block to block */
    const float *bias;
    float *out;
    size_t out_pixel;
    enum nn_activation activation;
};

INLINE vec activate(vec x, enum nn_activation activation) {
    if (activation == NN_LEAKY_RELU)
        x *= pick(x > 0.0f, splat(1.0f), splat(0.2f));
    return x;
}

INLINE void conv_tile(const struct tile_job *job, const int pixels, const int blocks) {
    enum { GROUP = 3, MAX_GROUPS = (MAX_PIXELS + GROUP - 1) / GROUP };
    const int vecs = blocks * VECS;
    vec sum[MAX_PIXELS][MAX_BLOCKS * VECS];
    UNROLL for (int v = 0; v < vecs; ++v) {
        vec bias = ((const vec *)job->bias)[v];
        UNROLL for (int p = 0; p < pixels; ++p) sum[p][v] = bias;
    }

    const float *weights = job->weights;
    const size_t in_pixel = job->in_pixel, block_weights = job->block_weights;
    const int run_length = job->run_length;
    for (int ky = 0; ky < job->kernel; ++ky) {
        const float *run_in = job->in + (size_t)ky * job->in_row;
        for (int run = 0; run < job->runs; ++run) {
            /* One base address for three pixels: base, base + pixel, base + 2 * pixel are
             * addressing modes, so that all pixels need few registers. The empty asm keeps
             * compilers from deriving the bases from each other again. */
            const float *base[MAX_GROUPS];
            UNROLL for (int g = 0; g * GROUP < pixels; ++g) {
                base[g] = run_in + (size_t)(g * GROUP) * in_pixel;
                __asm__("" : "+r"(base[g]));
            }
            const float *w = weights;
            for (int i = 0; i < run_length; ++i) {
                vec row[MAX_BLOCKS * VECS];
                UNROLL for (int v = 0; v < vecs; ++v) row[v] =
                    ((const vec *)(w + (v >= VECS ? block_weights : 0)))[v % VECS];
                w += NN_LANES;
                UNROLL for (int p = 0; p < pixels; ++p) {
                    float x = base[p / GROUP][i + (p % GROUP) * in_pixel];
                    UNROLL for (int v = 0; v < vecs; ++v) sum[p][v] += row[v] * x;
                }
            }
            run_in += in_pixel;
            weights += job->run_weights;
        }
    }

    UNROLL for (int p = 0; p < pixels; ++p) {
        vec *out = (vec *)(job->out + (size_t)p * job->out_pixel);
        UNROLL for (int v = 0; v < vecs; ++v) out[v] = activate(sum[p][v], job->activation);
    }
}

typedef void tile_function(const struct tile_job *job);
#define TILE(pixels, blocks)                                                                       \
    static void tile_##pixels##x##blocks(const struct tile_job *job) {                             \
        conv_tile(job, pixels, blocks);                                                            \
    }
/* OF(1) ... OF(MAX_PIXELS) */
#define TO_2(OF)  OF(1) OF(2)
#define TO_6(OF)  TO_2(OF) OF(3) OF(4) OF(5) OF(6)
#define TO_14(OF) TO_6(OF) OF(7) OF(8) OF(9) OF(10) OF(11) OF(12) OF(13) OF(14)
#if MAX_PIXELS == 14
#define TILES TO_14
#elif MAX_PIXELS == 6
#define TILES TO_6
#else
#define TILES TO_2
#endif
#define TILE_1(pixels) TILE(pixels, 1)
#define NAME_1(pixels) tile_##pixels##x1,
TILES(TILE_1)
#if MAX_BLOCKS > 1
#define TILE_2(pixels) TILE(pixels, 2)
#define NAME_2(pixels) tile_##pixels##x2,
TILES(TILE_2)
#endif

static tile_function *const tile_functions[MAX_BLOCKS][MAX_PIXELS] = {
    {TILES(NAME_1)},
#if MAX_BLOCKS > 1
    {TILES(NAME_2)},
#endif
};

static void conv(const struct nn_conv *conv, const struct nn_tensor *in,
                 const struct nn_tensor *out, enum nn_activation activation, int y0, int y1) {
    assert(in->channels >= conv->in && out->channels >= conv->out);
    assert(in->height == out->height && in->width == out->width);
    const int kernel = conv->kernel, reach = kernel / 2, width = out->width;
    struct tile_job job = {
        .in_pixel = (size_t)in->channels,
        .in_row = (size_t)(in->width + 2) * (size_t)in->channels,
        .runs = kernel,
        .run_length = conv->in_used,
        .kernel = kernel,
        .run_weights = (size_t)conv->in * NN_LANES,
        .block_weights = (size_t)(kernel * kernel * conv->in) * NN_LANES,
        .out_pixel = (size_t)out->channels,
        .activation = activation,
    };
    if (conv->in_used == in->channels) { /* a row of taps is contiguous */
        job.runs = 1;
        job.run_length *= kernel;
        job.run_weights *= (size_t)kernel;
    }

    /* Tiles of nearly the same width: the first `wider` ones have a pixel more. */
    const int tiles = (width + MAX_PIXELS - 1) / MAX_PIXELS;
    const int narrow = width / tiles, wider = width % tiles;
    for (int y = y0; y < y1; ++y)
        for (int block = 0; block * NN_LANES < conv->out;) {
            int blocks = conv->out / NN_LANES - block;
            blocks = blocks > MAX_BLOCKS ? MAX_BLOCKS : blocks;
            job.weights = conv->weights + (size_t)block * job.block_weights;
            job.bias = conv->bias + block * NN_LANES;
            job.in = nn_at(in, y - reach, -reach);
            job.out = nn_at(out, y, 0) + block * NN_LANES;
            for (int t = 0; t < tiles; ++t) {
                int pixels = narrow + (t < wider);
                tile_functions[blocks - 1][pixels - 1](&job);
                job.in += (size_t)pixels * job.in_pixel;
                job.out += (size_t)pixels * job.out_pixel;
            }
            block += blocks;
        }
}

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
    vec largest = tail;
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

const struct nn_kernels KERNELS = {
    .isa = KERNELS_ISA,
    .name = KERNELS_NAME,
    .conv = conv,
    .average_pool = average_pool,
    .upsample_add = upsample_add,
    .softmax = softmax,
    .softmax_rows = softmax_rows,
};
