/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_BENCH_CONV_H
#define FEWRAY_DENOISE_BENCH_CONV_H

/* Shared by the two halves of fewray-bench-conv: ours and oneDNN's measurement. */

struct bench_shape {
    int height, width, in, out, kernel;
};

double bench_now(void); /* wall time, seconds */

/* FLOP/s of oneDNN's convolution with bias and LeakyReLU on one thread, in the memory layouts of
 * its own choice; 0 where it fails. */
double bench_dnnl(const struct bench_shape *shape, double seconds);

#endif
