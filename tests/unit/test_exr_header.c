/* SPDX-License-Identifier: Apache-2.0 */
/* Texts in the header of EXR files, and planes that are taken out again. */

#include "tests/unit/check.h"

#include <string.h>
#include <unistd.h>

#include "fewray/features.h"

static char file[] = "header-XXXXXX";

static void test_texts_come_back_from_a_file(void **state) {
    (void)state;
    struct fewray_frame *frame = NULL, *read = NULL;
    char longest[2000];
    memset(longest, 'x', sizeof longest);
    longest[sizeof longest - 1] = 0;
    assert_int_equal(fewray_frame_create(5, 3, &frame, NULL), FEWRAY_OK);
    assert_non_null(fewray_frame_add(frame, "R"));
    assert_true(fewray_frame_set_attribute(frame, "fewray.part", "1/2"));
    assert_true(fewray_frame_set_attribute(frame, "fewray.part", "2/2"));
    assert_true(fewray_frame_set_attribute(frame, "fewray.empty", ""));
    assert_true(fewray_frame_set_attribute(frame, "fewray.settings", longest));
    assert_false(fewray_frame_set_attribute(frame, "", "nameless"));
    assert_int_equal(fewray_frame_write_exr(frame, file, false, NULL), FEWRAY_OK);
    assert_int_equal(fewray_frame_read_exr(file, &read, NULL), FEWRAY_OK);
    assert_string_equal(fewray_frame_attribute(read, "fewray.part"), "2/2");
    assert_string_equal(fewray_frame_attribute(read, "fewray.empty"), "");
    assert_string_equal(fewray_frame_attribute(read, "fewray.settings"), longest);
    assert_null(fewray_frame_attribute(read, "software"));
    fewray_frame_destroy(&read);
    fewray_frame_destroy(&frame);
}

static void test_a_header_is_read_without_pixels(void **state) {
    (void)state;
    struct fewray_frame *header = NULL;
    assert_int_equal(fewray_frame_read_exr_header(file, &header, NULL), FEWRAY_OK);
    assert_int_equal(header->width, 5);
    assert_int_equal(header->height, 3);
    assert_int_equal(header->plane_count, 0);
    assert_string_equal(fewray_frame_attribute(header, "fewray.part"), "2/2");
    fewray_frame_destroy(&header);
    struct fewray_error error;
    assert_int_equal(fewray_frame_read_exr_header("nowhere.exr", &header, &error), FEWRAY_ERROR_IO);
    assert_null(header);
}

static void test_a_removed_plane_leaves_the_others(void **state) {
    (void)state;
    struct fewray_frame *frame = NULL;
    assert_int_equal(fewray_frame_create(5, 3, &frame, NULL), FEWRAY_OK);
    fewray_frame_add(frame, "R")[0] = 1;
    fewray_frame_add(frame, "G")[0] = 2;
    fewray_frame_add(frame, "B")[0] = 3;
    fewray_frame_remove(frame, "G");
    fewray_frame_remove(frame, "G");
    assert_int_equal(frame->plane_count, 2);
    assert_null(fewray_frame_plane(frame, "G"));
    assert_true(fewray_frame_plane(frame, "R")[0] == 1 && fewray_frame_plane(frame, "B")[0] == 3);
    fewray_frame_destroy(&frame);
}

static int make_file(void **state) {
    (void)state;
    const int descriptor = mkstemp(file);
    return descriptor < 0 ? -1 : close(descriptor);
}

static int remove_file(void **state) {
    (void)state;
    return unlink(file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_texts_come_back_from_a_file),
        cmocka_unit_test(test_a_header_is_read_without_pixels),
        cmocka_unit_test(test_a_removed_plane_leaves_the_others),
    };
    return cmocka_run_group_tests(tests, make_file, remove_file);
}
