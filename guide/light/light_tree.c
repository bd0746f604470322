/* SPDX-License-Identifier: Apache-2.0 */
/* The light tree's build and its walks down and up. */

#include "guide/light/light_tree.h"

#include <stdlib.h>

#include "guide/odis/float4.h"

/* Candidates for a split along each axis. */
#define BUCKETS 12

struct item {
    struct light_bounds bounds;
    uint32_t light;
};

static float component(struct vec3 v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

struct split {
    int axis; /* -1: none */
    float low, to_bucket;
    int last_left; /* bucket */
    float cost;
};

static int bucket_of(const struct split *s, const struct item *item) {
    int b = (int)((component(light_bounds_centre(&item->bounds), s->axis) - s->low) * s->to_bucket);
    return b < 0 ? 0 : b < BUCKETS ? b : BUCKETS - 1;
}

/* The best place along an axis by the surface area and orientation heuristic (eq. 1); long boxes
 * are cut across. */
static void try_axis(const struct item *items, size_t n, int axis, float low, float extent,
                     float longest, struct split *best) {
    struct split s = {.axis = axis, .low = low, .to_bucket = BUCKETS / extent};
    struct light_bounds buckets[BUCKETS], left[BUCKETS], right = light_bounds_none();
    for (int b = 0; b < BUCKETS; b++)
        buckets[b] = light_bounds_none();
    for (size_t i = 0; i < n; i++) {
        struct light_bounds *bucket = &buckets[bucket_of(&s, &items[i])];
        *bucket = light_bounds_union(bucket, &items[i].bounds);
    }
    left[0] = buckets[0];
    for (int b = 1; b < BUCKETS; b++)
        left[b] = light_bounds_union(&left[b - 1], &buckets[b]);
    for (int b = BUCKETS - 2; b >= 0; b--) {
        right = light_bounds_union(&right, &buckets[b + 1]);
        if (!(left[b].phi > 0) || !(right.phi > 0))
            continue;
        s.cost = (light_bounds_cost(&left[b]) + light_bounds_cost(&right)) * longest / extent;
        s.last_left = b;
        if (best->axis < 0 || s.cost < best->cost)
            *best = s;
    }
}

/* Reorders the items; returns how many go left, 1..n-1. */
static size_t split_items(struct item *items, size_t n) {
    struct vec3 low = vec(INFINITY, INFINITY, INFINITY), high = negate(low);
    for (size_t i = 0; i < n; i++) {
        struct vec3 c = light_bounds_centre(&items[i].bounds);
        low = vec(fminf(low.x, c.x), fminf(low.y, c.y), fminf(low.z, c.z));
        high = vec(fmaxf(high.x, c.x), fmaxf(high.y, c.y), fmaxf(high.z, c.z));
    }
    struct vec3 extent = sub(high, low);
    struct split best = {.axis = -1};
    for (int axis = 0; axis < 3; axis++)
        if (isfinite(component(extent, axis)) && isfinite(BUCKETS / component(extent, axis)))
            try_axis(items, n, axis, component(low, axis), component(extent, axis),
                     max_component(extent), &best);
    size_t left = 0;
    for (size_t i = 0; i < n && best.axis >= 0; i++)
        if (bucket_of(&best, &items[i]) <= best.last_left) {
            struct item swap = items[left];
            items[left++] = items[i];
            items[i] = swap;
        }
    return left > 0 && left < n ? left : n / 2;
}

static void set_branch(struct light_node *node, int k, const struct light_bounds *b) {
    /* Rounding mustn't leave a light outside. */
    float radius = light_bounds_radius(b) * 1.0001f;
    struct vec3 centre = light_bounds_centre(b);
    node->x[k] = centre.x;
    node->y[k] = centre.y;
    node->z[k] = centre.z;
    node->radius2[k] = radius * radius;
    node->axis_x[k] = b->axis.x;
    node->axis_y[k] = b->axis.y;
    node->axis_z[k] = b->axis.z;
    node->cos_o[k] = cosf(b->theta_o);
    node->sin_o[k] = fmaxf(0, sinf(b->theta_o));
    node->cos_e[k] = cosf(b->theta_e);
    node->phi[k] = b->phi;
}

struct range {
    struct item *items;
    size_t n;
    struct light_bounds bounds;
};

static struct range make_range(struct item *items, size_t n) {
    struct range r = {items, n, light_bounds_none()};
    for (size_t i = 0; i < n; i++)
        r.bounds = light_bounds_union(&r.bounds, &items[i].bounds);
    return r;
}

/* Splits a range into up to four, the costliest first; returns their number. */
static int split_range(struct range ranges[4]) {
    int count = 1;
    for (; count < 4; count++) {
        int worst = -1;
        float worst_cost = 0;
        for (int k = 0; k < count; k++) {
            float cost = light_bounds_cost(&ranges[k].bounds);
            /* Costs beyond floats aren't numbers; their ranges must end too. */
            if (ranges[k].n > 1 && (worst < 0 || cost > worst_cost)) {
                worst = k;
                worst_cost = cost;
            }
        }
        if (worst < 0)
            break;
        struct range r = ranges[worst];
        size_t left = split_items(r.items, r.n);
        ranges[worst] = make_range(r.items, left);
        ranges[count] = make_range(r.items + left, r.n - left);
    }
    return count;
}

/* Adds the node of a range, and those below it; returns its index. */
static uint32_t build(struct light_tree *tree, struct range range, uint32_t parent) {
    uint32_t at = (uint32_t)tree->node_count++;
    struct range ranges[4] = {range};
    int count = split_range(ranges);
    tree->nodes[at] = (struct light_node){.parent = parent};
    for (int k = 0; k < count; k++) {
        uint32_t branch = 4 * at + (uint32_t)k, light = ranges[k].items[0].light;
        set_branch(&tree->nodes[at], k, &ranges[k].bounds);
        if (ranges[k].n == 1)
            tree->leaf[light] = branch;
        tree->nodes[at].child[k] =
            ranges[k].n == 1 ? LIGHT_LEAF + light : build(tree, ranges[k], branch);
    }
    return at;
}

int light_tree_create(const struct light_bounds *bounds, size_t n, struct light_tree *tree,
                      struct fewray_error *error) {
    *tree = (struct light_tree){0};
    struct item *items = malloc((n + 1) * sizeof(*items));
    tree->leaf = malloc((n + 1) * sizeof(*tree->leaf));
    tree->nodes = malloc((n + 1) * sizeof(*tree->nodes));
    if (!items || !tree->leaf || !tree->nodes) {
        free(items);
        light_tree_clear(tree);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for %zu lights", n);
    }
    size_t shining = 0;
    for (size_t i = 0; i < n; i++) {
        tree->leaf[i] = UINT32_MAX;
        if (bounds[i].phi > 0)
            items[shining++] = (struct item){bounds[i], (uint32_t)i};
    }
    if (shining > 0)
        build(tree, make_range(items, shining), UINT32_MAX);
    free(items);
    return FEWRAY_OK;
}

void light_tree_clear(struct light_tree *tree) {
    free(tree->nodes);
    free(tree->leaf);
    *tree = (struct light_tree){0};
}

/* A cosine of a light that is just in view counts so much at least: rounding mustn't lose it. */
#define LEAST_COSINE 1e-3f

static inline float4 larger(float4 a, float4 b) {
    return pick(a > b, a, b);
}

static inline float4 root(float4 a) {
    return (float4){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3])};
}

