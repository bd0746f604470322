/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels for any CPU: vectors of four floats, which compilers map to SSE2, NEON or scalars. */

/* Two pixels x 16 channels: 8 of SSE2's 16 registers hold sums; without FMA each product needs one
 * more. */
#define VEC_LANES       4
#define MAX_PIXELS      2
#define MAX_BLOCKS      1
#define MAX_HALF_PIXELS 4
#define KERNELS         nn_kernels_plain
#define KERNELS_ISA     NN_ISA_PLAIN
#define KERNELS_NAME    "plain"
#include "denoise/nn/kernels.inc.h"
