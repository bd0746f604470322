/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the weights container that the training scripts write. */

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "denoise/nn/nn.h"

#define MAX_FILE_BYTES ((size_t)256 << 20) /* hundreds of times our largest network */
#define MAX_TENSORS    1024
#define NAME_BYTES     sizeof(((struct nn_weight *)0)->name)
#define HEADER_BYTES   16 /* magic, version, CRC */

static const char magic[] = "FEWRAYNN";
enum { MAGIC_BYTES = sizeof magic - 1 };

/* What is left of the file while it is read. */
struct reader {
    const uint8_t *at;
    size_t left;
    const char *name;
    struct fewray_error *error;
};

static int damaged(const struct reader *r, const char *what) {
    return fewray_fail(r->error, FEWRAY_ERROR_FORMAT, r->name, 0,
                       "weights file is damaged (%s); export or download it again", what);
}

static const uint8_t *take(struct reader *r, size_t bytes) {
    if (bytes > r->left)
        return NULL;
    const uint8_t *taken = r->at;
    r->at += bytes;
    r->left -= bytes;
    return taken;
}

static uint32_t little_endian(const uint8_t *b) {
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static bool take_uint32(struct reader *r, uint32_t *value) {
    const uint8_t *b = take(r, 4);
    if (b)
        *value = little_endian(b);
    return b != NULL;
}

/* IEEE 754 binary16 -> binary32, exact. */
static float half_to_float(uint16_t half) {
    uint32_t sign = (uint32_t)(half & 0x8000) << 16, bits = half & 0x7fff;
    float value;
    if (bits < 0x0400) { /* zero and subnormals: a multiple of 2^-24 */
        value = (float)bits * 0x1p-24f;
        memcpy(&bits, &value, 4);
    } else if (bits >= 0x7c00) {
        bits = 0x7f800000 | (bits & 0x3ff) << 13;
    } else {
        bits = (bits << 13) + ((127 - 15) << 23);
    }
    bits |= sign;
    memcpy(&value, &bits, 4);
    return value;
}

/* Reads one tensor's name and shape, and leaves *halfs at its data. */
static int read_tensor_head(struct reader *r, struct nn_weight *tensor, size_t *floats,
                            const uint8_t **halfs) {
    const uint8_t *name = take(r, NAME_BYTES);
    if (!name)
        return damaged(r, "it ends within a tensor's name");
    if (name[0] == 0 || !memchr(name, 0, NAME_BYTES))
        return damaged(r, "a tensor's name is empty or too long");
    memcpy(tensor->name, name, NAME_BYTES);
    for (size_t i = strlen(tensor->name); i < NAME_BYTES; ++i)
        if (name[i])
            return damaged(r, "something stands behind a tensor's name");

    *floats = 1;
    for (int k = 0; k < 4; ++k) {
        uint32_t extent;
        if (!take_uint32(r, &extent))
            return damaged(r, "it ends within a tensor's shape");
        if (extent == 0 || extent > INT_MAX || *floats > r->left / 2 / extent)
            return damaged(r, "a tensor's shape doesn't fit the file");
        tensor->shape[k] = (int)extent;
        *floats *= extent;
    }
    *halfs = take(r, *floats * 2);
    return *halfs ? FEWRAY_OK : damaged(r, "it ends within a tensor's values");
}

static bool name_taken(const struct nn_weights *weights, int count, const char *name) {
    for (int i = 0; i < count; ++i)
        if (strcmp(weights->tensors[i].name, name) == 0)
            return true;
    return false;
}

static int read_tensors(struct reader *r, struct nn_weights *weights) {
    float *next = weights->storage;
    for (int i = 0; i < weights->count; ++i) {
        struct nn_weight *tensor = &weights->tensors[i];
        size_t floats = 0;
        const uint8_t *halfs = NULL;
        int status = read_tensor_head(r, tensor, &floats, &halfs);
        if (status)
            return status;
        if (name_taken(weights, i, tensor->name))
            return damaged(r, "two tensors have the same name");
        for (size_t k = 0; k < floats; ++k) {
            uint16_t half = (uint16_t)(halfs[2 * k] | halfs[2 * k + 1] << 8);
            if ((half & 0x7c00) == 0x7c00)
                return damaged(r, "a weight is infinite or not a number");
            next[k] = half_to_float(half);
        }
        tensor->data = next;
        next += floats;
    }
    return r->left == 0 ? FEWRAY_OK : damaged(r, "bytes follow the last tensor");
}

static bool has_magic(const uint8_t *bytes, size_t size) {
    return size >= MAGIC_BYTES && memcmp(bytes, magic, MAGIC_BYTES) == 0;
}

static int read_header(struct reader *r) {
    if (r->left < HEADER_BYTES || !has_magic(r->at, r->left))
        return fewray_fail(r->error, FEWRAY_ERROR_FORMAT, r->name, 0, "not a fewray weights file");
    uint32_t version = little_endian(r->at + 8), crc = little_endian(r->at + 12);
    if (version != 1)
        return fewray_fail(r->error, FEWRAY_ERROR_UNSUPPORTED, r->name, 0,
                           "weights file of version %u, only 1 is known; export it again",
                           (unsigned)version);
    take(r, HEADER_BYTES);
    if (r->left > MAX_FILE_BYTES)
        return damaged(r, "it is too large");
    if ((uint32_t)crc32(0, r->at, (uInt)r->left) != crc)
        return damaged(r, "its checksum differs");
    return FEWRAY_OK;
}

static int read_info(struct reader *r, struct nn_weights *weights) {
    uint32_t length;
    const uint8_t *info = NULL;
    if (!take_uint32(r, &length) || !(info = take(r, length)))
        return damaged(r, "it ends within the info text");
    if (memchr(info, 0, length))
        return damaged(r, "the info isn't text");
    weights->info = malloc((size_t)length + 1);
    if (!weights->info)
        return fewray_fail(r->error, FEWRAY_ERROR_MEMORY, r->name, 0, "no memory for weights");
    memcpy(weights->info, info, length);
    weights->info[length] = '\0';
    return FEWRAY_OK;
}

int nn_weights_parse(const void *bytes, size_t size, const char *name, struct nn_weights **out,
                     struct fewray_error *error) {
    *out = NULL;
    struct reader r = {bytes, size, name, error};
    int status = read_header(&r);
    if (status)
        return status;
    struct nn_weights *weights = calloc(1, sizeof *weights);
    if (!weights)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, name, 0, "no memory for weights");
    weights->name = strdup(name);
    status = weights->name
                 ? read_info(&r, weights)
                 : fewray_fail(error, FEWRAY_ERROR_MEMORY, name, 0, "no memory for weights");
    if (status)
        goto fail;

    uint32_t count = 0;
    if (!take_uint32(&r, &count) || count > MAX_TENSORS) {
        status = damaged(&r, "no sensible number of tensors");
        goto fail;
    }
    weights->count = (int)count;
    weights->tensors = calloc(count + 1, sizeof *weights->tensors);
    weights->storage = malloc(r.left / 2 * sizeof(float) + 1); /* never less than all tensors */
    if (!weights->tensors || !weights->storage) {
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, name, 0, "no memory for weights");
        goto fail;
    }
    status = read_tensors(&r, weights);
    if (status)
        goto fail;
    *out = weights;
    return FEWRAY_OK;

