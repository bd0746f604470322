/* SPDX-License-Identifier: Apache-2.0 */
/* Images through OpenImageIO: PNG out and in, float pictures, errors without noise. */
#include "fewray/features.h"

#include <setjmp.h>
#include <stdarg.h>
/* cmocka wants the three above first */
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { WIDTH = 13, HEIGHT = 7, VALUES = WIDTH * HEIGHT * 3 };

static char folder[256], png[300], exr[300];

static int make_folder(void **state) {
    (void)state;
    const char *parent = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%.200s/fewray-test-image-XXXXXX", parent ? parent : "/tmp");
    if (!mkdtemp(folder))
        return -1;
    snprintf(png, sizeof png, "%s/picture.png", folder);
    snprintf(exr, sizeof exr, "%s/picture.exr", folder);
    return 0;
}

/* Fails where a test has left a file of another name. */
static int remove_folder(void **state) {
    (void)state;
    unlink(png);
    unlink(exr);
    return rmdir(folder);
}

static void write_test_png(uint8_t rgb[VALUES]) {
    struct fewray_error error;
    for (int i = 0; i < VALUES; i++)
        rgb[i] = (uint8_t)(i * 37);
    assert_int_equal(fewray_image_write_png(png, WIDTH, HEIGHT, rgb, &error), FEWRAY_OK);
}

static void test_png_round_trip(void **state) {
    (void)state;
    uint8_t rgb[VALUES];
    struct fewray_image *image = NULL;
    write_test_png(rgb);
    assert_int_equal(fewray_image_read(png, &image, NULL), FEWRAY_OK);
    assert_int_equal(image->width, WIDTH);
    assert_int_equal(image->height, HEIGHT);
    assert_int_equal(image->channels, 3);
    assert_null(image->floats);
    assert_memory_equal(image->bytes, rgb, sizeof rgb);
    fewray_image_destroy(&image);
    assert_null(image);
}

static void test_an_image_in_memory_is_read_as_its_file(void **state) {
    (void)state;
    uint8_t rgb[VALUES], bytes[VALUES + 4096];
    struct fewray_image *image = NULL;
    struct fewray_error error;
    write_test_png(rgb);
    FILE *file = fopen(png, "rb");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    assert_int_equal(fewray_image_read_memory("inside", bytes, size, &image, &error), FEWRAY_OK);
    assert_int_equal(image->width, WIDTH);
    assert_memory_equal(image->bytes, rgb, sizeof rgb);
    fewray_image_destroy(&image);
    for (size_t cut = 0; cut < size; cut += 7) {
        assert_true(fewray_image_read_memory("inside", bytes, cut, &image, &error) < 0);
        assert_null(image);
        assert_string_equal(error.file, "inside");
    }
}

static void test_frame_becomes_srgb(void **state) {
    (void)state;
    const float linear[8] = {0.0f, 0.001f, 0.0031308f, 0.2158605f, 0.5f, 1.0f, 7.0f, NAN};
    const uint8_t encoded[8] = {0, 3, 10, 128, 188, 255, 255, 0};
    struct fewray_frame *frame = NULL;
    struct fewray_image *image = NULL;
    struct fewray_error error;
    float *planes[3];
    assert_int_equal(fewray_frame_create(8, 1, &frame, NULL), FEWRAY_OK);
    assert_int_equal(fewray_frame_write_png(frame, png, &error), FEWRAY_ERROR_ARGUMENT);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, planes));
    for (int i = 0; i < 8; i++) {
        planes[0][i] = linear[i];
        planes[1][i] = linear[7 - i];
        planes[2][i] = -1.0f;
    }
    assert_int_equal(fewray_frame_write_png(frame, png, &error), FEWRAY_OK);
    assert_int_equal(fewray_image_read(png, &image, &error), FEWRAY_OK);
    for (int i = 0; i < 8; i++) {
        assert_int_equal(image->bytes[3 * i], encoded[i]);
        assert_int_equal(image->bytes[3 * i + 1], encoded[7 - i]);
        assert_int_equal(image->bytes[3 * i + 2], 0);
    }
    fewray_image_destroy(&image);
    fewray_frame_destroy(&frame);
}

static void test_exr_gives_floats_in_the_order_rgba(void **state) {
    (void)state;
    const char *const names[] = {"R", "G", "B", "A"};
    for (int channels = 1; channels <= 4; channels++) {
        struct fewray_frame *frame = NULL;
        struct fewray_image *image = NULL;
        struct fewray_error error;
        assert_int_equal(fewray_frame_create(3, 2, &frame, NULL), FEWRAY_OK);
        for (int c = 0; c < channels; c++)
            for (int i = 0; i < 6; i++)
                fewray_frame_add(frame, names[c])[i] = (float)(100 * c + i);
        assert_int_equal(fewray_frame_write_exr(frame, exr, true, &error), FEWRAY_OK);
        assert_int_equal(fewray_image_read(exr, &image, &error), FEWRAY_OK);
        assert_null(image->bytes);
        assert_int_equal(image->channels, channels == 2 ? 1 : channels);
        for (int i = 0; i < 6; i++)
            for (int c = 0; c < image->channels; c++)
                assert_true(image->floats[i * image->channels + c] == (float)(100 * c + i));
        fewray_image_destroy(&image);
        fewray_frame_destroy(&frame);
    }
}

