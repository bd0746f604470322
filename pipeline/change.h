/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_CHANGE_H
#define FEWRAY_PIPELINE_CHANGE_H

/* What successive pictures of one render tell of the last one's error. Where its samples doubled
 * since the picture before, each is as far from the other as the last is from the truth if errors
 * of old and new samples are independent: e.g. the variance of a mean of 2 n, s^2 / 2 n, is that of
 * its difference to the mean of the first n. A denoiser's bias isn't seen so but shrinks as samples
 * come, which is; the factor CHANGE_BIAS stands for what this leaves out. */

#include "fewray/features.h"

/* True error over the change's with n samples a pixel: CHANGE_BIAS (n / 4)^CHANGE_GROWTH, fitted to
 * six training scenes at 4 to 64 of them; see guide/NOTES.md. Without a denoiser there is no bias.
 */
#define CHANGE_BIAS   1.2
#define CHANGE_GROWTH 0.27

struct change {
    int width, height;           /* pixels */
    int columns, rows;           /* cells of PLAN_CELL pixels */
    int tile_columns, tile_rows; /* tiles of FEWRAY_TILE_SIZE pixels */
    float *before;               /* (3, height, width) the last picture; not known if count is 0 */
    int *tile_before;            /* (tile_rows, tile_columns) samples a pixel that it had */
    float *cells;                /* (rows, columns) expected error (mrse, bounded) of a cell after
                                    one sample a pixel; from the second picture on */
    int count;                   /* pictures seen */
    double error;                /* mrse of the last; negative: not known */
};

/* *out is owned by the caller. */
int change_create(int width, int height, struct change **out, struct fewray_error *error);
void change_destroy(struct change **change);

/* Takes in the next picture, R, G, B of frame; tile_samples: samples a pixel of each tile;
 * denoised: whether it is smooth, so that its own value tells how bright a pixel is. Same result on
 * any number of threads. */
void change_see(struct change *change, const struct fewray_frame *frame, const int *tile_samples,
                bool denoised);

#endif
