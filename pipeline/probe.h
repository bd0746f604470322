/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_PROBE_H
#define FEWRAY_PIPELINE_PROBE_H

/* How long the denoiser and the writing of files take on this machine, from a small picture of
 * noise: a few milliseconds. */

#include "fewray/pipeline.h"

struct probe_seconds {
    double denoise[2]; /* by enum fewray_denoise_model; both alike where the weights are a file's */
    double write;
};

/* For a picture of so many pixels. 0 for what the job leaves out. */
int probe_run(const struct fewray_job *job, int threads, long long pixels,
              struct probe_seconds *seconds, struct fewray_error *error);

#endif
