/* SPDX-License-Identifier: Apache-2.0 */
/* The library's version, and that its header tells the same. */
#include "fewray/fewray.h"

const char *fewray_version(void) {
    return FEWRAY_VERSION;
}

_Static_assert(FEWRAY_VERSION_MAJOR == PROJECT_MAJOR && FEWRAY_VERSION_MINOR == PROJECT_MINOR &&
                   FEWRAY_VERSION_PATCH == PROJECT_PATCH,
               "fewray/fewray.h and CMakeLists.txt differ in the version");
