/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_FEATURES_PRIVATE_H
#define FEWRAY_FEATURES_PRIVATE_H

/* What the files of this folder share and nobody else sees. */

#include <stdio.h>

#include "features/png.h"
#include "fewray/features.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Larger pictures are taken for damaged headers; 16384 x 16384. It also keeps every row's bytes and
 * every channel count times pixels within 64 bits. */
#define FEATURES_MAX_PIXELS   ((int64_t)1 << 28)
#define FEATURES_MAX_CHANNELS 1024

/* No compression of EXR, PNG or HDR makes more bytes than so many of one: deflate 1032, which PXR24
 * stores three of four bytes with. A file that announces more is cut off. */
#define FEATURES_MAX_RATIO 1400.0

/* Starting threads pays for pictures of more values (pixels times channels) than this. */
#define FEATURES_PARALLEL_MIN ((size_t)1 << 16)
/* ... and for files of more than this. */
#define FEATURES_PARALLEL_FILE_MIN ((size_t)1 << 19)

/* True for 1..FEATURES_MAX_PIXELS pixels. */
static inline bool features_size_ok(int64_t width, int64_t height) {
    return width > 0 && height > 0 && width <= FEATURES_MAX_PIXELS / height;
}

/* Says why path can't be read as a regular file, or FEWRAY_OK and its *size in bytes. */
int file_check_readable(const char *path, uint64_t *size, struct fewray_error *error);

/* Creates an empty temporary file beside path, open for writing: *temporary is malloc'd, the result
 * a file descriptor. Errors (a negative status) name path. */
int file_create_temporary(const char *path, char **temporary, struct fewray_error *error);

/* write() until all is written; false, with errno, where it can't be. offset -1 appends. */
bool file_write_all(int fd, const void *data, size_t size, int64_t offset);

/* A temporary file of this name isn't there any more: it became another one. */
void temporary_forget(const char *name);

/* What is wanted of an EXR file; the result is EXR_IS_FOREIGN where pixels are, the header is sound
 * and fits the file's size, but OpenEXRCore doesn't know the compression. */
enum exr_wish { EXR_HEADER, EXR_PIXELS, EXR_PIXELS_OR_FOREIGN };
#define EXR_IS_FOREIGN 1
int exr_read(const char *path, enum exr_wish wish, struct fewray_frame **out,
             struct fewray_error *error);
/* Of a frame's planes an image: R, G, B and A, of the first layer where they are in layers; else
 * Y, R or the first plane, which is grey. */
int exr_image(const struct fewray_frame *frame, const char *path, struct fewray_image **out,
              struct fewray_error *error);

/* The bytes of a PNG file, malloc'd; *bytes is NULL for a file of another format. */
int png_load(const char *path, void **bytes, size_t *size, struct fewray_error *error);
/* True for a PNG file that is cut off or has a wrong checksum; false for others. size is at
 * least 1.
 */
bool png_bytes_are_damaged(const void *bytes, size_t size);

/* IEEE binary16 of count floats, rounded to nearest even, clamped to +-65504; NaN stays NaN. */
void half_from_floats(const float *from, uint16_t *to, size_t count);
/* Of finite half floats. */
void half_to_floats(const uint16_t *from, float *to, size_t count);

#ifdef __cplusplus
}
#endif
#endif
