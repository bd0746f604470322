/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_KPN_BLOCKS_H
#define FEWRAY_DENOISE_KPN_BLOCKS_H

/* Which blocks of the picture need the network. They lie on one grid, however the picture is cut
 * for its memory, so that the result doesn't depend on that. */

#include "denoise/features_kpn.h"

#define KPN_BLOCK 64 /* pixels a side */

enum kpn_block_state {
    KPN_BLOCK_FILTER,
    KPN_BLOCK_UNLIT, /* background, or no light within the network's reach: emission alone */
    KPN_BLOCK_COPY,  /* every pixel's standard error is small: the colour as it is */
};

struct kpn_blocks {
    int columns, rows;
    int filtered;         /* number of KPN_BLOCK_FILTER */
    unsigned char *state; /* (rows, columns) of enum kpn_block_state; owned */
};

/* Where a picture goes: value c of pixel (x, y) to channel[c][y * row_stride + x * pixel_stride].
 */
struct kpn_output {
    float *channel[3];
    ptrdiff_t pixel_stride, row_stride;
};

/* settled_error: the standard error of a settled pixel's luminance is at most this part of the
 * luminance; negative: no pixel is settled by its variance. Fails only without memory. */
int kpn_blocks_find(const struct fewray_denoise_input *in, const struct kpn_scale *scale,
                    float settled_error, int threads, struct kpn_blocks *blocks,
                    struct fewray_error *error);
void kpn_blocks_clear(struct kpn_blocks *blocks);

static inline enum kpn_block_state kpn_block_at(const struct kpn_blocks *blocks, int row,
                                                int column) {
    return (enum kpn_block_state)blocks->state[row * blocks->columns + column];
}

/* Writes the pixels of all blocks that aren't filtered. */
void kpn_blocks_write(const struct fewray_denoise_input *in, const struct kpn_blocks *blocks,
                      const struct kpn_output *out, int threads);

/* Writes count pixels of row y from x0 on, (count, 4), after kpn_remodulate_row(); filtered NULL
 * means zero. */
void kpn_output_row(const struct fewray_denoise_input *in, int y, int x0, int count,
                    const float *filtered, const struct kpn_output *out);

#endif
