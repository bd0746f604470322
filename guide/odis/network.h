/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_NETWORK_H
#define FEWRAY_GUIDE_NETWORK_H

/* The ODIS network's forward pass for one grid point. What train/model.py must do likewise:
 * - a bin's 15 features: the 12 gathered planes times gain, mask, cosine, fill / 4; gain = 4 /
 * (filled bins among the 2x2 of its cell), 0 where none is filled
 * - space to depth, channel (2 dy + dx) * 15 + feature, 32x32 -> 16x16
 * - stem 1x1 60->16 (16x16), average pool, enc1 3x3 16->32 (8x8), average pool, enc2a 3x3 32->48,
 * enc2b 3x3 48->48 (4x4), up1 1x1 48->32, nearest upsampling, + enc1's output, dec1 3x3 32->32
 * (8x8), up0 1x1 32->16, nearest upsampling, + stem's output, dec0 3x3 16->16 (16x16), head 1x1
 * 16->8. Leaky ReLU 0.2 after all but up1, up0 and head; columns wrap, rows are zero-padded
 * - head channel 4 o + 2 dy + dx: output o of bin (dy, dx) of the cell; log root second moment =
 * fill + output 0; range-compressed mean radiance = output 1
 * - mix 1x1 48->1 on the mean of enc2b's output over its 4x4 cells: BSDF fraction = 0.05 + 0.95 *
 * sigmoid(mix) */

#include "guide/odis/gather.h"

struct odis_weights; /* packed convolutions, shared by all threads */
struct odis_network; /* one thread's activations */

/* Loads a weights file, or the built-in one where path is NULL. *out is owned by the caller. */
int odis_weights_load(const char *path, struct odis_weights **out, struct fewray_error *error);
/* The built-in weights that were trained as in the paper. */
int odis_weights_load_paper(struct odis_weights **out, struct fewray_error *error);
void odis_weights_destroy(struct odis_weights **weights);

/* NULL without memory. The weights must outlive it. */
struct odis_network *odis_network_create(const struct odis_weights *weights);
void odis_network_destroy(struct odis_network **network);

struct nn_tensor;
/* What a layer left in the last run, by its name, for tests; after the skips stem and enc1 hold
 * their sums with up0's and up1's upsampled outputs. NULL: no such layer. */
const struct nn_tensor *odis_network_layer(const struct odis_network *network, const char *name);

/* wanted: what a sampling map should be in proportion to, before the cosine: the root of the second
 * moment that a sample of a bin returns, or, for weights trained as in the paper (info "map":
 * "mean"), the mean radiance, but at least 1e-3: a bin must not become unreachable. radiance: mean
 * radiance. Both relative to the gathered scale, and 0 below the horizon. bsdf_fraction: share of
 * the samples that should rather come from the BSDF, 0.05..1; the training's own where that was
 * fixed (info "bsdf_fraction"). Planes that the training went without (info "drop") aren't read. */
void odis_network_run(struct odis_network *network, const struct gathered *in,
                      float wanted[SPHERE_BINS], float radiance[SPHERE_BINS], float *bsdf_fraction);

#endif
