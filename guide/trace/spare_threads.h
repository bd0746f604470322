/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SPARE_THREADS_H
#define FEWRAY_GUIDE_SPARE_THREADS_H

/* More aren't tried. */
enum { SPARE_THREADS_MAX = 64 };

/* How many of `wanted` more threads the system would start now. */
int spare_threads(int wanted);

#endif
