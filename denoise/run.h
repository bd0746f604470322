/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_RUN_H
#define FEWRAY_DENOISE_RUN_H

/* fewray_denoiser_run() into a picture of any layout. */

#include "denoise/kpn_blocks.h"

int denoiser_run_to(struct fewray_denoiser *denoiser, const struct fewray_denoise_input *in,
                    const struct kpn_output *out, struct fewray_denoise_stats *stats,
                    struct fewray_error *error);

#endif