fail:
    nn_weights_destroy(&weights);
    return status;
}

/* The whole file, malloc'd; its length needn't be known, so that pipes work too. Of what is no
 * weights file only the beginning is read: it may be endless. */
static int read_file(const char *path, uint8_t **bytes, size_t *size, struct fewray_error *error) {
    FILE *file = fopen(path, "rb");
    if (!file)
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't open weights: %s",
                           strerror(errno));
    int status = FEWRAY_OK;
    uint8_t *data = NULL;
    size_t capacity = 0, length = 0, got;
    do {
        if (length == capacity) {
            capacity = capacity ? capacity * 2 : (size_t)1 << 20;
            uint8_t *grown = capacity <= 2 * MAX_FILE_BYTES ? realloc(data, capacity) : NULL;
            if (!grown) {
                status = fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0,
                                     "weights file is too large for memory");
                goto fail;
            }
            data = grown;
        }
        got = fread(data + length, 1, capacity - length, file);
        length += got;
    } while (got > 0 && has_magic(data, length));
    if (ferror(file)) {
        status =
            fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't read weights: %s", strerror(errno));
        goto fail;
    }
    fclose(file);
    *bytes = data;
    *size = length;
    return FEWRAY_OK;

fail:
    free(data);
    fclose(file);
    return status;
}

int nn_weights_read(const char *path, struct nn_weights **out, struct fewray_error *error) {
    *out = NULL;
    uint8_t *bytes = NULL;
    size_t size = 0;
    int status = read_file(path, &bytes, &size, error);
    if (status == FEWRAY_OK)
        status = nn_weights_parse(bytes, size, path, out, error);
    free(bytes);
    return status;
}

void nn_weights_destroy(struct nn_weights **weights) {
    if (!*weights)
        return;
    free((*weights)->tensors);
    free((*weights)->info);
    free((*weights)->name);
    free((*weights)->storage);
    free(*weights);
    *weights = NULL;
}

const struct nn_weight *nn_weights_find(const struct nn_weights *weights, const char *name,
                                        const int shape[4], struct fewray_error *error) {
    for (int i = 0; i < weights->count; ++i) {
        const struct nn_weight *tensor = &weights->tensors[i];
        if (strcmp(tensor->name, name) != 0)
            continue;
        const int *has = tensor->shape;
        if (memcmp(has, shape, sizeof tensor->shape) == 0)
            return tensor;
        fewray_fail(error, FEWRAY_ERROR_FORMAT, weights->name, 0,
                    "weights of another network: %s is (%d, %d, %d, %d), not (%d, %d, %d, %d)",
                    name, has[0], has[1], has[2], has[3], shape[0], shape[1], shape[2], shape[3]);
        return NULL;
    }
    fewray_fail(error, FEWRAY_ERROR_FORMAT, weights->name, 0,
                "weights of another network: no tensor %s", name);
    return NULL;
}
