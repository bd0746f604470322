/* SPDX-License-Identifier: Apache-2.0 */
/* An image, as a texture from a file and as one that a scene carries within itself. */

#include "tests/fuzz/fuzz.h"

static void check(int status, struct fewray_image **image, const struct fewray_error *error) {
    fuzz_check_error(status, error);
    FUZZ_CHECK(!status == !!*image);
    if (*image) {
        FUZZ_CHECK((*image)->width > 0 && (*image)->height > 0);
        FUZZ_CHECK(!(*image)->bytes != !(*image)->floats);
        FUZZ_CHECK((*image)->channels == 1 || (*image)->channels == 3 || (*image)->channels == 4);
    }
    fewray_image_destroy(image);
}

/* The ending that each format's first byte stands for. */
static const char *name_for(const uint8_t *data, size_t size) {
    switch (size ? data[0] : 0) {
    case 0xff:
        return "image.jpg";
    case '#':
        return "image.hdr";
    case 0x76:
        return "image.exr";
    case 'I':
        return "image.tif";
    case 'B':
        return "image.bmp";
    case 'P':
        return "image.ppm";
    case 0:
        return "image.tga";
    default:
        return "image.png";
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    struct fewray_image *image = NULL;
    struct fewray_error error = {0};
    int status = fewray_image_read(fuzz_file(name_for(data, size), data, size), &image, &error);
    check(status, &image, &error);
    status = fewray_image_read_memory(name_for(data, size), data, size, &image, &error);
    check(status, &image, &error);
    return 0;
}
