/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_KPN_H
#define FEWRAY_DENOISE_KPN_H

/* The kernel-predicting network on one region of a picture: features, U-Net at half resolution,
 * irradiance pyramid, predicted kernels, remodulation. */

#include "denoise/denoise.h"
#include "denoise/features_kpn.h"
#include "denoise/nn/nn.h"

/* Regions start and end on multiples of this, the coarsest pyramid pixel. */
#define KPN_ALIGN 16
/* An output pixel reads nothing farther than this: 64 pixels through the pyramid and 92 more
 * through the U-Net, rounded up to KPN_ALIGN. */
#define KPN_OVERLAP 160

struct kpn;

/* Checks and packs the weights; *out is owned by the caller. */
int kpn_create(const struct nn_weights *weights, const struct nn_kernels *kernels, struct kpn **out,
               struct fewray_error *error);
void kpn_destroy(struct kpn **kpn);

/* Bytes that kpn_run() needs for a region of this size. */
size_t kpn_memory(int height, int width, int threads);

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
    void *memory;             /* kpn_memory() bytes, 64-byte aligned */
    int threads;
    float *out_rgb; /* the whole picture, (height, width, 3) */
    const volatile int *cancel;
    void (*progress)(void *user, double fraction); /* of this region */
    void *progress_user;
    /* For tests; NULL: sees what each layer made, (height, width) pixels of `channels` floats, rows
     * row_stride apart and pixels pixel_stride. */
    void (*trace)(void *user, const char *layer, const float *pixels, int height, int width,
                  int channels, size_t row_stride, size_t pixel_stride);
    void *trace_user;
};

/* *filtered is false where the region had no light and the network was spared. The only error:
 * cancelled. */
int kpn_run(const struct kpn *kpn, const struct kpn_job *job, bool *filtered,
            struct fewray_error *error);

#endif
