/* SPDX-License-Identifier: Apache-2.0 */
/* The convolution of kernels.inc.h. */

/* A tile of a row of output pixels times some blocks of output channels stays in registers while
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

/* Half a block's vector: two fit into a block at least. */
#if VEC_LANES > 8
typedef float half_vec __attribute__((vector_size(32), may_alias));
#else
typedef vec half_vec;
#endif

#define TILE_NAME   whole_tile
#define TILE_VEC    vec
#define TILE_VECS   VECS
#define TILE_PIXELS MAX_PIXELS
#define TILE_BLOCKS MAX_BLOCKS
#include "denoise/nn/conv_tile.inc.h"

#define TILE_NAME   half_tile
#define TILE_VEC    half_vec
#define TILE_VECS   (NN_LANES * 4 / 2 / (int)sizeof(half_vec))
#define TILE_PIXELS MAX_HALF_PIXELS
#define TILE_BLOCKS 1
#include "denoise/nn/conv_tile.inc.h"

typedef void tile_function(const struct tile_job *job);
#define TILE(name, pixels, blocks)                                                                 \
    static void name##_##pixels##x##blocks(const struct tile_job *job) {                           \
        name##_tile(job, pixels, blocks);                                                          \
    }
/* OF(1) ... OF(n) */
#define TO_2(OF)  OF(1) OF(2)
#define TO_4(OF)  TO_2(OF) OF(3) OF(4)
#define TO_6(OF)  TO_4(OF) OF(5) OF(6)
#define TO_12(OF) TO_6(OF) OF(7) OF(8) OF(9) OF(10) OF(11) OF(12)
#define TO_14(OF) TO_12(OF) OF(13) OF(14)
#if MAX_PIXELS == 14
#define TILES      TO_14
#define HALF_TILES TO_14
#elif MAX_PIXELS == 6
#define TILES      TO_6
#define HALF_TILES TO_12
#else
#define TILES      TO_2
#define HALF_TILES TO_4
#endif
#define TILE_HALF(pixels) TILE(half, pixels, 1)
#define NAME_HALF(pixels) half_##pixels##x1,
#define TILE_1(pixels)    TILE(whole, pixels, 1)
#define NAME_1(pixels)    whole_##pixels##x1,
#define TILE_2(pixels)    TILE(whole, pixels, 2)
#define NAME_2(pixels)    whole_##pixels##x2,
HALF_TILES(TILE_HALF)
TILES(TILE_1)
#if MAX_BLOCKS > 1
TILES(TILE_2)
#endif

static tile_function *const half_functions[MAX_HALF_PIXELS] = {HALF_TILES(NAME_HALF)};
static tile_function *const whole_functions[MAX_BLOCKS][MAX_PIXELS] = {
    {TILES(NAME_1)},
#if MAX_BLOCKS > 1
    {TILES(NAME_2)},
#endif
};

/* A row in tiles of nearly the same width: the first `wider` ones have a pixel more. */
static void conv_row(struct tile_job job, tile_function *const *functions, int width,
                     int max_pixels) {
    const int tiles = (width + max_pixels - 1) / max_pixels;
    const int narrow = width / tiles, wider = width % tiles;
    for (int t = 0; t < tiles; ++t) {
        int pixels = narrow + (t < wider);
        functions[pixels - 1](&job);
        job.in += (size_t)pixels * job.in_pixel;
        job.out += (size_t)pixels * job.out_pixel;
    }
}

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

    for (int y = y0; y < y1; ++y)
        for (int channel = 0; channel < conv->out_used;) {
            int blocks = (conv->out_used - channel) / NN_LANES;
            blocks = blocks > MAX_BLOCKS ? MAX_BLOCKS : blocks;
            job.weights = conv->weights + (size_t)(channel / NN_LANES) * job.block_weights;
            job.bias = conv->bias + channel;
            job.in = nn_at(in, y - reach, -reach);
            job.out = nn_at(out, y, 0) + channel;
            if (blocks > 0)
                conv_row(job, whole_functions[blocks - 1], width, MAX_PIXELS);
            else
                conv_row(job, half_functions, width, MAX_HALF_PIXELS);
            channel += blocks > 0 ? blocks * NN_LANES : NN_LANES;
        }
}
