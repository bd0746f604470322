/* SPDX-License-Identifier: Apache-2.0 */
/* The weights container: what was written is read, and everything damaged is refused. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include <cmocka.h>

#include "denoise/nn/nn.h"

/* A file under construction. */
struct file {
    uint8_t bytes[16384];
    size_t size;
};

static void put(struct file *f, const void *bytes, size_t size) {
    assert_true(f->size + size <= sizeof f->bytes);
    if (size)
        memcpy(f->bytes + f->size, bytes, size);
    f->size += size;
}
static void put_integer(struct file *f, uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i)
        put(f, &(uint8_t){(uint8_t)(value >> 8 * i)}, 1);
}
static void put_head(struct file *f, const char *name, const int shape[4]) {
    char padded[48] = {0};
    strncpy(padded, name, 47);
    put(f, padded, sizeof padded);
    for (int i = 0; i < 4; ++i)
        put_integer(f, (uint32_t)shape[i], 4);
}
static void begin(struct file *f, const char *info, uint32_t count) {
    f->size = 0;
    put(f, "FEWRAYNN", 8);
    put_integer(f, 1, 4);
    put_integer(f, 0, 4);
    put_integer(f, strlen(info), 4);
    put(f, info, strlen(info));
    put_integer(f, count, 4);
}
static void sign(struct file *f) {
    uint32_t crc = (uint32_t)crc32(0, f->bytes + 16, (uInt)(f->size - 16));
    for (int i = 0; i < 4; ++i)
        f->bytes[12 + i] = (uint8_t)(crc >> 8 * i);
}

static uint16_t half_at(int i) {
    return (uint16_t)(i * 7919 % 0x7c00 | (i & 1) << 15);
}

/* A 3x3 layer of 3 -> 18 channels. */
enum { IN = 3, OUT = 18 };
static void sample(struct file *f) {
    begin(f, "{\"name\": \"sample\"}", 2);
    put_head(f, "layer.weight", (int[4]){OUT, IN, 3, 3});
    for (int i = 0; i < OUT * IN * 9; ++i)
        put_integer(f, half_at(i), 2);
    put_head(f, "layer.bias", (int[4]){OUT, 1, 1, 1});
    for (int i = 0; i < OUT; ++i)
        put_integer(f, half_at(i + 1000), 2);
    sign(f);
}

static double half_value(uint16_t half) {
    int exponent = half >> 10 & 31, fraction = half & 1023;
    double value = exponent ? ldexp(1024 + fraction, exponent - 25) : ldexp(fraction, -24);
    return half & 0x8000 ? -value : value;
}

/* Parses an exactly sized copy, so that memory checkers see each byte read too far. */
static int parse(const struct file *f, struct nn_weights **out, struct fewray_error *error) {
    uint8_t *copy = malloc(f->size ? f->size : 1);
    assert_non_null(copy);
    memcpy(copy, f->bytes, f->size);
    int status = nn_weights_parse(copy, f->size, "sample.weights", out, error);
    free(copy);
    return status;
}
static void assert_refused(const struct file *f, int expected) {
    struct fewray_error error = {0};
    struct nn_weights *weights = (struct nn_weights *)f;
    assert_int_equal(parse(f, &weights, &error), expected);
    assert_null(weights);
    assert_string_equal(error.file, "sample.weights");
    assert_true(error.what[0] != '\0');
    assert_int_equal(parse(f, &weights, NULL), expected);
}

static void test_round_trip(void **state) {
    (void)state;
    struct file f;
    struct nn_weights *weights = NULL;
    struct fewray_error error;
    sample(&f);
    assert_int_equal(parse(&f, &weights, &error), FEWRAY_OK);
    assert_int_equal(weights->count, 2);
    assert_string_equal(weights->info, "{\"name\": \"sample\"}");
    const struct nn_weight *w =
        nn_weights_find(weights, "layer.weight", (int[4]){OUT, IN, 3, 3}, &error);
    assert_non_null(w);
    for (int i = 0; i < OUT * IN * 9; ++i)
        assert_true(w->data[i] == half_value(half_at(i)));
    nn_weights_destroy(&weights);
    assert_null(weights);
    nn_weights_destroy(&weights);
}

