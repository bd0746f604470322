/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_DENOISE_JOB_H
#define FEWRAY_PIPELINE_DENOISE_JOB_H

/* What `fewray denoise` does with a file, and with those of a sequence. */

#include "fewray/denoise.h"
#include "fewray/pipeline.h"
#include "pipeline/layer_names.h"
#include "pipeline/options.h"
#include "pipeline/run_progress.h"

struct denoise_job {
    const char *input;
    struct fewray_outputs outputs;
    struct fewray_denoise_options denoise;
    const struct name_list *aovs; /* "auto": the passes whose sum is the picture */
    enum layer_naming naming;
    void (*note)(const char *text); /* NULL; news of work that goes on */
};

/* One file. *denoiser is created where it is NULL, and is the caller's. stats->threads is set. */
int denoise_job_run(const struct denoise_job *job, struct fewray_denoiser **denoiser,
                    struct run_progress *progress, struct fewray_run_stats *stats,
                    struct fewray_error *error);

/* Files whose names have a place for the frame's number, each for itself. */
struct denoise_sequence {
    const struct fewray_frames *frames; /* NULL: all that are there */
    bool skip_existing;                 /* frames whose outputs are all there */
    void (*tell)(void *user, const struct fewray_progress *progress); /* of the sequence; NULL */
    void *tell_user;
    void (*frame_done)(void *user, int frame, const struct fewray_run_stats *stats); /* NULL */
    void *frame_user;
};

/* Denoises job->input's files to job->outputs'. A frame of `frames` that is missing is an error
 * before anything is done; where `frames` is NULL a gap in the numbers is a note. Cancelled, the
 * frames before are whole. */
int denoise_sequence_run(const struct denoise_job *job, const struct denoise_sequence *sequence,
                         int threads, struct fewray_error *error);

#endif
