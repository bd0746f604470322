/* SPDX-License-Identifier: Apache-2.0 */
/* Images in, by the module "image", and PNG out. */
#include "features/features_private.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "features/image_module.h"
#include "features/module.h"

/* NULL, with *error filled in the name of path, where the module can't be had. */
static const struct image_module *open_module(const char *path, struct fewray_error *error) {
    struct fewray_error why = {0};
    char text[sizeof why.file + sizeof why.what + 16];
    const struct image_module *module = fewray_module_symbol("image", "fewray_image_module", &why);
    if (!module)
        fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0, "%s",
                    fewray_error_text(&why, text, sizeof text));
    return module;
}

/* bytes NULL: from the file of that size. */
static int read_image(const char *path, const void *bytes, size_t size, struct fewray_image **out,
                      struct fewray_error *error) {
    const struct image_module *module = open_module(path, error);
    *out = NULL;
    if (!module)
        return FEWRAY_ERROR_UNSUPPORTED;
    *out = calloc(1, sizeof **out);
    if (!*out)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    const int status = module->read(path, bytes, size, *out, error);
    if (status != FEWRAY_OK)
        fewray_image_destroy(out);
    return status;
}

static int fail_damaged_png(const char *path, struct fewray_error *error) {
    return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                       "can't read the image: the PNG file is cut off or damaged");
}

static bool is_exr(const void *bytes, size_t size) {
    static const unsigned char magic[] = {0x76, 0x2f, 0x31, 0x01};
    return size >= sizeof magic && !memcmp(bytes, magic, sizeof magic);
}

static bool is_exr_file(const char *path) {
    unsigned char start[4];
    FILE *file = fopen(path, "rb");
    const bool exr = file && is_exr(start, fread(start, 1, sizeof start, file));
    if (file)
        fclose(file);
    return exr;
}

/* OpenImageIO reads EXR by OpenEXR's older library, which allocates what a header announces: it
 * gets what no other can decode alone. */
static int read_exr(const char *path, size_t size, struct fewray_image **out,
                    struct fewray_error *error) {
    struct fewray_frame *frame = NULL;
    int status = exr_read(path, EXR_PIXELS_OR_FOREIGN, &frame, error);
    if (status == EXR_IS_FOREIGN)
        status = read_image(path, NULL, size, out, error);
    else if (status == FEWRAY_OK)
        status = exr_image(frame, path, out, error);
    fewray_frame_destroy(&frame);
    return status;
}

int fewray_image_read(const char *path, struct fewray_image **out, struct fewray_error *error) {
    *out = NULL;
    uint64_t size = 0;
    const int readable = file_check_readable(path, &size, error);
    if (readable != FEWRAY_OK)
        return readable;
    /* What is checked must be what is decoded, though another program changes the file. */
    void *bytes;
    size_t byte_count;
    int status = png_load(path, &bytes, &byte_count, error);
    if (!status && bytes)
        status = fewray_image_read_memory(path, bytes, byte_count, out, error);
    else if (!status && is_exr_file(path))
        status = read_exr(path, size, out, error);
    else if (!status)
        status = read_image(path, NULL, size, out, error);
    free(bytes);
    return status;
}

int fewray_image_read_memory(const char *name, const void *bytes, size_t size,
                             struct fewray_image **out, struct fewray_error *error) {
    *out = NULL;
    if (size == 0)
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, name, 0,
                           "can't read the image: it is empty");
    if (is_exr(bytes, size))
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, name, 0,
                           "an EXR file within another file is not supported");
    if (png_bytes_are_damaged(bytes, size))
        return fail_damaged_png(name, error);
    return read_image(name, bytes, size, out, error);
}

void fewray_image_destroy(struct fewray_image **image) {
    if (!*image)
        return;
    free((*image)->bytes);
    free((*image)->floats);
    free(*image);
    *image = NULL;
}

int fewray_image_write_png(const char *path, int width, int height, const uint8_t *rgb,
                           struct fewray_error *error) {
    void *file = NULL;
    size_t size = 0;
    if (!features_size_ok(width, height))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, path, 0,
                           "a picture of %d x %d pixels is impossible", width, height);
    int status = png_encode(path, width, height, rgb, &file, &size, error);
    if (status == FEWRAY_OK)
        status = fewray_write_file(path, file, size, error);
    free(file);
    return status;
}

/* IEC 61966-2-1; NaN becomes black. */
static uint8_t srgb_byte(float linear) {
    if (!(linear > 0.0f))
        return 0;
    if (linear >= 1.0f)
        return 255;
    const float encoded =
        linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
    return (uint8_t)(encoded * 255.0f + 0.5f);
}

int fewray_frame_write_png(const struct fewray_frame *frame, const char *path,
                           struct fewray_error *error) {
    float *planes[3];
    if (!fewray_frame_layer(frame, FEWRAY_COLOR, planes))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, path, 0,
                           "the picture has no channels R, G, B");
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    uint8_t *rgb = malloc(3 * pixels);
    if (!rgb)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    for (size_t i = 0; i < pixels; i++)
        for (size_t c = 0; c < 3; c++)
            rgb[3 * i + c] = srgb_byte(planes[c][i]);
    const int status = fewray_image_write_png(path, frame->width, frame->height, rgb, error);
    free(rgb);
    return status;
}
