/* SPDX-License-Identifier: Apache-2.0 */
/* The spatial tree, and how records get into its leaves. */

#include "guide/ppg/ppg.h"

#include <stdlib.h>

#include "guide/ppg/fraction.h"
#include "guide/ppg/quadtree.h"
#include "guide/trace/sampler.h"

#define SPLIT_RECORDS     12000.0 /* c of 2017 */
#define SPLIT_RECORDS_MIN 1000.0  /* fewer can't fill a quadtree */
#define SPLIT_PIXELS      (1280.0 * 720)
#define SPATIAL_DEPTH_MAX 60
#define ENERGY_MAX        1e15f /* sums stay finite */

struct spatial_node {
    int child[2]; /* halves along the axis depth % 3; child[0] = 0: a leaf, whose index is [1] */
    int depth;
};

struct ppg_leaf {
    struct quadtree sampling, building; /* of the passes before; of this pass */
    struct fraction fraction;
    float bsdf_fraction; /* fraction's value when the pass began */
    double records;      /* of this pass */
};

struct ppg {
    struct vec3 low;
    float size; /* edge of the cube */
    double split_records;
    int passes;        /* ended */
    uint64_t recorded; /* in this pass */
    struct spatial_node *nodes;
    struct ppg_leaf *leaves;
    int node_count, leaf_count;
    int leaf_capacity; /* the nodes' is twice that */
};

_Static_assert(sizeof(struct ppg_record) == PPG_RECORD_BYTES, "as the header says");

static int out_of_memory(struct fewray_error *error) {
    return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for path guiding");
}

int ppg_create(struct vec3 low, struct vec3 high, long long pixels, struct ppg **out,
               struct fewray_error *error) {
    *out = NULL;
    struct ppg *ppg = calloc(1, sizeof(*ppg));
    if (!ppg)
        return out_of_memory(error);
    float size = max_component(sub(high, low));
    ppg->low = low;
    ppg->size = size > 0 && isfinite(size) ? size : 1;
    double c = SPLIT_RECORDS * fmin(1, (double)pixels / SPLIT_PIXELS);
    ppg->split_records = fmax(c, SPLIT_RECORDS_MIN);
    ppg->node_count = ppg->leaf_count = ppg->leaf_capacity = 1;
    ppg->nodes = calloc(2, sizeof(*ppg->nodes));
    ppg->leaves = calloc(1, sizeof(*ppg->leaves));
    if (ppg->leaves)
        ppg->leaves[0].fraction = (struct fraction)FRACTION_START;
    if (!ppg->nodes || !ppg->leaves ||
        !quadtree_refine(&ppg->leaves[0].sampling, &ppg->leaves[0].building)) {
        ppg_destroy(&ppg);
        return out_of_memory(error);
    }
    *out = ppg;
    return FEWRAY_OK;
}

void ppg_destroy(struct ppg **ppg) {
    if (!*ppg)
        return;
    for (int i = 0; i < (*ppg)->leaf_count && (*ppg)->leaves; i++) {
        quadtree_clear(&(*ppg)->leaves[i].sampling);
        quadtree_clear(&(*ppg)->leaves[i].building);
    }
    free((*ppg)->nodes);
    free((*ppg)->leaves);
    free(*ppg);
    *ppg = NULL;
}

int ppg_leaf_count(const struct ppg *ppg) {
    return ppg->leaf_count;
}

/* --- lookup */

static float to_unit(float x, float low, float size) {
    return fminf(fmaxf((x - low) / size, 0), 0x1.fffffep-1f); /* NaN becomes 0 */
}

/* Index of the leaf at p, in units of the cube; *depth gets the leaf's. */
static int find_leaf(const struct ppg *ppg, const float point[3], int *depth) {
    float p[3] = {point[0], point[1], point[2]};
    const struct spatial_node *node = ppg->nodes;
    for (int axis = 0; node->child[0]; axis = axis == 2 ? 0 : axis + 1) {
        p[axis] *= 2;
        bool upper = p[axis] >= 1;
        p[axis] -= upper;
        node = &ppg->nodes[node->child[upper]];
    }
    *depth = node->depth;
    return node->child[1];
}

static void to_cube(const struct ppg *ppg, struct vec3 position, float p[3]) {
    p[0] = to_unit(position.x, ppg->low.x, ppg->size);
    p[1] = to_unit(position.y, ppg->low.y, ppg->size);
    p[2] = to_unit(position.z, ppg->low.z, ppg->size);
}

const struct ppg_leaf *ppg_leaf_at(const struct ppg *ppg, struct vec3 position) {
    if (!ppg->passes)
        return NULL;
    float p[3];
    int depth;
    to_cube(ppg, position, p);
    return &ppg->leaves[find_leaf(ppg, p, &depth)];
}

