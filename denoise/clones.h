/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_CLONES_H
#define FEWRAY_DENOISE_CLONES_H

/* CLONED functions are compiled for AVX2 as well, and the loader picks what the CPU has. Without
 * contraction to FMA both give the same bits, so that no option needs to choose between them. What
 * they call must be inlined (CLONED_INLINE) to be part of it.
 *
 * Sanitizers' start-up code can't run before the loader has resolved such functions, and Clang 14
 * gives them other names than their callers look for. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) &&       \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__AVX2__)
#define CLONED __attribute__((target_clones("avx2", "default")))
#else
#define CLONED
#endif
#define CLONED_INLINE static inline __attribute__((always_inline))

#endif
