/* SPDX-License-Identifier: Apache-2.0 */
/* Weights files with damage of every kind in every region: each is refused by its loader, with one
 * line that names the file, and nothing is left behind. */

#include "weights_stage.h"

/* Flips a bit at a place, with the old checksum and, where signed_status isn't FEWRAY_OK, also with
 * a right one. */
static void refuse_flip(int network, struct file *f, size_t at, int signed_status) {
    const uint32_t crc = integer_at(f, CRC_AT);
    const bool version = at >= VERSION_AT && at < CRC_AT;
    f->bytes[at] ^= 1;
    refuse(network, f, version ? FEWRAY_ERROR_UNSUPPORTED : FEWRAY_ERROR_FORMAT, "a flipped bit",
           at);
    if (signed_status) {
        sign(f);
        refuse(network, f, signed_status, "a flipped bit with a right checksum", at);
        put_integer(f, CRC_AT, crc);
    }
    f->bytes[at] ^= 1;
}

static void for_each_network(void (*check)(int network, struct file *f)) {
    for (int n = 0; n < NETWORKS; n++) {
        struct file f = file_of(n);
        check(n, &f);
        free(f.bytes);
    }
}

/* First, middle and last tensor. */
static uint32_t tensor_number(const struct file *f, int which) {
    const uint32_t tensors = integer_at(f, count_at(f));
    return which == 0 ? 0 : which == 1 ? tensors / 2 : tensors - 1;
}

static void check_whole(int network, struct file *f) {
    char path[64];
    struct fewray_error error = {0};
    path_of(path, sizeof path);
    store(f);
    if (networks[network].load(path, &error))
        fail_msg("%s: %s", networks[network].name, error.what);
}

static void test_undamaged_files_are_taken(void **state) {
    (void)state;
    for_each_network(check_whole);
}

static void check_flips(int network, struct file *f) {
    for (size_t at = 0; at < INFO_AT; at++)
        refuse_flip(network, f, at, at >= CONTENT_AT ? FEWRAY_ERROR_FORMAT : FEWRAY_OK);
    refuse_flip(network, f, INFO_AT + 5, FEWRAY_OK); /* text: the checksum is all there is */
    for (size_t i = 0; i < 4; i++)
        refuse_flip(network, f, count_at(f) + i, FEWRAY_ERROR_FORMAT);
    for (int which = 0; which < 3; which++) {
        size_t values;
        const size_t at = tensor_at(f, tensor_number(f, which), &values);
        static const size_t in_name[] = {0, 3, NAME_BYTES - 1};
        for (int i = 0; i < 3; i++)
            refuse_flip(network, f, at + in_name[i], FEWRAY_ERROR_FORMAT);
        for (size_t i = NAME_BYTES; i < HEAD_BYTES; i++)
            refuse_flip(network, f, at + i, FEWRAY_ERROR_FORMAT);
        refuse_flip(network, f, at + HEAD_BYTES, FEWRAY_OK); /* another finite weight */
        refuse_flip(network, f, at + HEAD_BYTES + 2 * values - 1, FEWRAY_OK);
    }
}

static void test_a_flipped_bit_in_any_region_is_refused(void **state) {
    (void)state;
    for_each_network(check_flips);
}

static void refuse_cut(int network, struct file *f, size_t size) {
    const size_t whole = f->size;
    const uint32_t crc = integer_at(f, CRC_AT);
    f->size = size;
    refuse(network, f, FEWRAY_ERROR_FORMAT, "a cut", size);
    sign(f);
    refuse(network, f, FEWRAY_ERROR_FORMAT, "a cut with a right checksum", size);
    f->size = whole;
    put_integer(f, CRC_AT, crc);
}

static void check_cuts(int network, struct file *f) {
    static const size_t header[] = {0, 1, 8, 12, 15, 16, 17, 20, 30};
    for (size_t i = 0; i < sizeof header / sizeof *header; i++)
        refuse_cut(network, f, header[i]);
    refuse_cut(network, f, count_at(f));
    refuse_cut(network, f, count_at(f) + 3);
    for (int which = 0; which < 3; which++) {
        size_t values;
        const size_t at = tensor_at(f, tensor_number(f, which), &values);
        const size_t cuts[] = {at,
                               at + 1,
                               at + NAME_BYTES,
                               at + HEAD_BYTES - 1,
                               at + HEAD_BYTES,
                               at + HEAD_BYTES + 1,
                               at + HEAD_BYTES + 2 * values - 1};
        for (size_t i = 0; i < sizeof cuts / sizeof *cuts; i++)
            refuse_cut(network, f, cuts[i]);
    }
}

static void test_files_cut_anywhere_are_refused(void **state) {
    (void)state;
    for_each_network(check_cuts);
}

static void check_trailing(int network, struct file *f) {
    static const size_t more[] = {1, 2, 4, TRAILING};
    const size_t whole = f->size;
    for (int i = 0; i < 4; i++) {
        f->size = whole + more[i];
        refuse(network, f, FEWRAY_ERROR_FORMAT, "trailing bytes", more[i]);
        sign(f);
        refuse(network, f, FEWRAY_ERROR_FORMAT, "trailing bytes with a right checksum", more[i]);
    }
}

