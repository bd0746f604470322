/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_FLOAT4_H
#define FEWRAY_GUIDE_FLOAT4_H

/* Four floats at a time, by the compiler's vectors: the same bits on every machine. */

#include <stdint.h>
#include <string.h>

typedef float float4 __attribute__((vector_size(16)));
typedef int32_t int4 __attribute__((vector_size(16)));

static inline float4 splat(float x) {
    return (float4){x, x, x, x};
}

static inline float4 load(const void *from) {
    float4 v;
    memcpy(&v, from, sizeof(v));
    return v;
}

static inline void store(float *to, float4 v) {
    memcpy(to, &v, sizeof(v));
}

/* a where the mask is all ones, b where it is 0. */
static inline float4 pick(int4 mask, float4 a, float4 b) {
    return (float4)((mask & (int4)a) | (~mask & (int4)b));
}

/* Four vectors of four values each: from a vector a value's kind to a vector a place, or back. */
static inline void transpose(float4 v[4]) {
    float4 a = __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5);
    float4 b = __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5);
    float4 c = __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7);
    float4 d = __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
    v[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
    v[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
    v[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
    v[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}

#endif