static void test_all_finite_halfs_are_exact(void **state) {
    (void)state;
    for (int high = 0; high < 256; high += 4) {
        struct file f;
        struct nn_weights *weights = NULL;
        int values = 0;
        begin(&f, "", 1);
        put_head(&f, "a", (int[4]){1024, 1, 1, 1});
        for (int i = 0; i < 1024; ++i, ++values)
            put_integer(&f, (uint64_t)(high << 8 | i), 2);
        sign(&f);
        if ((high & 0x7c) == 0x7c) { /* infinities and NaN */
            assert_refused(&f, FEWRAY_ERROR_FORMAT);
            continue;
        }
        assert_int_equal(parse(&f, &weights, NULL), FEWRAY_OK);
        for (int i = 0; i < values; ++i) {
            double expected = half_value((uint16_t)(high << 8 | i));
            assert_true(weights->tensors[0].data[i] == expected);
            assert_true(!signbit(weights->tensors[0].data[i]) == !signbit(expected));
        }
        nn_weights_destroy(&weights);
    }
}

static void test_truncated_at_every_length_is_refused(void **state) {
    (void)state;
    struct file f;
    sample(&f);
    for (size_t size = 0, whole = f.size; size < whole; ++size) {
        f.size = size;
        assert_refused(&f, FEWRAY_ERROR_FORMAT);
        struct file resigned = f; /* a right checksum doesn't save it */
        if (size >= 16) {
            sign(&resigned);
            assert_refused(&resigned, FEWRAY_ERROR_FORMAT);
        }
    }
}

static void test_every_flipped_bit_is_refused(void **state) {
    (void)state;
    struct file f;
    sample(&f);
    for (size_t i = 0; i < f.size; ++i) {
        f.bytes[i] ^= (uint8_t)(1 << i % 8);
        bool version = i >= 8 && i < 12;
        assert_refused(&f, version ? FEWRAY_ERROR_UNSUPPORTED : FEWRAY_ERROR_FORMAT);
        f.bytes[i] ^= (uint8_t)(1 << i % 8);
    }
}

static void test_impossible_shapes_and_counts_are_refused(void **state) {
    (void)state;
    static const int shapes[][4] = {
        {0, 1, 1, 1},          {-1, 1, 1, 1},        {1, 1, 1, -1},
        {1 << 30, 4, 1, 1},    {65536, 65536, 1, 1}, {65536, 65536, 65536, 65536},
        {2147483647, 2, 1, 1}, {1 << 16, 1, 1, 1},   {3, 1, 1, 1}, /* one value too many */
        {1, 1, 1, 1},                                              /* and one too few */
    };
    struct file f;
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; ++i) {
        begin(&f, "", 1);
        put_head(&f, "a", shapes[i]);
        put_integer(&f, 0, 4);
        sign(&f);
        assert_refused(&f, FEWRAY_ERROR_FORMAT);
    }
    static const uint32_t counts[] = {1, 1024, 1025, 0x7fffffff, 0x80000000, 0xffffffff};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
        begin(&f, "", counts[i]);
        sign(&f);
        assert_refused(&f, FEWRAY_ERROR_FORMAT);
    }
    begin(&f, "", 0); /* an info text longer than the file */
    memset(f.bytes + 16, 0xff, 4);
    sign(&f);
    assert_refused(&f, FEWRAY_ERROR_FORMAT);
}

static void test_bad_names_are_refused(void **state) {
    (void)state;
    struct file f;
    begin(&f, "", 2);
    for (int i = 0; i < 2; ++i) {
        put_head(&f, "twice", (int[4]){1, 1, 1, 1});
        put_integer(&f, 0, 2);
    }
    sign(&f);
    assert_refused(&f, FEWRAY_ERROR_FORMAT);

    begin(&f, "", 1);
    put_head(&f, "", (int[4]){1, 1, 1, 1});
    put_integer(&f, 0, 2);
    sign(&f);
    assert_refused(&f, FEWRAY_ERROR_FORMAT);
    memset(f.bytes + 24, 'x', 48); /* no zero at the end */
    sign(&f);
    assert_refused(&f, FEWRAY_ERROR_FORMAT);
}

