/* SPDX-License-Identifier: Apache-2.0 */
/* Decimal numbers: as strtof() reads them, to a unit in the last place. */

#include "guide/scene/number.h"
#include "scene_scratch.h"

static void test_numbers_equal_strtof(void **state) {
    static const char *const texts[] = {"0",           "-0.0",
                                        "1",           "3.14159265",
                                        "1e-3",        ".5",
                                        "5.",          "+2.5E+2",
                                        "1.17549e-38", "3.4e38",
                                        "0.000000001", "123456789012345678901234567890",
                                        "1e-50",       "9.999999999999999999999e22"};
    (void)state;
    for (size_t i = 0; i < sizeof(texts) / sizeof(*texts); i++) {
        const char *cursor = texts[i];
        double value = -1;
        assert_true(number_read(&cursor, &value));
        assert_int_equal(*cursor, 0);
        float expected = strtof(texts[i], NULL);
        assert_near((float)value, expected, fabs(expected) * 1.2e-7);
    }
}

static void test_random_floats_survive_printing(void **state) {
    uint64_t seed = 1;
    (void)state;
    for (int i = 0; i < 20000; i++) {
        char text[64];
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        uint32_t bits = (uint32_t)(seed >> 32);
        float value;
        memcpy(&value, &bits, sizeof(value));
        if (!isfinite(value) || fabsf(value) < 1e-37f)
            continue;
        snprintf(text, sizeof(text), i % 2 ? "%.9g" : "%.20e", value);
        const char *cursor = text;
        double read = 0;
        assert_true(number_read(&cursor, &read));
        assert_near((float)read, value, fabsf(value) * 1.2e-7);
    }
}

static void test_malformed_numbers_are_refused(void **state) {
    static const char *const texts[] = {"", "-", ".", "e5", "nan", "inf", "abc", "+-1"};
    (void)state;
    for (size_t i = 0; i < sizeof(texts) / sizeof(*texts); i++) {
        const char *cursor = texts[i];
        double value;
        assert_false(number_read(&cursor, &value));
        assert_ptr_equal(cursor, texts[i]);
    }
}

static void test_lists_take_commas_and_blanks(void **state) {
    double v[4];
    (void)state;
    assert_int_equal(number_read_list(" 1, 2\t3,4 ", v, 4), 4);
    assert_near(v[3], 4, 0);
    assert_int_equal(number_read_list("", v, 4), 0);
    assert_int_equal(number_read_list("1 2 3 4 5", v, 4), -1);
    assert_int_equal(number_read_list("1 x", v, 4), -1);
    assert_int_equal(number_read_list("1e999", v, 4), -1);
    assert_int_equal(number_read_list("1.5mm", v, 4), -1);
}

static void test_integers_are_bounded(void **state) {
    const char *huge = "99999999999999999999", *small = "-17x";
    int64_t value = 0;
    (void)state;
    assert_false(number_read_integer(&huge, &value));
    assert_true(number_read_integer(&small, &value));
    assert_int_equal(value, -17);
    assert_int_equal(*small, 'x');
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers_equal_strtof),
        cmocka_unit_test(test_random_floats_survive_printing),
        cmocka_unit_test(test_malformed_numbers_are_refused),
        cmocka_unit_test(test_lists_take_commas_and_blanks),
        cmocka_unit_test(test_integers_are_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
