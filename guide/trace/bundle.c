/* SPDX-License-Identifier: Apache-2.0 */
/* Picks the bundles' code for the CPU at hand. */

#include "guide/trace/bundle.h"

const struct bundle_tracer *bundle_tracer_get(void) {
    switch (nn_kernels_get(NN_ISA_AUTO)->isa) {
#if defined(__x86_64__)
    case NN_ISA_AVX512:
        return &bundle_avx512;
    case NN_ISA_AVX2:
        return &bundle_avx2;
#endif
    default:
        return &bundle_plain;
    }
}
