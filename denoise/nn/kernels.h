/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_NN_KERNELS_H
#define FEWRAY_DENOISE_NN_KERNELS_H

/* The tables that kernels_*.c define, one an instruction set; nn_kernels_get() picks one. */

#include "denoise/nn/nn.h"

extern const struct nn_kernels nn_kernels_plain;
#if defined(__x86_64__)
extern const struct nn_kernels nn_kernels_avx2;
extern const struct nn_kernels nn_kernels_avx512;
#endif

#endif
