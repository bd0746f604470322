/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_PASS_SUMS_H
#define FEWRAY_PIPELINE_PASS_SUMS_H

/* Passes of which the picture is the sum: light by light, or by how it was reflected. They are
 * filtered by the picture's own kernels, so that they still add up to it.
 *
 * A pass of Cycles without its colour, "Diffuse Direct", is multiplied by that ("Diffuse Color")
 * before and divided by it afterwards. What the kernel brings to a pixel whose colour is black, so
 * that no pass could show it, goes to the other passes of the pixel by their shares. */

#include "pipeline/layer_names.h"

enum { PASSES_MAX = 64, SUMS_MAX = 12 };

struct light_pass {
    char channels[3][FEWRAY_NAME_MAX]; /* of the file */
    const float *data[3], *color[3];   /* the frame's; color NULL: it isn't multiplied */
    const char *emission;              /* suffix for fewray_denoise_frame_layers() */
};

struct pass_sum {
    enum layer_naming naming;
    const char *what;          /* "light groups" */
    struct light_pass *passes; /* but for the emission */
    int count;
    bool emission; /* the frame's emission is a part, too */
    double error;  /* of the sum: mean difference from the picture over the picture's mean */
    bool holds;    /* error is small enough */
};

struct pass_sums {
    struct pass_sum sums[SUMS_MAX];
    int count;
    struct light_pass passes[PASSES_MAX];
    int pass_count;
};

/* Finds sums of at least two passes; the frame has adopted its names. What was denoised before is
 * taken from noisy.* where `noisy` is set. *out points into the frame, which mustn't become
 * compact.
 */
void pass_sums_find(const struct fewray_frame *frame, const struct adoption *adoption,
                    enum layer_naming naming, bool noisy, struct pass_sums *out);

/* Adds planes for the passes of all sums that hold, and writes their names for
 * fewray_denoise_frame_layers(); *count gets how many. Fails only without memory. */
int pass_sums_start(struct fewray_frame *frame, struct pass_sums *sums, char names[][80],
                    int *count, struct fewray_error *error);
/* Behind the denoiser: the planes hold what belongs in the file. */
void pass_sums_finish(struct fewray_frame *frame, struct pass_sums *sums);
/* Channel c of pass i; NULL where the pass isn't filtered. */
const float *pass_sums_plane(const struct fewray_frame *frame, int pass, int c);

#endif
