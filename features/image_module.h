/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_IMAGE_MODULE_H
#define FEWRAY_IMAGE_MODULE_H

/* The C face of the shim over OpenImageIO, which is the module "image". Nothing throws or prints.
 */

#include "fewray/features.h"

#ifdef __cplusplus
extern "C" {
#endif

struct image_module {
    /* Decodes the file path, which has size bytes, or, where bytes isn't NULL, such a file in
     * memory (path is then for messages). image was zeroed; its arrays are from malloc(), also
     * after a failure. */
    int (*read)(const char *path, const void *bytes, size_t size, struct fewray_image *image,
                struct fewray_error *error);
};

/* What the module exports. */
FEWRAY_API extern const struct image_module fewray_image_module;

#ifdef __cplusplus
}
#endif
#endif
