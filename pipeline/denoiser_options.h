/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_DENOISER_OPTIONS_H
#define FEWRAY_PIPELINE_DENOISER_OPTIONS_H

/* The options of all commands that denoise. */

#include "pipeline/options.h"

static const char *const MODELS[] = {"default", "fast", NULL}; /* as enum fewray_denoise_model */
static const char *const ISAS[] = {"auto", "plain", "avx2", "avx512", NULL};

/* Rows of a table of struct option_spec. denoise: struct fewray_denoise_options *; model, isa: int
 * *, indices of MODELS and ISAS. */
/* clang-format off */
#define DENOISER_OPTIONS(denoise, model, isa)                                                      \
    {"model", 0, OPTION_CHOICE, (model), NULL,                                                     \
     "network of the denoiser; fast has a third of the arithmetic (default)", 0, 0, MODELS},       \
    {"denoise-weights", 0, OPTION_TEXT, &(denoise)->weights_path, "FILE",                          \
     "another network for the denoiser", 0, 0, NULL},                                              \
    {"max-memory", 0, OPTION_SIZE, &(denoise)->max_memory, "SIZE",                                 \
     "for the denoiser beside the picture, as 64M or 1G (256M)", 0, 0, NULL},                      \
    {"isa", 0, OPTION_CHOICE, (isa), NULL, "highest instruction set of the denoiser", 0, 0, ISAS}
/* clang-format on */

#endif
