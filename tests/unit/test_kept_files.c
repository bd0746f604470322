/* SPDX-License-Identifier: Apache-2.0 */
/* A file of which some channels change is otherwise what it was: bits, types, windows, tiles,
 * compression, parts, attributes. */

#include "tests/unit/check.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fewray/features.h"
#include "foreign_file.h"
#include "tests/unit/scratch_folder.h"

enum { WIDTH = 37, HEIGHT = 21, COUNT = WIDTH * HEIGHT };

#define RGB "R:half,G:half,B:half"
#define WHOLE                                                                                      \
    { 0, 0, WIDTH, HEIGHT }
#define MIXED RGB ",A:half,Z:float,id:uint,albedo.R:half,albedo.G:half,albedo.B:half"
#define TWO_EYES                                                                                   \
    {                                                                                              \
        {"left", RGB ",Z:float", WHOLE}, {                                                         \
            "right", RGB ",Z:float", WHOLE                                                         \
        }                                                                                          \
    }

static const struct foreign_make FILES[] = {
    {"ZIP", "zip", NULL, 0, WHOLE, {{NULL, MIXED, WHOLE}}},
    {"ZIPS", "zips", NULL, 0, WHOLE, {{NULL, MIXED, WHOLE}}},
    {"PIZ", "piz", NULL, 0, WHOLE, {{NULL, MIXED, WHOLE}}},
    {"PXR24", "pxr24", NULL, 0, WHOLE, {{NULL, MIXED, WHOLE}}},
    {"RLE", "rle", NULL, 0, WHOLE, {{NULL, MIXED, WHOLE}}},
    {"no compression", "none", NULL, 0, WHOLE, {{NULL, MIXED, WHOLE}}},
    {"floats", "zip", NULL, 0, WHOLE, {{NULL, "R:float,G:float,B:float,N.X:float", WHOLE}}},
    {"lines from below", "zip", "decreasingY", 0, WHOLE, {{NULL, MIXED, WHOLE}}},
    {"tiles", "zip", NULL, 16, WHOLE, {{NULL, MIXED, WHOLE}}},
    {"tiles by PIZ", "piz", NULL, 16, WHOLE, {{NULL, MIXED, WHOLE}}},
    {"a cut of the picture",
     "zip",
     NULL,
     0,
     {0, 0, 64, 48},
     {{NULL, MIXED, {9, 5, WIDTH, HEIGHT}}}},
    {"overscan", "piz", NULL, 0, {0, 0, 20, 10}, {{NULL, MIXED, {-8, -5, WIDTH, HEIGHT}}}},
    {"a cut in tiles", "zips", NULL, 16, {0, 0, 64, 48}, {{NULL, MIXED, {9, 5, WIDTH, HEIGHT}}}},
    {"a part for each layer",
     "zip",
     NULL,
     0,
     WHOLE,
     {{"ViewLayer.Combined", "R:half,G:half,B:half,A:half", WHOLE},
      {"ViewLayer.Depth", "Z:float", WHOLE},
      {"ViewLayer.CryptoObject00", "r:float,g:float,b:float,a:float", WHOLE}}},
    {"two eyes", "zip", NULL, 0, WHOLE, TWO_EYES},
    {"a part of another window",
     "zip",
     NULL,
     0,
     WHOLE,
     {{"beauty", RGB, WHOLE}, {"mask", "Y:half", {3, 4, 8, 8}}}},
    {"parts in tiles and from below",
     "zip",
     NULL,
     16,
     WHOLE,
     {{"beauty", RGB, WHOLE}, {"id", "id:uint", WHOLE}}},
};
enum { FILE_COUNT = (int)(sizeof FILES / sizeof *FILES) };

static char in[96], out[96];

/* The planes that a file's R, G, B become. */
static const char *colour_name(const struct fewray_frame *frame, int c) {
    for (size_t i = 0; i < frame->plane_count; i++) {
        const char *name = frame->planes[i].name, *dot = strrchr(name, '.');
        if ((dot ? dot[1] : name[0]) == "RGB"[c] && !strstr(name, "albedo"))
            return name;
    }
    return NULL;
}

/* Gives the first R, G, B the value 0.5 and adds a layer. */
static int change(const struct fewray_frame *frame, bool float32, const char *to,
                  struct fewray_error *error) {
    static float half[COUNT], quarter[COUNT];
    struct fewray_exr_change changes[4];
    for (int i = 0; i < COUNT; i++) {
        half[i] = 0.5f;
        quarter[i] = 0.25f;
    }
    for (int c = 0; c < 3; c++)
        changes[c] = (struct fewray_exr_change){colour_name(frame, c), half};
    changes[3] = (struct fewray_exr_change){"noisy.R", quarter};
    return fewray_exr_rewrite(in, changes, 4, float32, to, error);
}

static void check_changes(const char *what, const struct fewray_frame *before) {
    struct fewray_frame *after = NULL;
    assert_int_equal(fewray_frame_read_exr(out, &after, NULL), FEWRAY_OK);
    assert_int_equal(after->plane_count, before->plane_count + 1);
    for (int c = 0; c < 3; c++) {
        const float *data = fewray_frame_plane(after, colour_name(before, c));
        const float *noisy = fewray_frame_plane(after, "noisy.R");
        assert_non_null(data);
        assert_non_null(noisy);
        for (int i = 0; i < COUNT; i++)
            if (data[i] != 0.5f || noisy[i] != 0.25f)
                fail_msg("%s: channel %d, pixel %d is %g", what, c, i, (double)data[i]);
    }
    fewray_frame_destroy(&after);
}

