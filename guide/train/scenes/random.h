/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_RANDOM_H
#define FEWRAY_TRAIN_RANDOM_H

/* Random numbers of the scene generator: PCG32 (O'Neill 2014), the same sequence on every machine.
 */

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

struct random {
    uint64_t state;
};

static inline uint32_t random_bits(struct random *r) {
    uint64_t old = r->state;
    r->state = old * 6364136223846793005ULL + 1442695040888963407ULL;
    uint32_t xorshifted = (uint32_t)(((old >> 18) ^ old) >> 27), rotation = (uint32_t)(old >> 59);
    return (xorshifted >> rotation) | (xorshifted << ((32 - rotation) & 31));
}

static inline struct random random_seed(uint64_t seed, uint64_t stream) {
    struct random r = {seed * 0x9E3779B97F4A7C15ULL + stream * 0xD1B54A32D192ED03ULL +
                       0x632BE5ABULL};
    for (int i = 0; i < 4; i++)
        random_bits(&r);
    return r;
}

static inline float uniform(struct random *r, float low, float high) {
    return low + (high - low) * (float)(random_bits(r) >> 8) * 0x1p-24f;
}
/* Evenly spread over the orders of magnitude; low > 0. */
static inline float log_uniform(struct random *r, float low, float high) {
    return expf(uniform(r, logf(low), logf(high)));
}
/* Both ends included. */
static inline int between(struct random *r, int low, int high) {
    return low + (int)(random_bits(r) % (uint32_t)(high - low + 1));
}
static inline bool chance(struct random *r, float probability) {
    return uniform(r, 0, 1) < probability;
}

#endif
