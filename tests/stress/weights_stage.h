/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_WEIGHTS_STAGE_H
#define FEWRAY_TESTS_WEIGHTS_STAGE_H

/* The four shipped weights files, their regions, and how a damaged one is refused. */

#include <string.h>
#include <zlib.h>

#include "denoise/nn/nn.h"
#include "denoise/weights_kpn.h"
#include "fewray/denoise.h"
#include "guide/odis/network.h"
#include "tests/unit/scratch_folder.h"

extern const unsigned char odis_weights[], odis_paper_weights[];
size_t odis_weights_size(void);
size_t odis_paper_weights_size(void);

static inline int load_denoiser(const char *path, struct fewray_error *error) {
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    fewray_denoise_options_init(&options);
    options.weights_path = path;
    const int status = fewray_denoiser_create(&options, &denoiser, error);
    assert_int_equal(status == FEWRAY_OK, denoiser != NULL);
    fewray_denoiser_destroy(&denoiser);
    return status;
}

static inline int load_guide(const char *path, struct fewray_error *error) {
    struct odis_weights *weights = NULL;
    const int status = odis_weights_load(path, &weights, error);
    assert_int_equal(status == FEWRAY_OK, weights != NULL);
    odis_weights_destroy(&weights);
    return status;
}

enum { NETWORKS = 4 };
static const struct {
    const char *name;
    const unsigned char *bytes;
    size_t (*size)(void);
    int (*load)(const char *path, struct fewray_error *error);
} networks[NETWORKS] = {
    {"denoiser", kpn_weights, kpn_weights_size, load_denoiser},
    {"fast denoiser", kpn_fast_weights, kpn_fast_weights_size, load_denoiser},
    {"guide", odis_weights, odis_weights_size, load_guide},
    {"paper's guide", odis_paper_weights, odis_paper_weights_size, load_guide},
};

/* --- a file and its regions */

enum {
    VERSION_AT = 8,
    CRC_AT = 12,
    CONTENT_AT = 16,
    INFO_AT = 20,
    NAME_BYTES = 48,
    HEAD_BYTES = NAME_BYTES + 16
};

struct file {
    uint8_t *bytes; /* with room for TRAILING more */
    size_t size;
};
enum { TRAILING = 64 };

static inline struct file file_of(int network) {
    struct file f = {.size = networks[network].size()};
    f.bytes = calloc(1, f.size + TRAILING);
    assert_non_null(f.bytes);
    memcpy(f.bytes, networks[network].bytes, f.size);
    return f;
}

static inline uint32_t integer_at(const struct file *f, size_t at) {
    const uint8_t *b = f->bytes + at;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static inline void put_integer(struct file *f, size_t at, uint32_t value) {
    for (int i = 0; i < 4; i++)
        f->bytes[at + (size_t)i] = (uint8_t)(value >> 8 * i);
}

static inline void sign(struct file *f) {
    if (f->size > CONTENT_AT)
        put_integer(f, CRC_AT,
                    (uint32_t)crc32(0, f->bytes + CONTENT_AT, (uInt)(f->size - CONTENT_AT)));
}

static inline size_t count_at(const struct file *f) {
    return INFO_AT + integer_at(f, CONTENT_AT);
}

/* Where tensor number k begins, or the file's end; *values gets the number of its halfs. */
static inline size_t tensor_at(const struct file *f, uint32_t k, size_t *values) {
    size_t at = count_at(f) + 4;
    for (uint32_t i = 0;; i++) {
        *values = 1;
        if (at >= f->size)
            return at;
        for (size_t d = 0; d < 4; d++)
            *values *= integer_at(f, at + NAME_BYTES + 4 * d);
        if (i == k)
            return at;
        at += HEAD_BYTES + 2 * *values;
    }
}

/* --- refusing */

static inline void path_of(char *path, size_t size) {
    snprintf(path, size, "%s/damaged.bin", folder);
}

static inline void store(const struct file *f) {
    char path[64];
    path_of(path, sizeof path);
    FILE *out = fopen(path, "wb");
    assert_non_null(out);
    assert_int_equal(fwrite(f->bytes, 1, f->size, out), f->size);
    assert_int_equal(fclose(out), 0);
}

static inline void refuse(int network, const struct file *f, int expected, const char *damage,
                          size_t place) {
    char path[64];
    struct fewray_error error = {.line = 77};
    path_of(path, sizeof path);
    store(f);
    const int status = networks[network].load(path, &error);
    if (status != expected || strcmp(error.file, path) || !error.what[0] ||
        strchr(error.what, '\n') || error.line)
        fail_msg("%s, %s at %zu: status %d, expected %d: %s:%d: %s", networks[network].name, damage,
                 place, status, expected, error.file, error.line, error.what);
}

#endif