/* The sine of an angle in 0..pi. */
static inline float4 sine_of(float4 cosine) {
    return root(larger(1 - cosine * cosine, splat(0)));
}

/* Estimates of what the clusters send to a point (eq. 3): none with a light that reaches the point
 * has importance 0. Returns their sum. `from` sees a cluster's sphere within the angle b around its
 * centre, so both cosines are of angles less b, and the light's less the cone's o. */
static float weigh(const struct light_node *node, struct vec3 from, struct vec3 normal,
                   float weights[4]) {
    const float4 zero = splat(0), one = splat(1), least = splat(LEAST_COSINE);
    float4 x = load(node->x) - from.x, y = load(node->y) - from.y, z = load(node->z) - from.z;
    float4 distance2 = larger(x * x + y * y + z * z, splat(1e-20f)), r2 = load(node->radius2);
    float4 inverse = 1 / root(distance2), sin2 = r2 / distance2;
    int4 inside = sin2 >= 1;
    float4 cos_b = pick(inside, -one, root(larger(1 - sin2, zero)));
    float4 sin_b = pick(inside, zero, root(sin2));

    float4 cos_w =
        -inverse * (load(node->axis_x) * x + load(node->axis_y) * y + load(node->axis_z) * z);
    float4 sin_w = sine_of(cos_w), cos_o = load(node->cos_o), sin_o = load(node->sin_o);
    float4 cos_x = pick(cos_w > cos_o, one, cos_w * cos_o + sin_w * sin_o);
    float4 sin_x = pick(cos_w > cos_o, zero, sin_w * cos_o - cos_w * sin_o);
    float4 cos_light = pick(cos_x > cos_b, one, cos_x * cos_b + sin_x * sin_b);

    float4 weight = load(node->phi) * larger(cos_light, least) / larger(distance2, r2);
    weight = pick(cos_light < load(node->cos_e) - LEAST_COSINE, zero, weight);
    if (dot(normal, normal) > 0) {
        float4 cos_i = inverse * (normal.x * x + normal.y * y + normal.z * z);
        float4 cos_surface = pick(cos_i > cos_b, one, cos_i * cos_b + sine_of(cos_i) * sin_b);
        weight *= pick(cos_surface < -LEAST_COSINE, zero, larger(cos_surface, least));
    }
    store(weights, weight);
    return weights[0] + weights[1] + (weights[2] + weights[3]);
}

float light_tree_pick(const struct light_tree *tree, struct vec3 from, struct vec3 normal, float u,
                      uint32_t *light) {
    uint32_t at = 0;
    float chance = 1;
    if (tree->node_count == 0)
        return 0;
    while (!(at & LIGHT_LEAF)) {
        float weights[4], sum = weigh(&tree->nodes[at], from, normal, weights);
        if (!(sum > 0))
            return 0;
        float left = u * sum;
        int k = 0, last = 0;
        for (; k < 4; k++) {
            last = weights[k] > 0 ? k : last;
            if (left < weights[k])
                break;
            left -= weights[k];
        }
        k = k < 4 ? k : last; /* rounding took it beyond the last */
        u = fminf(fmaxf(left / weights[k], 0), 0x1.fffffep-1f);
        chance *= weights[k] / sum;
        at = tree->nodes[at].child[k];
    }
    *light = at - LIGHT_LEAF;
    return chance;
}

float light_tree_chance(const struct light_tree *tree, struct vec3 from, struct vec3 normal,
                        uint32_t light) {
    uint32_t branch = tree->leaf[light];
    float chance = branch == UINT32_MAX ? 0 : 1;
    while (branch != UINT32_MAX) {
        float weights[4];
        const struct light_node *node = &tree->nodes[branch / 4];
        float sum = weigh(node, from, normal, weights);
        if (!(weights[branch % 4] > 0))
            return 0;
        chance *= weights[branch % 4] / sum;
        branch = node->parent;
    }
    return chance;
}
