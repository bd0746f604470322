/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_FEATURES_CANCEL_H
#define FEWRAY_FEATURES_CANCEL_H

#include <stdbool.h>
#include <stddef.h>

/* Whether the caller wants the work to end: a flag, or NULL, that another thread or a signal
 * handler may set at any time, with cancel_set(). Public headers declare it a volatile int, as C++
 * has no atomic_int of C. */
static inline bool cancel_wanted(const volatile int *flag) {
    return flag && __atomic_load_n(flag, __ATOMIC_RELAXED);
}

static inline void cancel_set(volatile int *flag) {
    __atomic_store_n(flag, 1, __ATOMIC_RELAXED);
}

#endif
