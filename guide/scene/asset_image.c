/* SPDX-License-Identifier: Apache-2.0 */
/* Makes images what the scene needs: linear, sound, and RGB for an environment. */

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "guide/scene/assets.h"

/* IEC 61966-2-1. */
static float decode_srgb(float value) {
    return value <= 0.04045f ? value / 12.92f : powf((value + 0.055f) / 1.055f, 2.4f);
}

/* Float values of formats that hold no floats were 16-bit integers, which are sRGB-encoded as the
 * 8-bit ones are. */
static bool is_integer_format(const char *path) {
    static const char *const suffixes[] = {".png", ".ppm", ".pgm", ".pnm", ".bmp", ".tga", NULL};
    const char *dot = strrchr(path, '.');
    for (int i = 0; dot && suffixes[i]; i++)
        if (!strcasecmp(dot, suffixes[i]))
            return true;
    return false;
}

static size_t value_count(const struct fewray_image *image) {
    return (size_t)image->width * (size_t)image->height * (size_t)image->channels;
}

static size_t mend(struct fewray_image *image) {
    size_t count = value_count(image), mended = 0;
    for (size_t i = 0; i < count; i++)
        if (!(image->floats[i] >= 0 && image->floats[i] <= FLT_MAX)) {
            mended += image->floats[i] != 0;
            image->floats[i] = 0;
        }
    return mended;
}

static void linearize(struct fewray_image *image) {
    size_t count = value_count(image);
    for (size_t i = 0; i < count; i++)
        if (image->channels != 4 || i % 4 != 3)
            image->floats[i] = decode_srgb(image->floats[i]);
}

/* Puts 8-bit values, decoded, or floats of any number of channels, as RGB. */
static bool convert_to_float_rgb(struct fewray_image *image) {
    if (image->floats && image->channels == 3)
        return true;
    size_t pixels = (size_t)image->width * (size_t)image->height;
    size_t channels = (size_t)image->channels;
    float table[256], *rgb = malloc(pixels * 3 * sizeof(float) + 1);
    if (!rgb)
        return false;
    for (int i = 0; i < 256; i++)
        table[i] = decode_srgb((float)i / 255);
    for (size_t i = 0; i < pixels; i++)
        for (size_t c = 0; c < 3; c++) {
            size_t from = i * channels + (channels == 1 ? 0 : c);
            rgb[3 * i + c] = image->floats ? image->floats[from] : table[image->bytes[from]];
        }
    free(image->bytes);
    free(image->floats);
    image->bytes = NULL;
    image->floats = rgb;
    image->channels = 3;
    return true;
}

bool asset_convert_image(struct asset *asset) {
    struct fewray_image *image = asset->image;
    if (image->floats) {
        asset->mended = mend(image);
        if (asset->kind != ASSET_RAW_IMAGE && is_integer_format(asset->path))
            linearize(image);
    }
    return asset->kind != ASSET_ENVIRONMENT || convert_to_float_rgb(image);
}
