/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_PPG_H
#define FEWRAY_GUIDE_PPG_H

/* Practical path guiding: incident radiance learnt while rendering, in a binary tree over space
 * with a directional quadtree in each leaf. After
 *
 *     Mueller, Gross, Novak 2017, "Practical Path Guiding for Efficient Light-Transport Simulation"
 *     Mueller 2019, "Practical Path Guiding in Production" (SIGGRAPH course Path Guiding in
 *     Production, chapter 10): filtered splatting and the learnt BSDF fraction
 *
 * In order of use:
 *
 *     ppg_create()
 *     each pass, of 1, 2, 4, ... samples a pixel:
 *         paths read ppg_leaf_at() from any thread, and are put into buffers by ppg_buffer_add()
 *         ppg_splat()        takes the buffers in; as often as wanted
 *         ppg_end_pass()     what was taken in becomes what is sampled; the trees are refined
 *     ppg_destroy()
 *
 * What is learnt depends on the records and their order alone, not on threads or on how many
 * ppg_splat() calls they are dealt out to. So the caller gives each tile of the picture a buffer of
 * its own and hands these over in tile order; where a pass's records would take too much memory
 * (PPG_RECORD_BYTES a vertex), it traces some tiles, splats, and goes on with the next tiles. */

#include <stddef.h>

#include "fewray/features.h"
#include "guide/trace/vertex_log.h"

struct ppg;
struct ppg_leaf; /* the distribution of one part of space; valid until the pass ends */

#define PPG_RECORD_BYTES 40

/* One vertex, as far as it is needed. */
struct ppg_record {
    struct vec3 position;
    float at[2];        /* sampled direction, see quadtree.h */
    float energy;       /* incident radiance / pdf, channels averaged */
    float contribution; /* f cos L / pdf, channels averaged */
    float bsdf_pdf, guide_pdf;
    uint32_t leaf; /* that the record goes to */
};

struct ppg_buffer {
    struct ppg_record *records; /* owned */
    size_t count, capacity;
};

/* low, high: corners of the scene's bounding box (it is widened to a cube). pixels: of the picture,
 * for the number of records that a part of space gets before it is split: c * sqrt(samples a pixel)
 * as in 2017 (adaptive refinement of the binary tree), with c = 12000 for pictures of 1280 x 720
 * and larger, and in proportion to the pixels, but not below 1000, for smaller ones: so their space
 * is divided alike. *out is owned by the caller. */
int ppg_create(struct vec3 low, struct vec3 high, long long pixels, struct ppg **out,
               struct fewray_error *error);
void ppg_destroy(struct ppg **ppg);

/* The distribution at a position, learnt in the passes before; NULL in the first pass. */
const struct ppg_leaf *ppg_leaf_at(const struct ppg *ppg, struct vec3 position);

/* Unit direction with density ppg_leaf_pdf() from u in [0, 1)^2. */
struct vec3 ppg_leaf_sample(const struct ppg_leaf *leaf, const float u[2]);
/* Solid angle; uniform where the leaf saw no light. */
float ppg_leaf_pdf(const struct ppg_leaf *leaf, struct vec3 direction);
/* Probability of sampling the BSDF instead: 1 where the leaf saw no light. */
float ppg_leaf_bsdf_fraction(const struct ppg_leaf *leaf);

/* Adds a path's vertices; those with a NaN, an infinity or no pdf are left out. False without
 * memory. Not for two threads at once on one buffer. */
bool ppg_buffer_add(struct ppg_buffer *buffer, const struct vertex_log *log);
void ppg_buffer_free(struct ppg_buffer *buffer);

/* Takes the records in, buffer by buffer, and empties the buffers (which keep their memory). */
int ppg_splat(struct ppg *ppg, struct ppg_buffer *buffers, int count, int threads,
              struct fewray_error *error);

/* samples: a pixel in the pass that ends. */
int ppg_end_pass(struct ppg *ppg, int samples, int threads, struct fewray_error *error);

int ppg_leaf_count(const struct ppg *ppg);

#endif