static void test_all_but_the_changes_is_kept(void **state) {
    (void)state;
    for (int k = 0; k < FILE_COUNT; k++) {
        struct fewray_frame *frame = NULL;
        struct fewray_error error = {.what = ""};
        char why[256];
        assert_true(foreign_write(in, &FILES[k]));
        assert_int_equal(fewray_frame_read_exr(in, &frame, NULL), FEWRAY_OK);
        if (change(frame, false, out, &error))
            fail_msg("%s: %s", FILES[k].what, error.what);
        check_changes(FILES[k].what, frame);
        if (!foreign_is_kept(in, out, "R,G,B", why, sizeof why))
            fail_msg("%s: %s", FILES[k].what, why);
        fewray_frame_destroy(&frame);
    }
}

static void test_a_file_may_replace_itself(void **state) {
    (void)state;
    struct fewray_frame *frame = NULL;
    char why[256];
    assert_true(foreign_write(in, &FILES[0]));
    assert_true(foreign_write(out, &FILES[0]));
    assert_int_equal(fewray_frame_read_exr(in, &frame, NULL), FEWRAY_OK);
    assert_int_equal(change(frame, false, in, NULL), FEWRAY_OK);
    assert_true(foreign_is_kept(out, in, "R,G,B", why, sizeof why));
    fewray_frame_destroy(&frame);
}

static void test_the_changes_may_be_floats(void **state) {
    (void)state;
    struct fewray_frame *frame = NULL;
    struct fewray_exr_header *header = NULL;
    assert_true(foreign_write(in, &FILES[0]));
    assert_int_equal(fewray_frame_read_exr(in, &frame, NULL), FEWRAY_OK);
    assert_int_equal(change(frame, true, out, NULL), FEWRAY_OK);
    assert_int_equal(fewray_exr_header_read(out, &header, NULL), FEWRAY_OK);
    for (int c = 0; c < header->parts[0].channel_count; c++) {
        const struct fewray_exr_channel *channel = &header->parts[0].channels[c];
        const bool changed = (strchr("RGB", channel->name[0]) && !channel->name[1]) ||
                             !strcmp(channel->name, "noisy.R");
        const char *kept = !strcmp(channel->name, "id") ? "uint"
                           : channel->name[0] == 'Z'    ? "float"
                                                        : "half";
        assert_string_equal(channel->type, changed ? "float" : kept);
    }
    fewray_exr_header_destroy(&header);
    fewray_frame_destroy(&frame);
}

static void test_a_damaged_source_leaves_no_file(void **state) {
    (void)state;
    struct fewray_frame *frame = NULL;
    struct fewray_error error;
    assert_true(foreign_write(in, &FILES[0]));
    assert_int_equal(fewray_frame_read_exr(in, &frame, NULL), FEWRAY_OK);
    remove(out);
    assert_int_equal(truncate(in, 6000), 0);
    assert_true(change(frame, false, out, &error) < 0);
    assert_string_equal(error.file, in);
    assert_null(fopen(out, "rb"));
    fewray_frame_destroy(&frame);
}

static void test_a_deep_part_is_refused(void **state) {
    (void)state;
    static const float pixels[COUNT];
    const struct fewray_exr_change change_of_alpha = {"A", pixels};
    struct fewray_exr_header *header = NULL;
    struct fewray_error error;
    assert_true(foreign_write_deep(in, WIDTH, HEIGHT));
    remove(out);
    assert_int_equal(fewray_exr_rewrite(in, &change_of_alpha, 1, false, out, &error),
                     FEWRAY_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.what, "part 0 is deep"));
    assert_null(fopen(out, "rb"));
    assert_int_equal(fewray_exr_header_read(in, &header, NULL), FEWRAY_OK);
    assert_true(header->parts[0].deep);
    fewray_exr_header_destroy(&header);
}

static void test_a_header_is_told(void **state) {
    (void)state;
    struct fewray_exr_header *header = NULL;
    assert_true(foreign_write(in, &FILES[10]));
    assert_int_equal(fewray_exr_header_read(in, &header, NULL), FEWRAY_OK);
    const struct fewray_exr_part *part = &header->parts[0];
    assert_int_equal(header->part_count, 1);
    assert_string_equal(part->compression, "ZIP");
    assert_int_equal(part->data_window[0], 9);
    assert_int_equal(part->data_window[3], 5 + HEIGHT - 1);
    assert_int_equal(part->display_window[2], 63);
    int told = 0;
    for (int a = 0; a < part->attribute_count; a++) {
        static const char *const wanted[][2] = {
            {"comments", "what the artist wrote"},
            {"exposure", "1.25"},
            {"samples", "64"},
            {"eye", "1.5 -2 3"},
            {"timeCode", "01:23:45:16"},
            {"worldToCamera", "1 0 0 0 0 0.5 0.25 0 0 -1 1 0 3 4 5 1"},
        };
        for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++)
            if (!strcmp(part->attributes[a].name, wanted[k][0])) {
                assert_string_equal(part->attributes[a].text, wanted[k][1]);
                told++;
            }
    }
    assert_int_equal(told, 6);
    fewray_exr_header_destroy(&header);
    assert_true(fewray_exr_header_read("nowhere.exr", &header, NULL) < 0);
}

static int start(void **state) {
    const int status = make_folder(state);
    snprintf(in, sizeof in, "%s/in.exr", folder);
    snprintf(out, sizeof out, "%s/out.exr", folder);
    return status;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_but_the_changes_is_kept),
        cmocka_unit_test(test_a_file_may_replace_itself),
        cmocka_unit_test(test_the_changes_may_be_floats),
        cmocka_unit_test(test_a_damaged_source_leaves_no_file),
        cmocka_unit_test(test_a_deep_part_is_refused),
        cmocka_unit_test(test_a_header_is_told),
    };
    return cmocka_run_group_tests(tests, start, remove_folder);
}