static bool has_light(const struct ppg_leaf *leaf) {
    return quadtree_energy(&leaf->sampling) > 0;
}

struct vec3 ppg_leaf_sample(const struct ppg_leaf *leaf, const float u[2]) {
    float at[2] = {u[0], u[1]};
    if (has_light(leaf))
        quadtree_sample(&leaf->sampling, u, at);
    return square_to_direction(at);
}

float ppg_leaf_pdf(const struct ppg_leaf *leaf, struct vec3 direction) {
    float at[2];
    square_from_direction(direction, at);
    return (has_light(leaf) ? quadtree_pdf(&leaf->sampling, at) : 1) * (0.25f / PI_F);
}

float ppg_leaf_bsdf_fraction(const struct ppg_leaf *leaf) {
    return has_light(leaf) ? leaf->bsdf_fraction : 1;
}

/* --- records */

static bool make_record(const struct path_vertex *v, struct ppg_record *record) {
    float energy = mean_component(v->incident) / v->pdf;
    float contribution = mean_component(mul(v->weight, v->incident));
    float sum = energy + contribution + v->bsdf_pdf + v->guide_pdf + v->position.x + v->position.y +
                v->position.z + v->direction.x + v->direction.y + v->direction.z;
    if (!(v->pdf > 0) || !isfinite(sum))
        return false;
    *record = (struct ppg_record){.position = v->position,
                                  .energy = fminf(fmaxf(energy, 0), ENERGY_MAX),
                                  .contribution = fminf(fmaxf(contribution, 0), ENERGY_MAX),
                                  .bsdf_pdf = v->bsdf_pdf,
                                  .guide_pdf = v->guide_pdf};
    square_from_direction(v->direction, record->at);
    return true;
}

bool ppg_buffer_add(struct ppg_buffer *buffer, const struct vertex_log *log) {
    size_t needed = buffer->count + (size_t)log->count;
    if (needed > buffer->capacity) {
        size_t capacity = needed + buffer->capacity / 2 + 256;
        struct ppg_record *records = realloc(buffer->records, capacity * sizeof(*records));
        if (!records)
            return false;
        buffer->records = records;
        buffer->capacity = capacity;
    }
    for (int i = 0; i < log->count; i++)
        buffer->count += make_record(&log->vertices[i], &buffer->records[buffer->count]);
    return true;
}

void ppg_buffer_free(struct ppg_buffer *buffer) {
    free(buffer->records);
    *buffer = (struct ppg_buffer){NULL, 0, 0};
}

/* Stochastic spatial filter (2019): a leaf near the position, by moving it within a box of the
 * leaf's own size. `number` makes the random numbers. */
static int filtered_leaf(const struct ppg *ppg, struct vec3 position, uint64_t number) {
    float p[3];
    int depth;
    to_cube(ppg, position, p);
    find_leaf(ppg, p, &depth);
    uint32_t seed = hash_combine(hash_combine((uint32_t)ppg->passes, (uint32_t)number),
                                 (uint32_t)(number >> 32));
    for (int axis = 0; axis < 3; axis++) {
        float size = ldexpf(1, -((depth + 2 - axis) / 3));
        float u = to_unit_float(hash_combine(seed, (uint32_t)axis));
        p[axis] = to_unit(p[axis] + (u - 0.5f) * size, 0, 1);
    }
    return find_leaf(ppg, p, &depth);
}

static void choose_leaves(const struct ppg *ppg, struct ppg_buffer *buffers, int count,
                          int threads) {
    uint64_t first = ppg->recorded;
    for (int b = 0; b < count; first += buffers[b++].count) {
        long long n = (long long)buffers[b].count;
#pragma omp parallel for schedule(static) num_threads(threads) if (n > 4096)
        for (long long i = 0; i < n; i++) {
            struct ppg_record *record = &buffers[b].records[i];
            record->leaf = (uint32_t)filtered_leaf(ppg, record->position, first + (uint64_t)i);
        }
    }
}

static void splat_leaf(const struct ppg *ppg, struct ppg_leaf *leaf,
                       const struct ppg_record *const *records, size_t count) {
    leaf->records += (double)count;
    bool guided = ppg->passes > 0 && has_light(leaf);
    for (size_t i = 0; i < count; i++) {
        const struct ppg_record *r = records[i];
        if (r->energy > 0)
            quadtree_splat(&leaf->building, r->at, r->energy);
        if (guided && r->contribution > 0)
            fraction_learn(&leaf->fraction, r->contribution, r->bsdf_pdf, r->guide_pdf);
    }
}

