/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_QUADTREE_H
#define FEWRAY_GUIDE_QUADTREE_H

/* Directional quadtree (Mueller, Gross, Novak 2017, "Practical Path Guiding for Efficient
 * Light-Transport Simulation", the directional half of its SD-tree): a piecewise constant density
 * over the unit square, finer where there is more energy.
 *
 * The square is the sphere in cylindrical equal-area coordinates: at[0] is the azimuth around the y
 * axis in turns, at[1] runs from y = +1 down to y = -1, as in guide/odis/sphere_grid.h. A density
 * over the square is 4 pi times one over solid angle. */

#include <stdbool.h>
#include <stdint.h>

#include "guide/vec.h"

#define QUADTREE_MAX_DEPTH 16 /* of a quadrant: 1.5e-5 of a turn; float directions tell no more */

struct quad_node {
    float energy[4];   /* quadrant (column, row) at column + 2 * row; only ratios matter */
    uint16_t child[4]; /* index of the quadrant's own node, above this node's; 0 = a leaf */
};

struct quadtree {
    struct quad_node *nodes; /* [0] is the root; owned */
    int count;
};

void quadtree_clear(struct quadtree *tree);
bool quadtree_copy(const struct quadtree *from, struct quadtree *to); /* false: no memory */

/* Makes a tree of zero energy whose quadrants are subdivided until none holds more than 1 % of
 * `old`'s energy (2017, its adaptive refinement of the quadtree); an `old` without energy counts as
 * evenly lit. False without memory; `to` must hold nothing. */
bool quadtree_refine(const struct quadtree *old, struct quadtree *to);

/* Spreads energy over a box around `at` that is as large as the quadrant there (Mueller 2019,
 * "Practical Path Guiding in Production", box directional filter). The box wraps in azimuth and is
 * pushed inside at the poles, so that no energy is lost. Only leaves get energy: see
 * quadtree_sum(). */
void quadtree_splat(struct quadtree *tree, const float at[2], float energy);

/* Sums the leaves' energy upwards. Needed between splatting and the functions below. */
void quadtree_sum(struct quadtree *tree);

float quadtree_energy(const struct quadtree *tree);

/* Draws a point with density quadtree_pdf() from u in [0, 1)^2; the tree must have energy. */
void quadtree_sample(const struct quadtree *tree, const float u[2], float at[2]);
/* Density over the unit square. */
float quadtree_pdf(const struct quadtree *tree, const float at[2]);

static inline void square_from_direction(struct vec3 direction, float at[2]) {
    const float end = 0x1.fffffep-1f; /* largest float below 1 */
    float turn = atan2f(direction.x, direction.z) * (0.5f / PI_F);
    at[0] = fminf(turn < 0 ? turn + 1 : turn, end);
    at[1] = fminf(fmaxf(0.5f - 0.5f * direction.y, 0), end);
}

static inline struct vec3 square_to_direction(const float at[2]) {
    float y = 1 - 2 * at[1];
    float r = 2 * sqrtf(fmaxf(0, at[1] * (1 - at[1]))), phi = 2 * PI_F * at[0];
    return vec(r * sinf(phi), y, r * cosf(phi));
}

#endif
