/* SPDX-License-Identifier: Apache-2.0 */
/* EXR's ZIP blocks against zlib and the format's own words, and what is damaged. */
#include "features/zip.h"

#include <setjmp.h>
#include <stdarg.h>
/* cmocka wants the three above first */
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { LONGEST = 4096 };

/* Compressible, but for its noise. */
static void fill(uint8_t *bytes, size_t size, uint32_t seed) {
    for (size_t i = 0; i < size; i++) {
        seed = seed * 1664525u + 1013904223u;
        bytes[i] = (uint8_t)(i % 2 ? seed >> 29 : i / 16);
    }
}

/* The format as it is described, byte by byte. */
static void filter_plainly(const uint8_t *raw, size_t size, uint8_t *filtered) {
    size_t n = 0;
    for (size_t i = 0; i < size; i += 2)
        filtered[n++] = raw[i];
    for (size_t i = 1; i < size; i += 2)
        filtered[n++] = raw[i];
    for (size_t i = size - 1; i > 0; i--)
        filtered[i] = (uint8_t)(filtered[i] - filtered[i - 1] + 128);
}

static void test_zlib_reads_what_is_packed(void **state) {
    (void)state;
    struct zip_worker worker = {0};
    for (size_t size = 1; size <= LONGEST; size += size < 70 ? 1 : 671) {
        uint8_t raw[LONGEST], filtered[LONGEST], unpacked[LONGEST];
        const uint8_t *packed;
        size_t packed_size;
        fill(raw, size, (uint32_t)size);
        filter_plainly(raw, size, filtered);
        assert_true(zip_pack(&worker, raw, size, &packed, &packed_size));
        if (packed_size == size) {
            assert_ptr_equal(packed, raw);
            continue;
        }
        assert_true(packed_size < size);
        uLongf length = sizeof unpacked;
        assert_int_equal(uncompress(unpacked, &length, packed, packed_size), Z_OK);
        assert_int_equal(length, size);
        assert_memory_equal(unpacked, filtered, size);
    }
    zip_worker_clear(&worker);
}

static void test_what_zlib_packed_is_read(void **state) {
    (void)state;
    struct zip_worker worker = {0};
    for (size_t size = 1; size <= LONGEST; size += size < 70 ? 1 : 671) {
        uint8_t raw[LONGEST], filtered[LONGEST], packed[2 * LONGEST], back[LONGEST];
        fill(raw, size, (uint32_t)size);
        filter_plainly(raw, size, filtered);
        uLongf length = sizeof packed;
        assert_int_equal(compress2(packed, &length, filtered, size, 9), Z_OK);
        assert_int_equal(zip_unpack(&worker, packed, length, back, size), ZIP_OK);
        assert_memory_equal(back, raw, size);
    }
    zip_worker_clear(&worker);
}

static void test_noise_stays_raw(void **state) {
    (void)state;
    struct zip_worker worker = {0};
    uint8_t raw[LONGEST];
    uint64_t random = 1;
    const uint8_t *packed;
    size_t packed_size;
    for (size_t i = 0; i < sizeof raw; i++) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        raw[i] = (uint8_t)(random >> 56);
    }
    assert_true(zip_pack(&worker, raw, sizeof raw, &packed, &packed_size));
    assert_ptr_equal(packed, raw);
    assert_int_equal(packed_size, sizeof raw);
    zip_worker_clear(&worker);
}

static void test_damaged_blocks_are_refused(void **state) {
    (void)state;
    struct zip_worker worker = {0};
    uint8_t raw[LONGEST], copy[LONGEST], back[LONGEST + 1];
    const uint8_t *packed;
    size_t packed_size;
    fill(raw, sizeof raw, 1);
    assert_true(zip_pack(&worker, raw, sizeof raw, &packed, &packed_size));
    memcpy(copy, packed, packed_size);
    assert_int_equal(zip_unpack(&worker, copy, packed_size, back, sizeof raw), ZIP_OK);
    for (size_t length = 0; length < packed_size; length += 7)
        assert_int_equal(zip_unpack(&worker, copy, length, back, sizeof raw), ZIP_DAMAGED);
    assert_int_equal(zip_unpack(&worker, copy, packed_size, back, sizeof raw - 1), ZIP_DAMAGED);
    assert_int_equal(zip_unpack(&worker, copy, packed_size, back, sizeof raw + 1), ZIP_DAMAGED);
    copy[packed_size / 2] ^= 0x10; /* the stream has a checksum */
    assert_int_equal(zip_unpack(&worker, copy, packed_size, back, sizeof raw), ZIP_DAMAGED);
    zip_worker_clear(&worker);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_zlib_reads_what_is_packed),
        cmocka_unit_test(test_what_zlib_packed_is_read),
        cmocka_unit_test(test_noise_stays_raw),
        cmocka_unit_test(test_damaged_blocks_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
