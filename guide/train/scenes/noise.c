/* SPDX-License-Identifier: Apache-2.0 */
/* Hashed lattices and the noise between their points. */

#include "guide/train/scenes/noise.h"

#include <math.h>

float noise_lattice(uint32_t seed, int x, int y, int z) {
    uint32_t h = seed ^ ((uint32_t)x * 0x8DA6B343u) ^ ((uint32_t)y * 0xD8163841u) ^
                 ((uint32_t)z * 0xCB1AB31Fu);
    h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
    h = (h ^ (h >> 12)) * 0x297A2D39u;
    return (float)((h ^ (h >> 15)) >> 8) * 0x1p-24f;
}

static float noise(uint32_t seed, struct vec3 p) {
    float fx = floorf(p.x), fy = floorf(p.y), fz = floorf(p.z);
    float t[3] = {p.x - fx, p.y - fy, p.z - fz};
    for (int i = 0; i < 3; i++)
        t[i] = t[i] * t[i] * (3 - 2 * t[i]);
    float sum = 0;
    for (int corner = 0; corner < 8; corner++) {
        int dx = corner & 1, dy = (corner >> 1) & 1, dz = corner >> 2;
        float weight = (dx ? t[0] : 1 - t[0]) * (dy ? t[1] : 1 - t[1]) * (dz ? t[2] : 1 - t[2]);
        sum += weight * noise_lattice(seed, (int)fx + dx, (int)fy + dy, (int)fz + dz);
    }
    return sum;
}

float noise_fractal(uint32_t seed, struct vec3 p) {
    float sum = 0, amplitude = 0.5f;
    for (int octave = 0; octave < 4; octave++, amplitude *= 0.5f)
        sum += amplitude * noise(seed + (uint32_t)octave, scale(p, (float)(1 << octave)));
    return sum / 0.9375f;
}

static int wrapped(int i, int period) {
    return ((i % period) + period) % period;
}

static float tileable_octave(uint32_t seed, float u, float v, int cells_u, int cells_v) {
    float x = u * (float)cells_u, y = v * (float)cells_v, fx = floorf(x), fy = floorf(y);
    float s = x - fx, t = y - fy;
    s = s * s * (3 - 2 * s), t = t * t * (3 - 2 * t);
    int x0 = wrapped((int)fx, cells_u), y0 = wrapped((int)fy, cells_v), x1 = (x0 + 1) % cells_u,
        y1 = (y0 + 1) % cells_v;
    float low = (1 - s) * noise_lattice(seed, x0, y0, 0) + s * noise_lattice(seed, x1, y0, 0);
    float high = (1 - s) * noise_lattice(seed, x0, y1, 0) + s * noise_lattice(seed, x1, y1, 0);
    return (1 - t) * low + t * high;
}

float noise_tileable(uint32_t seed, float u, float v, int cells_u, int cells_v, int octaves) {
    float sum = 0, amplitude = 1, total = 0;
    for (int i = 0; i < octaves; i++, amplitude *= 0.5f) {
        sum += amplitude * tileable_octave(seed + (uint32_t)i, u, v, cells_u << i, cells_v << i);
        total += amplitude;
    }
    return sum / total;
}