static void test_damaged_content_with_right_checksum_never_crashes(void **state) {
    (void)state;
    struct file good, f;
    sample(&good);
    srand(5);
    for (int round = 0; round < 20000; ++round) {
        f = good;
        for (int k = 0; k < 3; ++k)
            f.bytes[16 + rand() % 120] = (uint8_t)rand();
        sign(&f);
        struct nn_weights *weights = NULL;
        if (parse(&f, &weights, NULL) == FEWRAY_OK)
            nn_weights_destroy(&weights);
        assert_null(weights);
    }
}

static void test_find_names_what_is_missing_or_misshapen(void **state) {
    (void)state;
    struct file f;
    struct nn_weights *weights = NULL;
    struct fewray_error error;
    sample(&f);
    assert_int_equal(parse(&f, &weights, &error), FEWRAY_OK);
    assert_null(nn_weights_find(weights, "other.weight", (int[4]){1, 1, 1, 1}, &error));
    assert_non_null(strstr(error.what, "other.weight"));
    assert_null(nn_weights_find(weights, "layer.bias", (int[4]){OUT, 1, 1, 2}, &error));
    assert_non_null(strstr(error.what, "layer.bias"));
    nn_weights_destroy(&weights);
}

static void test_pack_puts_weights_in_lanes_and_zeros_elsewhere(void **state) {
    (void)state;
    struct file f;
    struct nn_weights *weights = NULL;
    struct nn_conv conv;
    struct fewray_error error;
    sample(&f);
    assert_int_equal(parse(&f, &weights, &error), FEWRAY_OK);
    assert_int_equal(nn_conv_pack(&conv, weights, "layer", 3, IN, OUT, &error), FEWRAY_OK);
    assert_true(conv.kernel == 3 && conv.in == 16 && conv.in_used == 4 && conv.out == 32);
    assert_int_equal(conv.out_used, (OUT + 7) / 8 * 8);
    for (int o = 0; o < conv.out; ++o) {
        assert_true(conv.bias[o] == (o < OUT ? half_value(half_at(o + 1000)) : 0.0));
        for (int tap = 0; tap < 9; ++tap)
            for (int i = 0; i < conv.in; ++i) {
                int lane = ((o / 16 * 9 + tap) * 16 + i) * 16 + o % 16;
                bool real = o < OUT && i < IN;
                double expected = real ? half_value(half_at((o * IN + i) * 9 + tap)) : 0.0;
                assert_true(conv.weights[lane] == expected);
            }
    }
    nn_conv_clear(&conv);
    nn_conv_clear(&conv);
    assert_int_equal(nn_conv_pack(&conv, weights, "layer", 1, IN, OUT, &error),
                     FEWRAY_ERROR_FORMAT);
    assert_int_equal(nn_conv_pack(&conv, weights, "none", 3, IN, OUT, &error), FEWRAY_ERROR_FORMAT);
    assert_int_equal(nn_conv_pack(&conv, weights, "layer", 5, IN, OUT, &error),
                     FEWRAY_ERROR_ARGUMENT);
    assert_null(conv.weights);
    nn_weights_destroy(&weights);
}

static void test_file_is_read_and_missing_file_is_named(void **state) {
    (void)state;
    struct file f;
    struct nn_weights *weights = NULL;
    struct fewray_error error;
    sample(&f);
    const char *path = "test_nn_weights.tmp";
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(fwrite(f.bytes, 1, f.size, file) == f.size);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(nn_weights_read(path, &weights, &error), FEWRAY_OK);
    assert_int_equal(weights->count, 2);
    nn_weights_destroy(&weights);
    remove(path);
    assert_int_equal(nn_weights_read(path, &weights, &error), FEWRAY_ERROR_IO);
    assert_string_equal(error.file, path);
    assert_int_equal(nn_weights_read(".", &weights, &error), FEWRAY_ERROR_IO); /* a folder */
    assert_null(weights);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_all_finite_halfs_are_exact),
        cmocka_unit_test(test_truncated_at_every_length_is_refused),
        cmocka_unit_test(test_every_flipped_bit_is_refused),
        cmocka_unit_test(test_impossible_shapes_and_counts_are_refused),
        cmocka_unit_test(test_bad_names_are_refused),
        cmocka_unit_test(test_damaged_content_with_right_checksum_never_crashes),
        cmocka_unit_test(test_find_names_what_is_missing_or_misshapen),
        cmocka_unit_test(test_pack_puts_weights_in_lanes_and_zeros_elsewhere),
        cmocka_unit_test(test_file_is_read_and_missing_file_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