static void test_exr_gives_the_colour_of_its_first_layer(void **state) {
    (void)state;
    static const struct {
        const char *names[4];
        int channels;
        float first[3]; /* numbers in names */
    } cases[] = {
        {{"a.R", "a.G", "a.B", "z"}, 3, {0, 1, 2}},
        {{"a.R", "B", "G", "R"}, 3, {3, 2, 1}},
        {{"depth.Z", "Y"}, 1, {1}},
        {{"depth.Z"}, 1, {0}},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct fewray_frame *frame = NULL;
        struct fewray_image *image = NULL;
        assert_int_equal(fewray_frame_create(1, 1, &frame, NULL), FEWRAY_OK);
        for (int c = 0; c < 4 && cases[k].names[c]; c++)
            fewray_frame_add(frame, cases[k].names[c])[0] = (float)c;
        assert_int_equal(fewray_frame_write_exr(frame, exr, true, NULL), FEWRAY_OK);
        assert_int_equal(fewray_image_read(exr, &image, NULL), FEWRAY_OK);
        assert_int_equal(image->channels, cases[k].channels);
        for (int c = 0; c < image->channels; c++)
            assert_true(image->floats[c] == cases[k].first[c]);
        fewray_image_destroy(&image);
        fewray_frame_destroy(&frame);
    }
}

static void need_refusal(const char *path) {
    struct fewray_image *image = NULL;
    struct fewray_error error;
    assert_true(fewray_image_read(path, &image, &error) < 0);
    assert_null(image);
    assert_string_equal(error.file, path);
    assert_true(error.what[0] != '\0' && !strchr(error.what, '\n'));
}

static void test_damaged_images_are_refused_without_a_word(void **state) {
    (void)state;
    uint8_t rgb[VALUES];
    write_test_png(rgb);
    struct stat info;
    assert_int_equal(stat(png, &info), 0);
    /* Both streams go to a file for the time, which has to stay empty. */
    FILE *said = tmpfile();
    assert_non_null(said);
    fflush(NULL);
    const int out = dup(1), err = dup(2);
    dup2(fileno(said), 1);
    dup2(fileno(said), 2);
    need_refusal(folder);
    need_refusal("nowhere.png");
    need_refusal("");
    for (off_t cut = info.st_size - 20; cut >= 0; cut = cut > 9 ? cut - 9 : cut - 1) {
        assert_int_equal(truncate(png, cut), 0);
        need_refusal(png);
    }
    fflush(NULL);
    dup2(out, 1);
    dup2(err, 2);
    close(out);
    close(err);
    assert_int_equal(fstat(fileno(said), &info), 0);
    fclose(said);
    assert_int_equal(info.st_size, 0);
}

static void test_png_into_a_missing_folder_is_refused(void **state) {
    (void)state;
    const uint8_t rgb[3] = {1, 2, 3};
    struct fewray_error error;
    char path[400];
    snprintf(path, sizeof path, "%s/missing/out.png", folder);
    assert_int_equal(fewray_image_write_png(path, 1, 1, rgb, &error), FEWRAY_ERROR_IO);
    assert_string_equal(error.file, path);
    assert_int_equal(fewray_image_write_png(png, 0, 1, rgb, &error), FEWRAY_ERROR_ARGUMENT);
}

static void test_images_are_read_in_parallel(void **state) {
    (void)state;
    uint8_t rgb[VALUES];
    write_test_png(rgb);
    int good = 0;
#pragma omp parallel for num_threads(4) reduction(+ : good)
    for (int i = 0; i < 64; i++) {
        struct fewray_image *image = NULL;
        if (fewray_image_read(png, &image, NULL) == FEWRAY_OK)
            good += memcmp(image->bytes, rgb, sizeof rgb) == 0;
        fewray_image_destroy(&image);
    }
    assert_int_equal(good, 64);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_png_round_trip),
        cmocka_unit_test(test_an_image_in_memory_is_read_as_its_file),
        cmocka_unit_test(test_frame_becomes_srgb),
        cmocka_unit_test(test_exr_gives_floats_in_the_order_rgba),
        cmocka_unit_test(test_exr_gives_the_colour_of_its_first_layer),
        cmocka_unit_test(test_damaged_images_are_refused_without_a_word),
        cmocka_unit_test(test_png_into_a_missing_folder_is_refused),
        cmocka_unit_test(test_images_are_read_in_parallel),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
