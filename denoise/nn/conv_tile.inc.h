/* SPDX-License-Identifier: Apache-2.0 */
/* A register tile of a convolution: some pixels of a row times some output channels. Included by
 * conv.inc.h for whole and for half blocks of channels, with
 *   TILE_NAME     the function
 *   TILE_VEC      the vector type
 *   TILE_VECS     vectors of a block of channels
 *   TILE_PIXELS   the most pixels, TILE_BLOCKS the most blocks. */

INLINE void TILE_NAME(const struct tile_job *job, const int pixels, const int blocks) {
    enum { GROUP = 3, GROUPS = (TILE_PIXELS + GROUP - 1) / GROUP };
    const int vecs = blocks * TILE_VECS;
    TILE_VEC sum[TILE_PIXELS][TILE_BLOCKS * TILE_VECS];
    UNROLL for (int v = 0; v < vecs; ++v) {
        TILE_VEC bias = ((const TILE_VEC *)job->bias)[v];
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
            const float *base[GROUPS];
            UNROLL for (int g = 0; g * GROUP < pixels; ++g) {
                base[g] = run_in + (size_t)(g * GROUP) * in_pixel;
                __asm__("" : "+r"(base[g]));
            }
            const float *w = weights;
            for (int i = 0; i < run_length; ++i) {
                TILE_VEC row[TILE_BLOCKS * TILE_VECS];
                UNROLL for (int v = 0; v < vecs; ++v) row[v] =
                    ((const TILE_VEC *)(w + (v >= TILE_VECS ? block_weights : 0)))[v % TILE_VECS];
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
        TILE_VEC *out = (TILE_VEC *)(job->out + (size_t)p * job->out_pixel);
        UNROLL for (int v = 0; v < vecs; ++v) {
            TILE_VEC x = sum[p][v];
            if (job->activation == NN_LEAKY_RELU) {
                __typeof__(x > 0.0f) above = x > 0.0f;
                x = (TILE_VEC)((above & (__typeof__(above))x) |
                               (~above & (__typeof__(above))(x * 0.2f)));
            }
            out[v] = x;
        }
        if (blocks * TILE_VECS * sizeof(TILE_VEC) < NN_LANES * sizeof(float))
            UNROLL for (int v = 0; v < TILE_VECS; ++v) out[TILE_VECS + v] = (TILE_VEC){0};
    }
}

#undef TILE_NAME
#undef TILE_VEC
#undef TILE_VECS
#undef TILE_PIXELS
#undef TILE_BLOCKS
