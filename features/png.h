/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PNG_H
#define FEWRAY_PNG_H

/* PNG files in memory. */

#include "fewray/features.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A PNG of (height, width, 3) sRGB-encoded bytes into *file, malloc'd; path is for messages. */
int png_encode(const char *path, int width, int height, const uint8_t *rgb, void **file,
               size_t *size, struct fewray_error *error);
/* The same of (height, width) indices into a palette of (256, 3) bytes. */
int png_encode_indexed(const char *path, int width, int height, const uint8_t *indices,
                       const uint8_t *palette, void **file, size_t *size,
                       struct fewray_error *error);

#ifdef __cplusplus
}
#endif
#endif
