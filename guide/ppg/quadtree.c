/* SPDX-License-Identifier: Apache-2.0 */
/* Directional quadtrees: building, splatting, sampling. */

#include "guide/ppg/quadtree.h"

#include <stdlib.h>
#include <string.h>

#define SUBDIVISION_SHARE 0.01f /* rho of 2017 */
/* On each depth fewer than 100 quadrants can hold more than 1 %. */
#define NODES_MAX (1 + 100 * (QUADTREE_MAX_DEPTH - 1))

void quadtree_clear(struct quadtree *tree) {
    free(tree->nodes);
    *tree = (struct quadtree){NULL, 0};
}

static bool set_nodes(struct quadtree *tree, const struct quad_node *nodes, int count) {
    tree->nodes = malloc((size_t)count * sizeof(*nodes));
    if (!tree->nodes)
        return false;
    memcpy(tree->nodes, nodes, (size_t)count * sizeof(*nodes));
    tree->count = count;
    return true;
}

bool quadtree_copy(const struct quadtree *from, struct quadtree *to) {
    *to = (struct quadtree){NULL, 0};
    return from->count == 0 || set_nodes(to, from->nodes, from->count);
}

/* What the refinement knows of a new node: the old node there (NULL below the old leaves), and the
 * share of all energy in it. */
struct refined {
    const struct quad_node *old;
    float share;
    int depth; /* of the node's quadrants, 1 at the root */
};

bool quadtree_refine(const struct quadtree *old, struct quadtree *to) {
    struct quad_node nodes[NODES_MAX];
    struct refined known[NODES_MAX];
    float total = quadtree_energy(old);
    nodes[0] = (struct quad_node){{0}, {0}};
    known[0] = (struct refined){total > 0 ? old->nodes : NULL, 1, 1};
    int count = 1;
    for (int n = 0; n < count; n++)
        for (int q = 0; q < 4; q++) {
            const struct refined *from = &known[n];
            float share = from->old ? from->old->energy[q] / total : 0.25f * from->share;
            if (share <= SUBDIVISION_SHARE || from->depth >= QUADTREE_MAX_DEPTH ||
                count == NODES_MAX)
                continue;
            bool finer = from->old && from->old->child[q];
            known[count] = (struct refined){finer ? old->nodes + from->old->child[q] : NULL, share,
                                            from->depth + 1};
            nodes[count] = (struct quad_node){{0}, {0}};
            nodes[n].child[q] = (uint16_t)count++;
        }
    return set_nodes(to, nodes, count);
}

/* Quadrant of a node that holds *at, which becomes the point within that quadrant. */
static int enter_quadrant(float at[2]) {
    int quadrant = 0;
    for (int k = 0; k < 2; k++) {
        at[k] *= 2;
        if (at[k] >= 1) {
            at[k] -= 1;
            quadrant |= 1 << k;
        }
    }
    return quadrant;
}

static float leaf_size(const struct quadtree *tree, const float at[2]) {
    float p[2] = {at[0], at[1]}, size = 0.5f;
    int node = tree->nodes[0].child[enter_quadrant(p)];
    for (; node; size *= 0.5f)
        node = tree->nodes[node].child[enter_quadrant(p)];
    return size;
}

static float overlap(float a0, float a1, float b0, float b1) {
    return fmaxf(0, fminf(a1, b1) - fmaxf(a0, b0));
}

struct box {
    float low[2], high[2];
};

/* Adds `density` times the area shared with the box to each leaf below the node, whose corner and
 * size are given. */
static void splat_box(struct quad_node *nodes, int node, float x, float y, float size,
                      const struct box *box, float density) {
    float half = 0.5f * size;
    for (int q = 0; q < 4; q++) {
        float qx = x + (float)(q & 1) * half, qy = y + (float)(q >> 1) * half;
        float area = overlap(qx, qx + half, box->low[0], box->high[0]) *
                     overlap(qy, qy + half, box->low[1], box->high[1]);
        if (!(area > 0))
            continue;
        if (nodes[node].child[q])
            splat_box(nodes, nodes[node].child[q], qx, qy, half, box, density);
        else
            nodes[node].energy[q] += density * area;
    }
}

void quadtree_splat(struct quadtree *tree, const float at[2], float energy) {
    float size = leaf_size(tree, at), density = energy / (size * size);
    float low = at[0] - 0.5f * size;
    float top = fminf(fmaxf(at[1] - 0.5f * size, 0), 1 - size);
    struct box box = {{low, top}, {low + size, top + size}};
    splat_box(tree->nodes, 0, 0, 0, 1, &box, density);
    if (low < 0 || low + size > 1) { /* the part on the other side of the seam */
        float turn = low < 0 ? 1 : -1;
        box.low[0] += turn;
        box.high[0] += turn;
        splat_box(tree->nodes, 0, 0, 0, 1, &box, density);
    }
}

static float node_energy(const struct quad_node *node) {
    return (node->energy[0] + node->energy[2]) + (node->energy[1] + node->energy[3]);
}

void quadtree_sum(struct quadtree *tree) {
    for (int n = tree->count - 1; n >= 0; n--)
        for (int q = 0; q < 4; q++)
            if (tree->nodes[n].child[q])
                tree->nodes[n].energy[q] = node_energy(&tree->nodes[tree->nodes[n].child[q]]);
}

float quadtree_energy(const struct quadtree *tree) {
    return tree->count ? node_energy(tree->nodes) : 0;
}

/* Chooses the second of two parts with probability second / (first + second) and stretches *u over
 * the chosen one. A part without energy is never chosen. */
static int choose(float first, float second, float *u) {
    float split = first / (first + second);
    bool is_second = *u >= split;
    *u = is_second ? (*u - split) / (1 - split) : *u / split;
    *u = fminf(*u, 0x1.fffffep-1f);
    return is_second;
}

void quadtree_sample(const struct quadtree *tree, const float u[2], float at[2]) {
    float v[2] = {u[0], u[1]}, size = 1;
    at[0] = at[1] = 0;
    int n = 0;
    do {
        const struct quad_node *node = &tree->nodes[n];
        const float *e = node->energy;
        int column = choose(e[0] + e[2], e[1] + e[3], &v[0]);
        int row = choose(e[column], e[column + 2], &v[1]);
        size *= 0.5f;
        at[0] += (float)column * size;
        at[1] += (float)row * size;
        n = node->child[column + 2 * row];
    } while (n);
    for (int k = 0; k < 2; k++)
        at[k] = fminf(at[k] + v[k] * size, 0x1.fffffep-1f);
}

float quadtree_pdf(const struct quadtree *tree, const float at[2]) {
    float p[2] = {at[0], at[1]}, pdf = 1;
    int n = 0;
    do {
        const struct quad_node *node = &tree->nodes[n];
        int q = enter_quadrant(p);
        if (!(node->energy[q] > 0))
            return 0;
        pdf *= 4 * node->energy[q] / node_energy(node);
        n = node->child[q];
    } while (n);
    return pdf;
}
