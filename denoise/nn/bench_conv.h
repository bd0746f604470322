/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_BENCH_CONV_H
#define FEWRAY_DENOISE_BENCH_CONV_H

/* Shared by the two halves of fewray-bench-conv: ours and oneDNN's measurement. */

#include "denoise/nn/nn.h"

/* True channel counts; a slice of the layer's rows that takes a millisecond or so. */
struct bench_shape {
    int height, width, in, out, kernel;
};

double bench_now(void); /* wall time, seconds */

/* FLOP/s of oneDNN's convolution with bias and LeakyReLU in the memory layouts of its own choice,
 * the fastest of many repetitions; 0 where it fails. The instruction set is limited to isa, and
 * must be the same in all calls. */
double bench_dnnl(const struct bench_shape *shape, enum nn_isa isa, int threads, double seconds);

#endif
