/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_LIGHT_TREE_H
#define FEWRAY_GUIDE_LIGHT_TREE_H

/* A tree over many lights, four branches a node, by which one is picked in proportion to an
 * estimate of what it sends to a point: Conty Estevez and Kulla 2018, without their splitting. */

#include <stddef.h>
#include <stdint.h>

#include "fewray/guide.h"
#include "guide/light/light_bounds.h"

/* Four clusters of lights, side by side so that they are weighed at once. */
struct light_node {
    float x[4], y[4], z[4]; /* centres of the spheres around the clusters */
    float radius2[4];       /* their squared radii, a little enlarged */
    float axis_x[4], axis_y[4], axis_z[4], cos_o[4], sin_o[4], cos_e[4]; /* see light_bounds */
    float phi[4];                                                        /* 0: an empty branch */
    uint32_t child[4]; /* the branch's node, or LIGHT_LEAF + its only light */
    uint32_t parent;   /* the branch above, as in `leaf` */
};

#define LIGHT_LEAF 0x80000000u

struct light_tree {
    size_t node_count; /* 0: no tree */
    struct light_node *nodes;
    uint32_t *leaf; /* (light count): 4 * the light's node + branch; UINT32_MAX: has no phi */
};

/* bounds: (n), of the lights; those with phi = 0 are never picked. */
int light_tree_create(const struct light_bounds *bounds, size_t n, struct light_tree *tree,
                      struct fewray_error *error);
void light_tree_clear(struct light_tree *tree);

/* Picks a light for the point `from` by a number in [0, 1); returns its chance, 0 where no light
 * can reach the point. normal: unit, light from below it is of no use; zero: none. */
float light_tree_pick(const struct light_tree *tree, struct vec3 from, struct vec3 normal,
                      float pick, uint32_t *light);
/* The chance with which light_tree_pick() picks a light. */
float light_tree_chance(const struct light_tree *tree, struct vec3 from, struct vec3 normal,
                        uint32_t light);

#endif
