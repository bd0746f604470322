/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_NOISE_H
#define FEWRAY_TRAIN_NOISE_H

/* Value noise, 0..1: in space for skies, on a torus for tileable pictures. */

#include <stdint.h>

#include "guide/vec.h"

/* A random value of a lattice point. */
float noise_lattice(uint32_t seed, int x, int y, int z);
/* Four octaves. */
float noise_fractal(uint32_t seed, struct vec3 p);
/* Octaves over the unit torus: the first has cells_u x cells_v cells, the next twice as many. */
float noise_tileable(uint32_t seed, float u, float v, int cells_u, int cells_v, int octaves);

#endif
