/* SPDX-License-Identifier: Apache-2.0 */
#if defined(__x86_64__)
#define BUNDLE_NAME bundle_avx512
#include "guide/trace/bundle.inc.h"
#else
typedef int bundle_nothing_here;
#endif
