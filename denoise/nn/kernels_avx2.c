/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels for x86-64 CPUs with AVX2 and FMA (Haswell, Zen and later). */

#if defined(__AVX2__) && defined(__FMA__)
/* Six pixels x 16 channels: 12 of the 16 registers hold sums, 2 weights, 1 an input. */
#define VEC_LANES       8
#define MAX_PIXELS      6
#define MAX_BLOCKS      1
#define MAX_HALF_PIXELS 12
#define KERNELS         nn_kernels_avx2
#define KERNELS_ISA     NN_ISA_AVX2
#define KERNELS_NAME    "avx2"
#include "denoise/nn/kernels.inc.h"
#else
typedef int nothing_here; /* ISO C wants a declaration */
#endif
