/* SPDX-License-Identifier: Apache-2.0 */
/* The planner's decisions. */

#include "pipeline/plan.h"

#include <math.h>
#include <stddef.h>

#define LEAST_SHARE                                                                                \
    0.02               /* of the total time: passes shorter than this aren't worth their start     \
                        */
#define LAST_SHARE 0.1 /* of the total time: what is left in one pass, its error can't hurt */
#define FIRST_CUT                                                                                  \
    0.6 /* of the remaining time in one pass before it, so that speed is measured anew */
#define SLICE_SHARE    0.25 /* of the remaining time in one pass: another program may slow it down */
#define PICTURE_SHARE  0.1  /* of the remaining time that a picture on the way may take */
#define LEAST_GROWTH   1.125 /* of the samples between two pictures: less tells too little */
#define LEAST_MULTIPLE 0.25  /* of the mean that a tile gets */
#define MOST_MULTIPLE  4.0
#define SAFETY         1.05 /* more samples than the slope says */
#define BISECTIONS     48

double plan_affordable(const struct plan_clock *clock) {
    return clock->sample > 0 ? fmax(0, (clock->left - clock->tail) / clock->sample) : 0;
}

/* The power of two, 2 or more, at which the next picture is due. */
static double doubling(double done) {
    double target = 2;
    while (target <= done * 1.01)
        target *= 2;
    return target;
}

struct plan_step plan_step_in_time(const struct plan_clock *clock, double done) {
    const double affordable = plan_affordable(clock), target = doubling(done);
    const double more = target - done, free_seconds = clock->left - clock->tail;
    if (done < 1) /* the least that is a picture, whatever it takes */
        return (struct plan_step){.more = 1 - done};
    if (affordable * clock->sample < LEAST_SHARE * clock->total)
        return (struct plan_step){.more = 0};
    if (affordable < more) {
        const bool last = affordable * clock->sample <= LAST_SHARE * clock->total;
        return (struct plan_step){.more = last ? affordable : FIRST_CUT * affordable};
    }
    const double rest = affordable - more - clock->picture / clock->sample;
    const bool picture =
        clock->picture <= PICTURE_SHARE * free_seconds && rest >= (LEAST_GROWTH - 1) * target;
    const double slice = clock->measured ? fmax(1, SLICE_SHARE * affordable) : 1;
    return more > slice ? (struct plan_step){.more = slice, .part = true}
                        : (struct plan_step){.more = more, .picture = picture};
}

struct plan_step plan_step_for_error(double done, double estimate, double wanted, double most) {
    if ((estimate >= 0 && estimate <= wanted) || done >= most)
        return (struct plan_step){.more = 0};
    double target = doubling(done);
    if (estimate >= 0) {
        const double needed = done * pow(estimate / wanted, 1 / PLAN_SLOPE) * SAFETY;
        target = fmin(target, fmax(needed, LEAST_GROWTH * done));
    }
    return (struct plan_step){.more = fmin(target, most) - done, .picture = true};
}

struct plan_step plan_step_for_samples(double done, double wanted) {
    const double target = fmin(doubling(done), wanted);
    return (struct plan_step){.more = fmax(target - done, 0), .picture = target < wanted};
}

bool plan_guide_fits(const struct plan_clock *clock, double guide_seconds, double gain) {
    struct plan_clock guided = *clock;
    guided.left -= guide_seconds;
    return plan_affordable(&guided) * gain > plan_affordable(clock);
}

/* The tile's middle is the corner between its four cells. */
static bool is_in_ring(int dx, int dy) {
    const int distance =
        (dx < 0 ? -dx : dx) > (dy < 0 ? -dy : dy) ? (dx < 0 ? -dx : dx) : (dy < 0 ? -dy : dy);
    return distance >= 5 && distance <= 7;
}

static float mean_of_ring(const float *cells, int columns, int rows, int tile_x, int tile_y) {
    double sum = 0;
    int count = 0;
    for (int y = 2 * tile_y - 3; y <= 2 * tile_y + 4; y++)
        for (int x = 2 * tile_x - 3; x <= 2 * tile_x + 4; x++) {
            /* twice the distance of the middles, in cells */
            const int dx = 2 * x - 4 * tile_x - 1, dy = 2 * y - 4 * tile_y - 1;
            if (x < 0 || y < 0 || x >= columns || y >= rows || !is_in_ring(dx, dy))
                continue;
            sum += cells[(size_t)y * (size_t)columns + (size_t)x];
            count++;
        }
    return count ? (float)(sum / count) : 0;
}

void plan_needs(const float *cells, int columns, int rows, float *tiles, int tile_columns,
                int tile_rows) {
    for (int y = 0; y < tile_rows; y++)
        for (int x = 0; x < tile_columns; x++)
            tiles[(size_t)y * (size_t)tile_columns + (size_t)x] =
                mean_of_ring(cells, columns, rows, x, y);
}

/* Samples that tile t gets where the error is to fall alike by another sample everywhere. */
static double share_of(const float *needs, const int *have, int t, double scale, double more) {
    const double total = scale * pow(needs[t], 1 / (1 + PLAN_SLOPE));
    return fmin(fmax(total - have[t], LEAST_MULTIPLE * more), MOST_MULTIPLE * more);
}

static double dealt(const float *needs, const int *have, int tiles, double scale, double more) {
    double sum = 0;
    for (int t = 0; t < tiles; t++)
        sum += share_of(needs, have, t, scale, more);
    return sum / tiles;
}

/* The scale by which `more` are dealt; negative: the needs don't tell. */
static double find_scale(const float *needs, const int *have, int tiles, double more) {
    double low = 0, high = 1;
    for (int k = 0; k < 200 && dealt(needs, have, tiles, high, more) < more; k++)
        high *= 2;
    if (dealt(needs, have, tiles, high, more) < more)
        return -1;
    for (int k = 0; k < BISECTIONS; k++) {
        const double middle = 0.5 * (low + high);
        if (dealt(needs, have, tiles, middle, more) < more)
            low = middle;
        else
            high = middle;
    }
    return high;
}

static uint32_t hash(uint32_t x) { /* Mueller's, as in many hash tables: only dithers */
    x = ((x >> 16) ^ x) * 0x45d9f3bu;
    x = ((x >> 16) ^ x) * 0x45d9f3bu;
    return (x >> 16) ^ x;
}

void plan_deal(const float *needs, const int *have, int tiles, double more, uint32_t salt,
               int *out) {
    const double scale = needs ? find_scale(needs, have, tiles, more) : -1;
    for (int t = 0; t < tiles; t++) {
        const double share = scale > 0 ? share_of(needs, have, t, scale, more) : more;
        const double dither = hash((uint32_t)t * 0x9e3779b9u + hash(salt)) / 4294967296.0;
        /* whole numbers stay what they are, whatever their last bit */
        out[t] = (int)floor(share + 1e-9 + dither * (1 - 1e-6));
    }
}

double plan_change_factor(double before, double after) {
    return after >= LEAST_GROWTH * 0.98 * before && before > 0 ? before / (after - before) : 0;
}
