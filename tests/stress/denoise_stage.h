/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_DENOISE_STAGE_H
#define FEWRAY_TESTS_DENOISE_STAGE_H

/* Both models, each made once, and what the stress tests of the denoiser share. */

#include <float.h>
#include <stdio.h>

#include "tests/unit/denoise_room.h"

enum { MODELS = 2 };
static const char *const MODEL_NAMES[MODELS] = {"default", "fast"};

/* A filtered value is a mean of means over five levels; on each the weights, at most 34, sum to 1
 * but for the rounding of their sum and of the weighted one: 2 * (34 + 2) * 2^-24 a level. */
#define MEAN_ERROR (5 * 2 * 36 * 0x1p-24)

struct stage {
    struct fewray_denoiser *denoisers[MODELS];
};

static inline void stage_open_with(struct stage *stage,
                                   const struct fewray_denoise_options *options) {
    for (int m = 0; m < MODELS; m++) {
        struct fewray_denoise_options own = *options;
        struct fewray_error error;
        own.model = (enum fewray_denoise_model)m;
        assert_int_equal(fewray_denoiser_create(&own, &stage->denoisers[m], &error), FEWRAY_OK);
    }
}

/* One thread; no pixel is settled, so that all go through the network. */
static inline void stage_open(struct stage *stage) {
    struct fewray_denoise_options options;
    fewray_denoise_options_init(&options);
    options.threads = 1;
    options.settled_error = -1;
    stage_open_with(stage, &options);
}

static inline void stage_close(struct stage *stage) {
    for (int m = 0; m < MODELS; m++)
        fewray_denoiser_destroy(&stage->denoisers[m]);
}

static inline void stage_run(const struct stage *stage, int model,
                             const struct fewray_denoise_input *in, float *out) {
    struct fewray_error error = {0};
    if (fewray_denoiser_run(stage->denoisers[model], in, out, NULL, &error))
        fail_msg("the model %s failed: %s", MODEL_NAMES[model], error.what);
}

static inline void assert_all_finite(const float *values, size_t n, const char *what) {
    for (size_t i = 0; i < n; i++)
        if (!isfinite(values[i]))
            fail_msg("%s: value %zu is %g", what, i, (double)values[i]);
}

#endif
