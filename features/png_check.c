/* SPDX-License-Identifier: Apache-2.0 */
/* Reads PNG files, and finds damaged ones before libpng does, which prints to stderr under
 * OpenImageIO. Layout: https://www.w3.org/TR/png-3/#5Chunk-layout */
#include "features/features_private.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
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

static const unsigned char SIGNATURE[SIGNATURE_SIZE] = {137, 'P', 'N', 'G', 13, 10, 26, 10};

/* Leaves the stream anywhere. */
static bool stream_is_damaged(FILE *file) {
    unsigned char start[SIGNATURE_SIZE];
    bool damaged = false;
    if (fread(start, 1, sizeof start, file) == sizeof start &&
        memcmp(start, SIGNATURE, sizeof start) == 0) {
        char type[4] = {0};
        while (!damaged && memcmp(type, "IEND", 4) != 0)
            damaged = !check_chunk(file, type);
    }
    return damaged;
}

bool png_bytes_are_damaged(const void *bytes, size_t size) {
    FILE *file = fmemopen((void *)(uintptr_t)bytes, size, "rb");
    const bool damaged = file && stream_is_damaged(file);
    if (file)
        fclose(file);
    return damaged;
}

/* What is left of the stream behind the `had` bytes of *bytes, whose room is `room`. */
static bool read_rest(FILE *file, unsigned char **bytes, size_t had, size_t room, size_t *size) {
    for (*size = had;;) {
        *size += fread(*bytes + *size, 1, room - *size, file);
        if (*size < room)
            return !ferror(file);
        unsigned char *more = room <= SIZE_MAX / 2 ? realloc(*bytes, room *= 2) : NULL;
        if (!more) {
            errno = ENOMEM;
            return false;
        }
        *bytes = more;
    }
}

int png_load(const char *path, void **bytes, size_t *size, struct fewray_error *error) {
    unsigned char *data = malloc(BLOCK);
    FILE *file = data ? fopen(path, "rb") : NULL;
    int status = FEWRAY_OK;
    *bytes = NULL;
    if (!data)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    const size_t had = file ? fread(data, 1, SIGNATURE_SIZE, file) : 0;
    const bool is_png = had == SIGNATURE_SIZE && !memcmp(data, SIGNATURE, SIGNATURE_SIZE);
    if (!file || ferror(file) || (is_png && !read_rest(file, &data, had, BLOCK, size)))
        status = fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't read the image: %s",
                             strerror(errno));
    if (!status && is_png)
        *bytes = data;
    else
        free(data);
    if (file)
        fclose(file);
    return status;
}
