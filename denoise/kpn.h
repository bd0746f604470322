/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_KPN_H
#define FEWRAY_DENOISE_KPN_H

/* The kernel-predicting network on one region of a picture: features, U-Net at half resolution,
 * irradiance pyramid, predicted kernels, remodulation. */

#include "denoise/features_kpn.h"
#include "denoise/kpn_blocks.h"
#include "denoise/nn/nn.h"
#include "fewray/denoise.h"

/* Regions start and end on multiples of this, the coarsest pyramid pixel. */
#define KPN_ALIGN 16
/* An output pixel reads nothing farther than this: 64 pixels through the pyramid and 92 more
 * through the U-Net, rounded up to KPN_ALIGN. */
#define KPN_OVERLAP 160

/* Most channels of a level that a weights file may ask for. */
#define KPN_MAX_WIDTH 512

struct kpn;

/* Takes the channels of each level from the weights, checks that all layers agree, and packs them;
 * *out is owned by the caller. */
int kpn_create(const struct nn_weights *weights, const struct nn_kernels *kernels, struct kpn **out,
               struct fewray_error *error);
void kpn_destroy(struct kpn **kpn);

/* The fewest rows of the picture that go through all layers together. */
#define KPN_BAND_ROWS 32

/* Bytes for kpn_run() on a region of this size, with kpn_layers_slots() slots: the most that it can
 * use and that aren't above max_bytes, or the fewest that it can work with where those are more. */
size_t kpn_memory(const struct kpn *kpn, int slots, int height, int width, int threads,
                  size_t max_bytes);

/* Pixels x0 <= x < x0 + width, y alike; all multiples of KPN_ALIGN, reaching beyond the picture by
 * less than that. */
struct kpn_region {
    int x0, y0, width, height;
};

struct kpn_job {
    const struct fewray_denoise_input *in;
    const struct kpn_scale *scale;
    struct kpn_region region; /* what the network sees */
    struct kpn_region core;   /* what is written, cut at the picture's edges; inside region */
    void *memory;             /* 64-byte aligned */
    size_t memory_bytes;      /* at least kpn_memory(..., 0) */
    int threads;
    const struct kpn_output *out;    /* the whole picture */
    const struct kpn_blocks *blocks; /* those that aren't filtered are left out; NULL: none are */
    const volatile int *cancel;
    void (*progress)(void *user, double fraction); /* of this region */
    void *progress_user;
    /* For tests, of regions of at most KPN_BAND_ROWS rows; NULL: sees what each layer made,
     * (height, width) pixels of `channels` floats, rows
     * row_stride apart and pixels pixel_stride. */
    void (*trace)(void *user, const char *layer, const float *pixels, int height, int width,
                  int channels, size_t row_stride, size_t pixel_stride);
    void *trace_user;
};

/* The only error: cancelled. */
int kpn_run(const struct kpn *kpn, const struct kpn_job *job, struct fewray_error *error);

#endif
