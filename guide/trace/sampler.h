/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SAMPLER_H
#define FEWRAY_GUIDE_SAMPLER_H

/* Owen-scrambled Sobol points, two dimensions at a time, decorrelated between pixels and between
 * pairs of dimensions by hashed shuffling (Burley 2020, "Practical Hash-based Owen Scrambling";
 * hash by Laine and Karras 2011). */

#include <stdint.h>

struct sampler {
    uint32_t seed;      /* of the pixel */
    uint32_t index;     /* of the sample within the pixel */
    uint32_t dimension; /* pairs used so far */
};

static inline uint32_t hash_u32(uint32_t x) {
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0x735a2d97u;
    x ^= x >> 15;
    return x;
}

static inline uint32_t hash_combine(uint32_t a, uint32_t b) {
    return hash_u32(a ^ (b * 0x9e3779b9u + 0x7f4a7c15u));
}

static inline uint32_t reverse_bits(uint32_t x) {
    x = __builtin_bswap32(x);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

/* Owen scrambling of bit-reversed digits: bit i of the result depends on bits 0..i of x only. */
static inline uint32_t scramble_reversed(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* Second Sobol dimension, bit-reversed: its matrix is Pascal's triangle modulo 2, whose product is
 * a sum over supersets of bit positions (Lucas's theorem), done in five steps. */
static inline uint32_t sobol_second_reversed(uint32_t x) {
    x ^= (x >> 1) & 0x55555555u;
    x ^= (x >> 2) & 0x33333333u;
    x ^= (x >> 4) & 0x0f0f0f0fu;
    x ^= (x >> 8) & 0x00ff00ffu;
    x ^= (x >> 16) & 0x0000ffffu;
    return x;
}

/* [0, 1) */
static inline float to_unit_float(uint32_t x) {
    return (float)(x >> 8) * 0x1p-24f;
}

/* Point `index` of the (0,2)-sequence that `seed` shuffles and scrambles. */
static inline void sobol_point(uint32_t index, uint32_t seed, float u[2]) {
    uint32_t i = reverse_bits(scramble_reversed(reverse_bits(index), seed));
    u[0] = to_unit_float(reverse_bits(scramble_reversed(i, hash_combine(seed, 1))));
    u[1] = to_unit_float(
        reverse_bits(scramble_reversed(sobol_second_reversed(i), hash_combine(seed, 2))));
}

static inline struct sampler sampler_start(uint32_t seed, uint32_t index) {
    return (struct sampler){seed, index, 0};
}

/* Makes the dimensions from here on independent of those of samplers that branched otherwise. */
static inline void sampler_branch(struct sampler *s, uint32_t branch) {
    s->seed = hash_combine(s->seed, branch);
}

static inline void sampler_2d(struct sampler *s, float u[2]) {
    sobol_point(s->index, hash_combine(s->seed, s->dimension++), u);
}

static inline float sampler_1d(struct sampler *s) {
    float u[2];
    sampler_2d(s, u);
    return u[0];
}

#endif
