/* SPDX-License-Identifier: Apache-2.0 */
/* Picks the kernels for the CPU at hand. */

#include <stdlib.h>
#include <string.h>

#include "denoise/nn/kernels.h"

bool nn_isa_from_name(const char *name, enum nn_isa *isa) {
    static const char *const names[] = {"auto", "plain", "avx2", "avx512"};
    for (int i = 0; i < 4; ++i)
        if (strcmp(name, names[i]) == 0) {
            *isa = (enum nn_isa)i;
            return true;
        }
    return false;
}

const struct nn_kernels *nn_kernels_get(enum nn_isa isa) {
    enum nn_isa limit = isa == NN_ISA_AUTO ? NN_ISA_AVX512 : isa;
    const char *wish = getenv("FEWRAY_ISA");
    enum nn_isa wished = NN_ISA_AUTO;
    if (wish && nn_isa_from_name(wish, &wished) && wished != NN_ISA_AUTO && wished < limit)
        limit = wished;

#if defined(__x86_64__)
    bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                  __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq");
    if (limit >= NN_ISA_AVX512 && avx512)
        return &nn_kernels_avx512;
    if (limit >= NN_ISA_AVX2 && avx2)
        return &nn_kernels_avx2;
#endif
    return &nn_kernels_plain;
}