int ppg_splat(struct ppg *ppg, struct ppg_buffer *buffers, int count, int threads,
              struct fewray_error *error) {
    size_t total = 0;
    for (int b = 0; b < count; b++)
        total += buffers[b].count;
    /* Records sorted by leaf, in order within it; leaf i has those from starts[i] on. */
    const struct ppg_record **sorted = malloc((total + 1) * sizeof(*sorted));
    size_t *starts = calloc((size_t)ppg->leaf_count + 2, sizeof(*starts));
    if (!sorted || !starts) {
        free(sorted);
        free(starts);
        return out_of_memory(error);
    }
    choose_leaves(ppg, buffers, count, threads);
    for (int b = 0; b < count; b++)
        for (size_t i = 0; i < buffers[b].count; i++)
            starts[buffers[b].records[i].leaf + 2]++;
    for (int i = 0; i < ppg->leaf_count; i++)
        starts[i + 2] += starts[i + 1];
    for (int b = 0; b < count; b++)
        for (size_t i = 0; i < buffers[b].count; i++)
            sorted[starts[buffers[b].records[i].leaf + 1]++] = &buffers[b].records[i];
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (int i = 0; i < ppg->leaf_count; i++)
        splat_leaf(ppg, &ppg->leaves[i], sorted + starts[i], starts[i + 1] - starts[i]);
    ppg->recorded += total;
    for (int b = 0; b < count; b++)
        buffers[b].count = 0;
    free(sorted);
    free(starts);
    return FEWRAY_OK;
}

/* --- end of a pass */

static bool reserve_leaf(struct ppg *ppg) {
    if (ppg->leaf_count < ppg->leaf_capacity)
        return true;
    size_t capacity = 2 * (size_t)ppg->leaf_capacity;
    struct spatial_node *nodes = realloc(ppg->nodes, 2 * capacity * sizeof(*nodes));
    if (nodes)
        ppg->nodes = nodes;
    struct ppg_leaf *leaves = realloc(ppg->leaves, capacity * sizeof(*leaves));
    if (leaves)
        ppg->leaves = leaves;
    if (!nodes || !leaves)
        return false;
    ppg->leaf_capacity = (int)capacity;
    return true;
}

/* Halves a leaf; both halves know what it knew. */
static bool split_leaf(struct ppg *ppg, int node) {
    if (!reserve_leaf(ppg))
        return false;
    int index = ppg->nodes[node].child[1];
    struct ppg_leaf *half = &ppg->leaves[index], *other = &ppg->leaves[ppg->leaf_count];
    half->records *= 0.5;
    *other = *half;
    other->building = (struct quadtree){NULL, 0};
    if (!quadtree_copy(&half->sampling, &other->sampling))
        return false;
    int depth = ppg->nodes[node].depth + 1;
    ppg->nodes[ppg->node_count] = (struct spatial_node){{0, index}, depth};
    ppg->nodes[ppg->node_count + 1] = (struct spatial_node){{0, ppg->leaf_count}, depth};
    ppg->nodes[node].child[0] = ppg->node_count;
    ppg->nodes[node].child[1] = ppg->node_count + 1;
    ppg->node_count += 2;
    ppg->leaf_count++;
    return true;
}

static void start_sampling(struct ppg_leaf *leaf) {
    quadtree_sum(&leaf->building);
    quadtree_clear(&leaf->sampling);
    leaf->sampling = leaf->building;
    leaf->building = (struct quadtree){NULL, 0};
    leaf->bsdf_fraction = fraction_value(&leaf->fraction);
}

int ppg_end_pass(struct ppg *ppg, int samples, int threads, struct fewray_error *error) {
    for (int i = 0; i < ppg->leaf_count; i++)
        start_sampling(&ppg->leaves[i]);
    double limit = ppg->split_records * sqrt(samples);
    for (int n = 0; n < ppg->node_count; n++) /* new nodes come after and are split in turn */
        if (!ppg->nodes[n].child[0] && ppg->nodes[n].depth < SPATIAL_DEPTH_MAX &&
            ppg->leaves[ppg->nodes[n].child[1]].records > limit && !split_leaf(ppg, n))
            return out_of_memory(error);
    bool complete = true;
#pragma omp parallel for schedule(static) num_threads(threads) reduction(&& : complete)
    for (int i = 0; i < ppg->leaf_count; i++) {
        struct ppg_leaf *leaf = &ppg->leaves[i];
        leaf->records = 0;
        complete = quadtree_refine(&leaf->sampling, &leaf->building) && complete;
    }
    if (!complete)
        return out_of_memory(error);
    ppg->passes++;
    ppg->recorded = 0;
    return FEWRAY_OK;
}
