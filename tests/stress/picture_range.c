/* SPDX-License-Identifier: Apache-2.0 */
/* `fewray denoise` on files of any radiance: 32-bit files keep it, with --float or without. */

#include <jansson.h>
#include <string.h>

#include "fewray/features.h"
#include "tests/unit/scratch_folder.h"

enum { WIDTH = 40, HEIGHT = 24, PIXELS = WIDTH * HEIGHT };

static void path_of(char path[64], const char *name) {
    snprintf(path, 64, "%s/%s", folder, name);
}

/* A noisy picture of two levels with its variance, times a scale, as 32-bit floats. */
static void write_noisy(float scale) {
    struct fewray_frame *frame = NULL;
    float *color[3], *variance[3];
    char path[64];
    uint32_t seed = 3;
    path_of(path, "in.exr");
    assert_int_equal(fewray_frame_create(WIDTH, HEIGHT, &frame, NULL), FEWRAY_OK);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, color));
    assert_true(fewray_frame_add_layer(frame, FEWRAY_VARIANCE, variance));
    for (int i = 0; i < PIXELS; i++)
        for (int c = 0; c < 3; c++) {
            seed = seed * 1664525u + 1013904223u;
            const float level = i % WIDTH < 20 ? 1 : 4, noise = (float)(seed >> 8) * 0x1p-24f;
            color[c][i] = scale * level * (0.5f + noise);
            variance[c][i] = scale * scale * level * level / 12;
        }
    assert_int_equal(fewray_frame_write_exr(frame, path, true, NULL), FEWRAY_OK);
    fewray_frame_destroy(&frame);
}

/* Denoises in.exr to out.exr; returns a pixel count of the statistics, and what was said. */
static long long denoise(const char *option, const char *counted, char said[512]) {
    char line[1024], path[64];
    snprintf(line, sizeof line,
             "cd %s && %s denoise in.exr -o out.exr --stats stats.json --threads 1 %s 2> err.txt",
             folder, FEWRAY_COMMAND, option);
    assert_int_equal(system(line), 0);
    path_of(path, "err.txt");
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    said[fread(said, 1, 511, file)] = 0;
    fclose(file);
    path_of(path, "stats.json");
    json_t *stats = json_load_file(path, 0, NULL);
    assert_int_equal(json_integer_value(json_object_get(stats, "repaired")), 0);
    assert_true(json_is_integer(json_object_get(stats, counted)));
    const long long count = json_integer_value(json_object_get(stats, counted));
    json_decref(stats);
    return count;
}

static struct fewray_frame *read_result(void) {
    struct fewray_frame *frame = NULL;
    char path[64];
    path_of(path, "out.exr");
    assert_int_equal(fewray_frame_read_exr(path, &frame, NULL), FEWRAY_OK);
    return frame;
}

/* The exposure is found again but for the rounding of its logarithm. */
#define SCALE_ERROR 1e-3

static void test_files_of_32_bits_keep_any_radiance(void **state) {
    (void)state;
    static const float scales[] = {0x1p-40f, 0x1p-10f, 0x1p18f, 0x1p36f}; /* 1e-12 to 4e11 */
    char said[512];
    write_noisy(1);
    assert_int_equal(denoise("--float", "clipped", said), 0);
    struct fewray_frame *one = read_result();
    for (int s = 0; s < 4; s++) {
        write_noisy(scales[s]);
        assert_int_equal(denoise("--float", "clipped", said), 0);
        assert_string_equal(said, "");
        struct fewray_frame *scaled = read_result();
        const float *a = fewray_frame_plane(one, "R"), *b = fewray_frame_plane(scaled, "R");
        for (int i = 0; i < PIXELS; i++)
            assert_near(b[i] / scales[s], a[i], SCALE_ERROR * a[i]);
        fewray_frame_destroy(&scaled);
    }
    fewray_frame_destroy(&one);
}

static void test_a_file_of_32_bits_stays_one(void **state) {
    (void)state;
    static const float scales[] = {1, 0x1p30f, 0x1p-40f}; /* half floats hold the first alone */
    for (int s = 0; s < 3; s++) {
        char said[512];
        write_noisy(scales[s]);
        assert_int_equal(denoise("--float", "clipped", said), 0);
        struct fewray_frame *wanted = read_result();
        assert_int_equal(denoise("", "clipped", said), 0);
        assert_int_equal(denoise("", "lost", said), 0);
        assert_string_equal(said, "");
        struct fewray_frame *frame = read_result();
        assert_memory_equal(fewray_frame_plane(frame, "R"), fewray_frame_plane(wanted, "R"),
                            PIXELS * sizeof(float));
        fewray_frame_destroy(&frame);
        fewray_frame_destroy(&wanted);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_files_of_32_bits_keep_any_radiance),
        cmocka_unit_test(test_a_file_of_32_bits_stays_one),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
