/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_FEATURES_EXR_FILE_H
#define FEWRAY_FEATURES_EXR_FILE_H

/* What the reading, writing and rewriting of EXR files through OpenEXRCore share. */

#include <openexr.h>

#include "features/features_private.h"

/* The first thing that the library said against the file. */
struct exr_complaint {
    char text[256];
};

/* Opens a file to read; *complaint must live as long as *out, which the caller finishes. *size gets
 * the file's bytes. */
int exr_file_open(const char *path, struct exr_complaint *complaint, exr_context_t *out,
                  uint64_t *size, struct fewray_error *error);
/* The error that a result of the library stands for. */
int exr_file_fail(struct fewray_error *error, const char *path, exr_result_t code,
                  const struct exr_complaint *complaint);
/* Makes a file, whole or not at all: fill() gets the context for its header and chunks. */
int exr_file_write(const char *path, exr_result_t (*fill)(exr_context_t exr, void *user),
                   void *user, struct fewray_error *error);

/* The name of a channel's plane. Of several parts each is a layer, whose channels are often called
 * R, G, B alone: then the part's name, NULL where the file has one part, stands for the layer's.
 * False where it has no name that a plane may have. */
bool exr_plane_name(const char *part_name, const char *channel, char name[FEWRAY_NAME_MAX]);
/* Whether OpenEXRCore 3.1 can: it doesn't know DWA, and reads wrong pixels of B44 where a block has
 * an odd size. */
bool exr_compression_works(exr_compression_t compression);
/* For ZIP and ZIPS in place of the library's own, slower way; the decoder's user data is a struct
 * zip_worker. */
exr_result_t exr_unzip(exr_decode_pipeline_t *decode);

#endif
