/* SPDX-License-Identifier: Apache-2.0 */
/* PNG files by libpng itself: OpenImageIO would bring some 250 libraries, 0.2 s and 110 MB to a run
 * that needs it for nothing else. */
#include <png.h>
#include <stdlib.h>

#include "features/png.h"

static int encode(png_image *image, const char *path, const uint8_t *pixels, const uint8_t *palette,
                  void **file, size_t *size, struct fewray_error *error) {
    png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(*image);
    *file = malloc(bytes);
    if (!*file)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    if (!png_image_write_to_memory(image, *file, &bytes, 0, pixels, 0, palette)) {
        free(*file);
        *file = NULL;
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0, "can't encode the PNG: %s",
                           image->message);
    }
    *size = bytes;
    return FEWRAY_OK;
}

int png_encode(const char *path, int width, int height, const uint8_t *rgb, void **file,
               size_t *size, struct fewray_error *error) {
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)width,
                       .height = (png_uint_32)height,
                       .format = PNG_FORMAT_RGB};
    return encode(&image, path, rgb, NULL, file, size, error);
}

int png_encode_indexed(const char *path, int width, int height, const uint8_t *indices,
                       const uint8_t *palette, void **file, size_t *size,
                       struct fewray_error *error) {
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)width,
                       .height = (png_uint_32)height,
                       .format = PNG_FORMAT_RGB_COLORMAP,
                       .colormap_entries = 256};
    return encode(&image, path, indices, palette, file, size, error);
}