static void test_trailing_bytes_are_refused(void **state) {
    (void)state;
    for_each_network(check_trailing);
}

/* With a right checksum: sizes whose products overflow 32 or 64 bits, or fit no file. */
static void check_sizes(int network, struct file *f) {
    static const uint32_t sizes[] = {0,       0xffff,     0x10000,    0x7fffffff,
                                     1 << 30, 0x80000000, 0xffffffff, 0x40000001};
    enum { SIZES = sizeof sizes / sizeof *sizes };
    size_t values;
    const size_t at = tensor_at(f, tensor_number(f, 1), &values) + NAME_BYTES;
    for (int s = 0; s < SIZES; s++) {
        static const int places_of[] = {1, 2, 4, 8, 3, 12, 15}; /* which of the four dimensions */
        for (size_t p = 0; p < sizeof places_of / sizeof *places_of; p++) {
            const size_t places = (size_t)places_of[p];
            uint8_t kept[16];
            memcpy(kept, f->bytes + at, sizeof kept);
            for (size_t d = 0; d < 4; d++)
                if (places >> d & 1)
                    put_integer(f, at + 4 * d, sizes[s]);
            sign(f);
            refuse(network, f, FEWRAY_ERROR_FORMAT, "an impossible shape", places);
            memcpy(f->bytes + at, kept, sizeof kept);
        }
        const size_t lengths[] = {CONTENT_AT, count_at(f)};
        for (int i = 0; i < 2; i++) {
            const uint32_t kept = integer_at(f, lengths[i]);
            put_integer(f, lengths[i], sizes[s]);
            sign(f);
            refuse(network, f, FEWRAY_ERROR_FORMAT, "an impossible length", lengths[i]);
            put_integer(f, lengths[i], kept);
        }
    }
}

static void test_impossible_sizes_are_refused(void **state) {
    (void)state;
    for_each_network(check_sizes);
}

static void check_values(int network, struct file *f) {
    static const uint16_t halfs[] = {0x7c00, 0xfc00, 0x7c01, 0x7e00, 0xffff}; /* Inf, NaN */
    for (int which = 0; which < 3; which++) {
        size_t values;
        const size_t at = tensor_at(f, tensor_number(f, which), &values) + HEAD_BYTES;
        const size_t places[] = {0, values / 2, values - 1};
        for (int p = 0; p < 3; p++)
            for (size_t h = 0; h < sizeof halfs / sizeof *halfs; h++) {
                uint8_t *value = f->bytes + at + 2 * places[p], kept[2] = {value[0], value[1]};
                value[0] = (uint8_t)halfs[h];
                value[1] = (uint8_t)(halfs[h] >> 8);
                sign(f);
                refuse(network, f, FEWRAY_ERROR_FORMAT, "a weight that isn't finite", places[p]);
                memcpy(value, kept, sizeof kept);
            }
    }
}

static void test_weights_that_are_not_finite_are_refused(void **state) {
    (void)state;
    for_each_network(check_values);
}

/* A guide's info decides how its output is read. */
static void test_a_guide_whose_info_is_no_json_is_refused(void **state) {
    (void)state;
    for (int n = 2; n < NETWORKS; n++) {
        struct file f = file_of(n);
        f.bytes[INFO_AT] = '[';
        sign(&f);
        refuse(n, &f, FEWRAY_ERROR_FORMAT, "broken info", INFO_AT);
        free(f.bytes);
    }
}

static void test_another_networks_file_is_refused(void **state) {
    (void)state;
    for (int n = 0; n < NETWORKS; n++) {
        struct file other = file_of((n + 2) % NETWORKS);
        refuse(n, &other, FEWRAY_ERROR_FORMAT, "the other network's file", 0);
        free(other.bytes);
    }
}

static void test_what_is_no_file_is_refused(void **state) {
    (void)state;
    static const struct {
        const char *path;
        int status;
    } cases[] = {
        {"no/such/file", FEWRAY_ERROR_IO},
        {".", FEWRAY_ERROR_IO},
        {"/dev/null", FEWRAY_ERROR_FORMAT},
        {"/dev/zero", FEWRAY_ERROR_FORMAT}, /* endless */
    };
    for (int n = 0; n < NETWORKS; n++)
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
            struct fewray_error error = {0};
            assert_int_equal(networks[n].load(cases[i].path, &error), cases[i].status);
            assert_string_equal(error.file, cases[i].path);
            assert_true(error.what[0]);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_undamaged_files_are_taken),
        cmocka_unit_test(test_a_flipped_bit_in_any_region_is_refused),
        cmocka_unit_test(test_files_cut_anywhere_are_refused),
        cmocka_unit_test(test_trailing_bytes_are_refused),
        cmocka_unit_test(test_impossible_sizes_are_refused),
        cmocka_unit_test(test_weights_that_are_not_finite_are_refused),
        cmocka_unit_test(test_a_guide_whose_info_is_no_json_is_refused),
        cmocka_unit_test(test_another_networks_file_is_refused),
        cmocka_unit_test(test_what_is_no_file_is_refused),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
