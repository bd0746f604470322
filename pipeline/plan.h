/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_PLAN_H
#define FEWRAY_PIPELINE_PLAN_H

/* How many samples a render gets, and where: decisions as pure functions of what was measured. A
 * "sample" here is one of every pixel; counts are means over the picture and may have a fraction,
 * since a pass may leave tiles out. */

#include <stdbool.h>
#include <stdint.h>

/* Error of a denoised picture falls with the samples to the power of minus this. From training
 * scenes, 4 to 64 samples a pixel: guide/NOTES.md. */
#define PLAN_SLOPE 0.6

struct plan_step {
    double more;  /* samples of the next pass; 0: the render has enough */
    bool picture; /* the pass ends with a denoised picture, from which the error is estimated */
    bool part;    /* of the way to such a picture */
};

/* Seconds, all of wall time. */
struct plan_clock {
    double total;   /* that the run may take */
    double left;    /* of them */
    double tail;    /* needed after the last sample: denoise, write, free */
    double sample;  /* a sample takes */
    double picture; /* a picture on the way takes */
    bool measured;  /* sample comes from a pass, not from a few paths of a pilot */
};

/* Samples that fit into the time, 0 or more. */
double plan_affordable(const struct plan_clock *clock);
struct plan_step plan_step_in_time(const struct plan_clock *clock, double done);
/* estimate: of the error after `done` samples; negative: not known yet. */
struct plan_step plan_step_for_error(double done, double estimate, double wanted, double most);
struct plan_step plan_step_for_samples(double done, double wanted);

/* Whether the guide pays within the time: gain is the noise without over that with it. */
bool plan_guide_fits(const struct plan_clock *clock, double guide_seconds, double gain);

/* Cells of PLAN_CELL pixels; a tile has four of them. */
#define PLAN_CELL 8

/* A tile's need: mean of the cells whose middle is 2 to 4 cells from the tile's. Its own cells
 * and those right beside it are left out: a count that depends on the very samples that it
 * multiplies would bias them (Kirk and Arvo 1991, "Unbiased Sampling Techniques for Image
 * Synthesis"). cells: (rows, columns), expected error of a cell after one sample; tiles: (rows of
 * tiles, columns of tiles). */
void plan_needs(const float *cells, int columns, int rows, float *tiles, int tile_columns,
                int tile_rows);
/* Deals `more` samples in the mean out to tiles so that the summed error need n^-PLAN_SLOPE
 * falls most, none less than a quarter and none more than four times the mean; needs NULL: evenly.
 * have, out: samples a pixel of each tile. salt: of the rounding to whole samples. */
void plan_deal(const float *needs, const int *have, int tiles, double more, uint32_t salt,
               int *out);

/* What the difference of two pictures tells of the later one's error, where samples grew from
 * `before` to `after`: if the samples' means are independent, the variance of the later is the
 * squared difference times this. 0: nothing, there were too few new ones. */
double plan_change_factor(double before, double after);

#endif
