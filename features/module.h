/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_MODULE_H
#define FEWRAY_MODULE_H

/* Large libraries that most runs don't need (OpenImageIO, OpenCV ...) stand behind modules: shared
 * objects that are opened on first use. features/CMakeLists.txt has the function that builds one.
 */

#include "fewray/features.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Address of what the module `module` ("image" for fewray_image.so) exports as `symbol`; NULL, with
 * *error filled, where the module is missing, broken or of another version. It is looked for beside
 * the program or library that holds this function, in the folder fewray there (a library's
 * lib/fewray), in the installed folder of the same prefix (a program's), in that of the build's
 * prefix, and in the folder FEWRAY_MODULE_PATH where it is an absolute path; never in the current
 * directory. A module stays open until the process ends.
 * Thread-safe. */
void *fewray_module_symbol(const char *module, const char *symbol, struct fewray_error *error);

/* Every module exports this: FEWRAY_VERSION of its build. */
FEWRAY_API extern const char fewray_module_version[];

#ifdef __cplusplus
}
#endif
#endif
