/* SPDX-License-Identifier: Apache-2.0 */
/* Finds the blocks that need no filter, and writes them. */

#include "denoise/kpn_blocks.h"

#include <math.h>
#include <stdlib.h>

#include "denoise/emitters.h"
#include "denoise/input_rows.h"
#include "denoise/kpn.h"
#include "denoise/kpn_layers.h"

enum { LIT = 1, EMPTY = 2, SETTLED = 4 };

/* LIT: there is light to filter. EMPTY: none, on what reflects none. SETTLED: empty, or with little
 * noise. */
static int look_at(const struct fewray_denoise_input *in, float settled_error, int y, int x) {
    static const float weight[3] = {0.2126f, 0.7152f, 0.0722f};
    bool lit = false, empty = kpn_has(&in->albedo), sound = settled_error >= 0.0f;
    float light = 0.0f, deviation = 0.0f;
    for (int c = 0; c < 3; c++) {
        float color = kpn_value(&in->color, c, y, x);
        float emission = kpn_has(&in->emission) ? kpn_value(&in->emission, c, y, x) : 0.0f;
        float albedo = empty ? kpn_value(&in->albedo, c, y, x) : 0.0f;
        if (in->emitters) {
            emitters_raise_albedo(in->emitters, y, x, 1, &albedo);
            emitters_add_emission(in->emitters, in, c, y, x, 1, &emission);
        }
        lit |= color > (emission > 0.0f ? emission : 0.0f);
        empty = empty && !(albedo > 0.0f);
        light += weight[c] * color;
        sound = sound && color >= 0.0f && color <= RADIANCE_MAX;
        if (sound) {
            float variance = kpn_value(&in->variance, c, y, x);
            sound = variance >= 0.0f;
            deviation += weight[c] * sqrtf(variance);
        }
    }
    if (!lit && empty)
        return EMPTY | SETTLED;
    bool settled = sound && lit && deviation <= settled_error * light;
    return (lit ? LIT : 0) | (settled ? SETTLED : 0);
}

/* LIT where any pixel is, EMPTY and SETTLED where all are. */
static int look_at_block(const struct fewray_denoise_input *in, float settled_error, int row,
                         int column) {
    int y1 = (row + 1) * KPN_BLOCK, x1 = (column + 1) * KPN_BLOCK;
    int any = 0, all = EMPTY | SETTLED;
    for (int y = row * KPN_BLOCK; y < y1 && y < in->height; y++)
        for (int x = column * KPN_BLOCK; x < x1 && x < in->width; x++) {
            int p = look_at(in, settled_error, y, x);
            any |= p;
            all &= p;
            if ((any & LIT) && !(all & SETTLED))
                return LIT;
        }
    return (any & LIT) | all;
}

static bool light_in_reach(const struct kpn_blocks *blocks, const unsigned char *seen, int row,
                           int column) {
    const int reach = (KPN_OVERLAP + KPN_BLOCK - 1) / KPN_BLOCK;
    for (int y = row - reach; y <= row + reach; y++)
        for (int x = column - reach; x <= column + reach; x++)
            if (y >= 0 && y < blocks->rows && x >= 0 && x < blocks->columns &&
                (seen[y * blocks->columns + x] & LIT))
                return true;
    return false;
}

static enum kpn_block_state decide(const struct kpn_blocks *blocks, const unsigned char *seen,
                                   int row, int column) {
    int block = seen[row * blocks->columns + column];
    if ((block & EMPTY) || !light_in_reach(blocks, seen, row, column))
        return KPN_BLOCK_UNLIT;
    return block & SETTLED ? KPN_BLOCK_COPY : KPN_BLOCK_FILTER;
}

int kpn_blocks_find(const struct fewray_denoise_input *in, const struct kpn_scale *scale,
                    float settled_error, int threads, struct kpn_blocks *blocks,
                    struct fewray_error *error) {
    *blocks = (struct kpn_blocks){(in->width - 1) / KPN_BLOCK + 1, (in->height - 1) / KPN_BLOCK + 1,
                                  0, NULL};
    size_t count = (size_t)blocks->columns * (size_t)blocks->rows;
    unsigned char *seen = malloc(count);
    blocks->state = malloc(count);
    if (!seen || !blocks->state) {
        free(seen);
        kpn_blocks_clear(blocks);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                           "no memory for the picture's blocks");
    }
    float bound = scale->has_variance ? settled_error : -1.0f;
#pragma omp parallel for num_threads(threads) schedule(dynamic)
    for (int row = 0; row < blocks->rows; row++)
        for (int column = 0; column < blocks->columns; column++)
            seen[row * blocks->columns + column] =
                (unsigned char)look_at_block(in, bound, row, column);
    for (int row = 0; row < blocks->rows; row++)
        for (int column = 0; column < blocks->columns; column++) {
            enum kpn_block_state state = decide(blocks, seen, row, column);
            blocks->state[row * blocks->columns + column] = (unsigned char)state;
            blocks->filtered += state == KPN_BLOCK_FILTER;
        }
    free(seen);
    return FEWRAY_OK;
}

void kpn_blocks_clear(struct kpn_blocks *blocks) {
    free(blocks->state);
    blocks->state = NULL;
}

void kpn_output_row(const struct fewray_denoise_input *in, int y, int x0, int count,
                    const float *filtered, const struct kpn_output *out) {
    float rgb[KPN_BLOCK * 3];
    for (int done = 0; done < count; done += KPN_BLOCK) {
        int n = count - done < KPN_BLOCK ? count - done : KPN_BLOCK;
        kpn_remodulate_row(in, y, x0 + done, n, filtered ? filtered + 4 * done : NULL, rgb);
        for (int c = 0; c < 3; c++) {
            float *to = out->channel[c] + y * out->row_stride + (x0 + done) * out->pixel_stride;
            for (int i = 0; i < n; i++)
                to[i * out->pixel_stride] = rgb[3 * i + c];
        }
    }
}

/* Impossible values may stand in holes of a settled block. */
static void copy_row(const struct fewray_denoise_input *in, int y, int x0, int count,
                     const struct kpn_output *out) {
    for (int c = 0; c < 3; c++)
        for (int x = x0; x < x0 + count; x++)
            out->channel[c][y * out->row_stride + x * out->pixel_stride] =
                clean(kpn_value(&in->color, c, y, x));
}

void kpn_blocks_write(const struct fewray_denoise_input *in, const struct kpn_blocks *blocks,
                      const struct kpn_output *out, int threads) {
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int y = 0; y < in->height; y++)
        for (int column = 0; column < blocks->columns; column++) {
            enum kpn_block_state state = kpn_block_at(blocks, y / KPN_BLOCK, column);
            int x = column * KPN_BLOCK;
            int count = in->width - x < KPN_BLOCK ? in->width - x : KPN_BLOCK;
            if (state == KPN_BLOCK_UNLIT)
                kpn_output_row(in, y, x, count, NULL, out);
            else if (state == KPN_BLOCK_COPY)
                copy_row(in, y, x, count, out);
            if (state != KPN_BLOCK_FILTER)
                kpn_layers_put_row(in, y, x, count, NULL, 0);
        }
}
