/* SPDX-License-Identifier: Apache-2.0 */
/* Floats to half floats (IEEE 754 binary16), in plain C that compilers vectorise for any CPU. */
#include "features/features_private.h"

#include <string.h>

static inline uint32_t float_bits(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static inline float bits_float(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* All bits set where a < b, for a and b below 2^31. Compilers may turn comparisons into branches,
 * and then don't vectorise the loop. */
static inline uint32_t mask_less(uint32_t a, uint32_t b) {
    return 0u - ((a - b) >> 31);
}

void half_from_floats(const float *restrict from, uint16_t *restrict to, size_t count) {
    const uint32_t largest = 0x477fe000; /* 65504, the largest half */
    const uint32_t infinity = 0x7f800000;
    const uint32_t least_normal = 0x38800000; /* 2^-14 */
    const uint32_t rebias = (uint32_t)(127 - 15) << 23;
    for (size_t i = 0; i < count; i++) {
        const uint32_t bits = float_bits(from[i]);
        const uint32_t sign = bits >> 16 & 0x8000;
        const uint32_t magnitude = bits & 0x7fffffff;
        const uint32_t kept = magnitude < largest ? magnitude : largest;
        /* 13 bits of the mantissa go: add half of the last place, less one where it is even. */
        const uint32_t normal = (kept - rebias + 0xfff + (kept >> 13 & 1)) >> 13;
        /* 0.5's last place is 2^-24, a half's least subnormal: the addition itself rounds. */
        const uint32_t subnormal = float_bits(bits_float(kept) + 0.5f) - float_bits(0.5f);
        const uint32_t is_small = mask_less(kept, least_normal);
        const uint32_t finite = (subnormal & is_small) | (normal & ~is_small);
        const uint32_t nan = 0x7e00 & mask_less(infinity, magnitude);
        to[i] = (uint16_t)(sign | finite | nan);
    }
}

void half_to_floats(const uint16_t *restrict from, float *restrict to, size_t count) {
    for (size_t i = 0; i < count; i++)
        to[i] = fewray_half_value(from[i]);
}

void fewray_frame_half_losses(const struct fewray_frame *frame, size_t *clipped, size_t *lost) {
    const float largest = 65504.0f, least = 0x1p-25f;
    const size_t size = (size_t)frame->width * (size_t)frame->height;
    float *planes[3];
    size_t above = 0, below = 0;
    const bool colored = fewray_frame_layer(frame, FEWRAY_COLOR, planes);
#pragma omp parallel for reduction(+ : above, below) if (size > FEATURES_PARALLEL_MIN)
    for (size_t i = 0; i < (colored ? size : 0); i++) {
        const float r = planes[0][i], g = planes[1][i], b = planes[2][i];
        above += r > largest || g > largest || b > largest;
        below += (r > 0 || g > 0 || b > 0) && r <= least && g <= least && b <= least;
    }
    *clipped = above;
    *lost = below;
}
