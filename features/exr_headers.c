/* SPDX-License-Identifier: Apache-2.0 */
/* The headers of an EXR file, before OpenImageIO reads it by OpenEXR's older library. That one
 * allocates what an attribute announces, and goes by an attribute's type where its size says
 * something else. (OpenEXRCore, which reads frames, checks more.) */
#include "features/features_private.h"

#include <string.h>

#define NAME_MAX_BYTES 255

struct header_reader {
    FILE *file;
    uint64_t size; /* of the file */
};

/* Takes a string and its 0; false where it is too long or the file ends. */
static bool take_name(struct header_reader *in, char name[NAME_MAX_BYTES + 1]) {
    for (int i = 0; i <= NAME_MAX_BYTES; i++) {
        const int c = getc(in->file);
        if (c < 0)
            return false;
        name[i] = (char)c;
        if (!c)
            return true;
    }
    return false;
}

static bool take_word(struct header_reader *in, uint32_t *value) {
    unsigned char b[4];
    if (fread(b, 1, sizeof b, in->file) != sizeof b)
        return false;
    *value = b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
    return true;
}

static bool skip(struct header_reader *in, uint32_t bytes) {
    return bytes <= in->size - (uint64_t)ftell(in->file) &&
           fseek(in->file, (long)bytes, SEEK_CUR) == 0;
}

/* Bytes of the types of one size; 0: another. */
static uint32_t type_bytes(const char *type) {
    static const struct {
        const char *type;
        uint32_t bytes;
    } types[] = {
        {"box2i", 16},      {"box2f", 16},   {"chromaticities", 32},
        {"compression", 1}, {"double", 8},   {"envmap", 1},
        {"float", 4},       {"int", 4},      {"keycode", 28},
        {"lineOrder", 1},   {"m33f", 36},    {"m33d", 72},
        {"m44f", 64},       {"m44d", 128},   {"rational", 8},
        {"tiledesc", 9},    {"timecode", 8}, {"v2i", 8},
        {"v2f", 8},         {"v2d", 16},     {"v3i", 12},
        {"v3f", 12},        {"v3d", 24},     {"deepImageState", 1},
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (!strcmp(types[i].type, type))
            return types[i].bytes;
    return 0;
}

/* Names with 16 bytes each, up to an empty one. */
static bool skip_channels(struct header_reader *in, uint32_t bytes) {
    const long begin = ftell(in->file);
    char name[NAME_MAX_BYTES + 1];
    do
        if (!take_name(in, name) || (name[0] && !skip(in, 16)))
            return false;
    while (name[0]);
    return (uint64_t)(ftell(in->file) - begin) == bytes;
}

static bool skip_preview(struct header_reader *in, uint32_t bytes) {
    uint32_t width, height;
    return take_word(in, &width) && take_word(in, &height) &&
           8 + 4 * (double)width * height == bytes && skip(in, bytes - 8);
}

static bool skip_value(struct header_reader *in, const char *type, uint32_t bytes) {
    if (!strcmp(type, "chlist"))
        return skip_channels(in, bytes);
    if (!strcmp(type, "preview"))
        return skip_preview(in, bytes);
    const uint32_t fixed = type_bytes(type);
    return (!fixed || fixed == bytes) && skip(in, bytes);
}

/* *empty: it has no attributes, and stands behind the last of several parts. */
static bool skip_header(struct header_reader *in, bool *empty) {
    char name[NAME_MAX_BYTES + 1], type[NAME_MAX_BYTES + 1];
    uint32_t bytes;
    for (*empty = true;; *empty = false) {
        if (!take_name(in, name))
            return false;
        if (!name[0])
            return true;
        if (!take_name(in, type) || !take_word(in, &bytes) || !skip_value(in, type, bytes))
            return false;
    }
}

bool exr_headers_fit(FILE *file, uint64_t size) {
    struct header_reader in = {file, size};
    uint32_t version;
    bool empty = false;
    if (fseek(file, 4, SEEK_SET) || !take_word(&in, &version))
        return false;
    const bool several = version & 0x1000;
    do
        if (!skip_header(&in, &empty))
            return false;
    while (several && !empty);
    return true;
}
