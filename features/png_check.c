/* SPDX-License-Identifier: Apache-2.0 */
/* Finds damaged PNG files before libpng does, which prints to stderr under OpenImageIO.
 * Layout: https://www.w3.org/TR/png-3/#5Chunk-layout */
#include "features/features_private.h"

#include <stdio.h>
#include <string.h>
#include <zlib.h>

enum { SIGNATURE_SIZE = 8, BLOCK = 1 << 16 };

static uint32_t big_endian(const unsigned char *bytes) {
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* Reads one chunk with its checksum; type gets its four letters. False where anything is wrong. */
static bool check_chunk(FILE *file, char type[4]) {
    unsigned char head[8], sum[4], block[BLOCK];
    if (fread(head, 1, sizeof head, file) != sizeof head)
        return false;
    memcpy(type, head + 4, 4);
    uint32_t crc = (uint32_t)crc32(0, head + 4, 4);
    for (uint32_t rest = big_endian(head); rest > 0;) {
        const size_t size = rest < BLOCK ? rest : BLOCK;
        if (fread(block, 1, size, file) != size)
            return false;
        crc = (uint32_t)crc32(crc, block, (uInt)size);
        rest -= (uint32_t)size;
    }
    if (fread(sum, 1, sizeof sum, file) != sizeof sum)
        return false;
    /* Chunks of a lower-case letter are optional: readers skip what is wrong with them. */
    const bool is_optional = type[0] & 32;
    return is_optional || big_endian(sum) == crc;
}

/* Leaves the stream anywhere. */
static bool stream_is_damaged(FILE *file) {
    static const unsigned char signature[SIGNATURE_SIZE] = {137, 'P', 'N', 'G', 13, 10, 26, 10};
    unsigned char start[SIGNATURE_SIZE];
    bool damaged = false;
    if (fread(start, 1, sizeof start, file) == sizeof start &&
        memcmp(start, signature, sizeof start) == 0) {
        char type[4] = {0};
        while (!damaged && memcmp(type, "IEND", 4) != 0)
            damaged = !check_chunk(file, type);
    }
    return damaged;
}

bool png_is_damaged(const char *path) {
    FILE *file = fopen(path, "rb");
    const bool damaged = file && stream_is_damaged(file);
    if (file)
        fclose(file);
    return damaged;
}

bool png_bytes_are_damaged(const void *bytes, size_t size) {
    FILE *file = fmemopen((void *)(uintptr_t)bytes, size, "rb");
    const bool damaged = file && stream_is_damaged(file);
    if (file)
        fclose(file);
    return damaged;
}
