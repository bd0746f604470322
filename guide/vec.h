/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_VEC_H
#define FEWRAY_GUIDE_VEC_H

/* Three floats as point, direction or linear RGB. */

#include <math.h>
#include <stdbool.h>

#define PI_F 3.14159265358979f

static inline float square(float x) {
    return x * x;
}

struct vec3 {
    float x, y, z;
};

static inline struct vec3 vec(float x, float y, float z) {
    return (struct vec3){x, y, z};
}
static inline struct vec3 add(struct vec3 a, struct vec3 b) {
    return vec(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline struct vec3 sub(struct vec3 a, struct vec3 b) {
    return vec(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline struct vec3 mul(struct vec3 a, struct vec3 b) {
    return vec(a.x * b.x, a.y * b.y, a.z * b.z);
}
static inline struct vec3 scale(struct vec3 a, float s) {
    return vec(a.x * s, a.y * s, a.z * s);
}
static inline struct vec3 negate(struct vec3 a) {
    return vec(-a.x, -a.y, -a.z);
}
static inline float dot(struct vec3 a, struct vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline struct vec3 cross(struct vec3 a, struct vec3 b) {
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline float length(struct vec3 a) {
    return sqrtf(dot(a, a));
}
/* The zero vector stays zero. */
static inline struct vec3 normalize(struct vec3 a) {
    float l = length(a);
    return l > 0 ? scale(a, 1 / l) : a;
}
/* Of two directions, radians. Kahan's formula: accurate for small angles, too. */
static inline float angle_between(struct vec3 a, struct vec3 b) {
    return 2 * atan2f(length(sub(a, b)), length(add(a, b)));
}
/* Also where a component is NaN. */
static inline bool is_black(struct vec3 rgb) {
    return !(rgb.x > 0 || rgb.y > 0 || rgb.z > 0);
}
static inline bool is_finite(struct vec3 a) {
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}
/* Into the axes that are the rows of m (3, 3). */
static inline struct vec3 to_axes(const float m[9], struct vec3 v) {
    return vec(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
               m[6] * v.x + m[7] * v.y + m[8] * v.z);
}
/* Back, where the rows are orthonormal. */
static inline struct vec3 from_axes(const float m[9], struct vec3 v) {
    return vec(m[0] * v.x + m[3] * v.y + m[6] * v.z, m[1] * v.x + m[4] * v.y + m[7] * v.z,
               m[2] * v.x + m[5] * v.y + m[8] * v.z);
}
/* fmaxf() as one instruction, which loops can be vectorised with; a where b is NaN. */
static inline float max_float(float a, float b) {
    return b > a ? b : a;
}
static inline int clamp_int(int i, int low, int high) {
    return i < low ? low : i > high ? high : i;
}
static inline float clamp_unit(float x) {
    return x > 0 ? (x < 1 ? x : 1) : 0;
}
static inline struct vec3 clamp_color(struct vec3 c) {
    return vec(clamp_unit(c.x), clamp_unit(c.y), clamp_unit(c.z));
}
static inline float max_component(struct vec3 a) {
    return max_float(max_float(a.x, a.y), a.z);
}
static inline float mean_component(struct vec3 a) {
    return (a.x + a.y + a.z) * (1.0f / 3);
}
static inline float luminance(struct vec3 rgb) {
    return 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z;
}

#endif
