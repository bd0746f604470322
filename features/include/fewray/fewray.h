/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_FEWRAY_H
#define FEWRAY_FEWRAY_H

/* All of libfewray, and its version: a change that a program would have to follow raises the major
 * version, and with it the shared library's name (libfewray.so.1) and the version of its symbols
 * (FEWRAY_1). */

#define FEWRAY_VERSION_MAJOR 1
#define FEWRAY_VERSION_MINOR 0
#define FEWRAY_VERSION_PATCH 0

#include "fewray/denoise.h"
#include "fewray/features.h"

#if __has_include("fewray/pipeline.h") /* not where the library was built without the renderer */
#include "fewray/guide.h"
#include "fewray/guiding.h"
#include "fewray/pipeline.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* "1.0.0": of the library that runs, where the macros tell that of the header. */
FEWRAY_API const char *fewray_version(void);

#ifdef __cplusplus
}
#endif
#endif
