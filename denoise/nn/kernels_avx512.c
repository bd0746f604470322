/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels for x86-64 CPUs with AVX-512 F, VL, BW and DQ (Skylake-X, Zen 4 and later). */

#if defined(__AVX512F__) && defined(__AVX512VL__)
/* Fourteen pixels x 32 channels: 28 of the 32 registers hold sums, 2 weights, the rest inputs. */
#define VEC_LANES       16
#define MAX_PIXELS      14
#define MAX_BLOCKS      2
#define MAX_HALF_PIXELS 14
#define KERNELS         nn_kernels_avx512
#define KERNELS_ISA     NN_ISA_AVX512
#define KERNELS_NAME    "avx512"
#include "denoise/nn/kernels.inc.h"
#else
typedef int nothing_here; /* ISO C wants a declaration */
#endif
