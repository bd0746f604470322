/* SPDX-License-Identifier: Apache-2.0 */
/* Frames: planes and layers, EXR out and in, files that appear whole or not at all. */
#include "features/features_private.h"

#include <setjmp.h>
#include <stdarg.h>
/* cmocka wants the three above first */
#include <cmocka.h>
#include <dirent.h>
#include <float.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[256];

static int make_folder(void **state) {
    (void)state;
    const char *parent = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%.200s/fewray-test-frame-XXXXXX", parent ? parent : "/tmp");
    return mkdtemp(folder) ? 0 : -1;
}

static int empty_folder(void **state) {
    (void)state;
    DIR *dir = opendir(folder);
    if (!dir)
        return -1;
    for (const struct dirent *entry; (entry = readdir(dir));)
        if (entry->d_name[0] != '.' || strlen(entry->d_name) > 2)
            unlinkat(dirfd(dir), entry->d_name, 0);
    return closedir(dir);
}

static int remove_folder(void **state) {
    return empty_folder(state) || rmdir(folder);
}

static int files_in_folder(void) {
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    int count = -2;
    while (readdir(dir))
        count++;
    closedir(dir);
    return count;
}

static const char *path_of(const char *name) {
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static struct fewray_frame *new_frame(int width, int height) {
    struct fewray_frame *frame = NULL;
    assert_int_equal(fewray_frame_create(width, height, &frame, NULL), FEWRAY_OK);
    assert_non_null(frame);
    return frame;
}

/* Reproducible values: all magnitudes that half floats have, and both signs. */
static float noise(uint32_t *seed) {
    *seed = *seed * 1664525u + 1013904223u;
    const float unit = (float)(*seed >> 8) / 16777216.0f;
    return ldexpf(unit - 0.5f, (int)(*seed % 30) - 14);
}

static void fill(struct fewray_frame *frame, const char *name, uint32_t seed) {
    float *plane = fewray_frame_add(frame, name);
    assert_non_null(plane);
    for (int i = 0; i < frame->width * frame->height; i++)
        plane[i] = noise(&seed);
}

static float float_of_half(uint16_t half) {
    const float sign = half & 0x8000 ? -1.0f : 1.0f;
    const int exponent = half >> 10 & 31, mantissa = half & 1023;
    if (exponent == 31)
        return mantissa ? NAN : sign * INFINITY;
    return sign * (exponent ? ldexpf((float)(1024 + mantissa), exponent - 25)
                            : ldexpf((float)mantissa, -24));
}

static void test_planes_keep_their_address_and_alignment(void **state) {
    (void)state;
    struct fewray_frame *frame = new_frame(7, 5);
    float *first = fewray_frame_add(frame, "first");
    for (int i = 0; i < 40; i++) {
        char name[16];
        snprintf(name, sizeof name, "p%d", i);
        float *plane = fewray_frame_add(frame, name);
        assert_int_equal((uintptr_t)plane % 64, 0);
        assert_true(plane[0] == 0.0f && plane[34] == 0.0f);
        plane[34] = 1.0f;
    }
    assert_int_equal(frame->plane_count, 41);
    assert_ptr_equal(fewray_frame_add(frame, "first"), first);
    assert_ptr_equal(fewray_frame_plane(frame, "first"), first);
    assert_null(fewray_frame_plane(frame, "fir"));
    char name[FEWRAY_NAME_MAX + 1];
    memset(name, 'x', sizeof name);
    name[FEWRAY_NAME_MAX] = '\0';
    assert_null(fewray_frame_add(frame, name));
    name[FEWRAY_NAME_MAX - 1] = '\0';
    assert_non_null(fewray_frame_add(frame, name));
    fewray_frame_destroy(&frame);
    assert_null(frame);
    fewray_frame_destroy(&frame);
}

static void test_impossible_sizes_are_refused(void **state) {
    (void)state;
    const int sizes[][2] = {{0, 1}, {1, 0}, {-3, 4}, {1 << 30, 1 << 30}, {16385, 16384}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        struct fewray_frame *frame = NULL;
        struct fewray_error error;
        assert_int_equal(fewray_frame_create(sizes[i][0], sizes[i][1], &frame, &error),
                         FEWRAY_ERROR_ARGUMENT);
        assert_null(frame);
    }
}

static void test_layers_are_found_whole_or_not_at_all(void **state) {
    (void)state;
    struct fewray_frame *frame = new_frame(4, 3);
    float *added[3], *found[3];
    for (int layer = 0; layer < FEWRAY_LAYER_COUNT; layer++) {
        int count;
        const char *const *names = fewray_layer_channels(layer, &count);
        bool single = layer == FEWRAY_DEPTH || layer == FEWRAY_IRRADIANCE_CONFIDENCE;
        assert_int_equal(count, single ? 1 : 3);
        assert_false(fewray_frame_layer(frame, layer, found));
        assert_non_null(fewray_frame_add(frame, names[0]));
        assert_int_equal(fewray_frame_layer(frame, layer, found), count == 1);
        assert_true(count == 1 || !found[0]);
        assert_true(fewray_frame_add_layer(frame, layer, added));
        assert_true(fewray_frame_layer(frame, layer, found));
        assert_memory_equal(added, found, sizeof added);
        for (int c = 0; c < 3; c++)
            assert_int_equal(added[c] != NULL, c < count);
    }
    assert_int_equal(frame->plane_count, 3 * FEWRAY_LAYER_COUNT - 2 * 2);
    fewray_frame_destroy(&frame);
}

/* Every half is its own nearest; a tie goes to the even neighbour; anything else to the nearer. */
static void test_halves_are_rounded_to_nearest_even(void **state) {
    (void)state;
    for (uint32_t half = 0; half < 0x7bff; half++) {
        const float low = float_of_half((uint16_t)half), high = float_of_half((uint16_t)(half + 1));
        const float tie = 0.5f * (low + high);
        const float from[8] = {low,  nextafterf(tie, low),  tie,  nextafterf(tie, high),
                               -low, -nextafterf(tie, low), -tie, -nextafterf(tie, high)};
        const uint32_t even = half + (half & 1);
        const uint32_t expected[4] = {half, half, even, half + 1};
        uint16_t to[8];
        half_from_floats(from, to, 8);
        for (int i = 0; i < 8; i++)
            assert_int_equal(to[i], expected[i % 4] | (i < 4 ? 0 : 0x8000));
    }
}

static void test_halves_are_clamped(void **state) {
    (void)state;
    const struct {
        float from;
        uint16_t to;
    } cases[] = {
        {65504.0f, 0x7bff},    {65519.0f, 0x7bff},  {65520.0f, 0x7bff}, {1e30f, 0x7bff},
        {INFINITY, 0x7bff},    {-INFINITY, 0xfbff}, {-7e4f, 0xfbff},    {FLT_MIN, 0},
        {-FLT_MIN, 0x8000},    {1e-45f, 0},         {0.0f, 0},          {-0.0f, 0x8000},
        {5.9604645e-8f, 1},    {2.9802322e-8f, 0},  {1.0f, 0x3c00},     {-2.0f, 0xc000},
        {0.33333334f, 0x3555},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        uint16_t to;
        half_from_floats(&cases[i].from, &to, 1);
        assert_int_equal(to, cases[i].to);
    }
    const float nan = NAN;
    uint16_t to;
    half_from_floats(&nan, &to, 1);
    assert_true((to & 0x7c00) == 0x7c00 && (to & 0x3ff));
}

static void round_trip(int width, int height, bool float32) {
    /* Not in the order of names; more than the library keeps without allocating. */
    const char *const names[] = {
        "noisy.G", "R", "depth.Z",  "B",
        "A",       "G", "albedo.R", "a channel name of more than thirty-one bytes, as some have"};
    struct fewray_frame *frame = new_frame(width, height), *back = NULL;
    struct fewray_error error;
    for (uint32_t i = 0; i < sizeof names / sizeof names[0]; i++)
        fill(frame, names[i], i + 1);
    frame->planes[0].data[0] = 1e9f;
    const char *path = path_of("trip.exr");
    assert_int_equal(fewray_frame_write_exr(frame, path, float32, &error), FEWRAY_OK);
    assert_int_equal(files_in_folder(), 1);
    assert_int_equal(fewray_frame_read_exr(path, &back, &error), FEWRAY_OK);
    assert_int_equal(back->width, width);
    assert_int_equal(back->height, height);
    assert_int_equal(back->plane_count, frame->plane_count);
    for (size_t p = 0; p < frame->plane_count; p++) {
        const float *expected = frame->planes[p].data;
        const float *found = fewray_frame_plane(back, frame->planes[p].name);
        assert_non_null(found);
        for (int i = 0; i < width * height; i++) {
            uint16_t half;
            half_from_floats(&expected[i], &half, 1);
            assert_true(found[i] == (float32 ? expected[i] : float_of_half(half)));
        }
        assert_true(p == 0 || strcmp(back->planes[p - 1].name, back->planes[p].name) < 0);
    }
    fewray_frame_destroy(&frame);
    fewray_frame_destroy(&back);
}

static void test_exr_round_trip(void **state) {
    (void)state;
    const int sizes[][2] = {{1, 1}, {3, 5}, {4096, 1}, {1, 300}, {37, 16}, {129, 65}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        round_trip(sizes[i][0], sizes[i][1], false);
        round_trip(sizes[i][0], sizes[i][1], true);
    }
}

/* A block that deflate makes exactly as long as it was has to be stored raw: readers tell raw
 * blocks by their length. The share of noise is varied until such blocks occur. */
static void test_incompressible_blocks_survive(void **state) {
    (void)state;
    enum { WIDTH = 130, TRIALS = 400 };
    uint64_t random = 1;
    for (int trial = 0; trial < TRIALS; trial++) {
        struct fewray_frame *frame = new_frame(WIDTH, 1), *back = NULL;
        float *plane = fewray_frame_add(frame, "R");
        for (int i = 0; i < WIDTH; i++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            const uint32_t bits = (uint32_t)(random >> 32);
            if (i < WIDTH - trial % 20)
                memcpy(&plane[i], &bits, sizeof bits);
        }
        const char *path = path_of("noise.exr");
        assert_int_equal(fewray_frame_write_exr(frame, path, true, NULL), FEWRAY_OK);
        assert_int_equal(fewray_frame_read_exr(path, &back, NULL), FEWRAY_OK);
        assert_memory_equal(fewray_frame_plane(back, "R"), plane, WIDTH * sizeof(float));
        fewray_frame_destroy(&frame);
        fewray_frame_destroy(&back);
    }
}

static size_t read_bytes(const char *path, unsigned char *bytes, size_t size) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size = fread(bytes, 1, size, file);
    fclose(file);
    return size;
}

static void test_exr_is_the_same_from_any_number_of_threads(void **state) {
    (void)state;
    enum { SIDE = 450, MOST = 1 << 21 };
    unsigned char *bytes[2] = {malloc(MOST), malloc(MOST)};
    size_t size[2];
    struct fewray_frame *frame = new_frame(SIDE, SIDE);
    fill(frame, "R", 1);
    fill(frame, "G", 2);
    fewray_frame_add(frame, "B");
    const int threads = omp_get_max_threads();
    for (int i = 0; i < 2; i++) {
        omp_set_num_threads(i ? 5 : 1);
        assert_int_equal(fewray_frame_write_exr(frame, path_of("same.exr"), false, NULL),
                         FEWRAY_OK);
        size[i] = read_bytes(path_of("same.exr"), bytes[i], MOST);
    }
    omp_set_num_threads(threads);
    assert_true(size[0] == size[1] && size[0] < MOST);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    free(bytes[0]);
    free(bytes[1]);
    fewray_frame_destroy(&frame);
}

static void write_bytes(const char *path, const void *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static void need_refusal(const char *path, int status) {
    struct fewray_frame *frame = NULL;
    struct fewray_error error;
    assert_int_equal(fewray_frame_read_exr(path, &frame, &error), status);
    assert_null(frame);
    assert_string_equal(error.file, path);
    assert_true(error.what[0] != '\0' && !strchr(error.what, '\n'));
}

static void test_cut_off_exr_is_refused_at_every_length(void **state) {
    (void)state;
    static unsigned char bytes[100000];
    struct fewray_frame *frame = new_frame(19, 40);
    fill(frame, "R", 1);
    fill(frame, "G", 2);
    assert_int_equal(fewray_frame_write_exr(frame, path_of("whole.exr"), false, NULL), FEWRAY_OK);
    fewray_frame_destroy(&frame);
    const size_t size = read_bytes(path_of("whole.exr"), bytes, sizeof bytes);
    assert_in_range(size, 1000, sizeof bytes - 1);
    for (size_t cut = 0; cut < size; cut += cut < 600 || cut > size - 100 ? 1 : 53) {
        write_bytes(path_of("cut.exr"), bytes, cut);
        need_refusal(path_of("cut.exr"), FEWRAY_ERROR_FORMAT);
    }
}

static void test_what_is_no_exr_is_refused(void **state) {
    (void)state;
    const char text[] = "no picture\nat all\n";
    write_bytes(path_of("text.exr"), text, sizeof text - 1);
    need_refusal(path_of("text.exr"), FEWRAY_ERROR_FORMAT);
    need_refusal(path_of("nowhere.exr"), FEWRAY_ERROR_IO);
    need_refusal(folder, FEWRAY_ERROR_IO);
}

static void test_failed_write_leaves_nothing(void **state) {
    (void)state;
    struct fewray_error error;
    struct fewray_frame *frame = new_frame(8, 8);
    const char *path = path_of("missing/out.exr");
    assert_int_equal(fewray_frame_write_exr(frame, path, false, &error), FEWRAY_ERROR_ARGUMENT);
    fill(frame, "R", 1);
    assert_int_equal(fewray_frame_write_exr(frame, path, false, &error), FEWRAY_ERROR_IO);
    assert_string_equal(error.file, path);
    assert_int_equal(files_in_folder(), 0);

    /* A folder can't be replaced by a file; the temporary file has to go. */
    path = path_of("folder.exr");
    assert_int_equal(mkdir(path, 0777), 0);
    assert_int_equal(fewray_frame_write_exr(frame, path, false, &error), FEWRAY_ERROR_IO);
    assert_string_equal(error.file, path);
    assert_int_equal(files_in_folder(), 1);
    assert_int_equal(rmdir(path), 0);
    assert_int_equal(fewray_frame_write_exr(frame, "/dev/null", false, &error), FEWRAY_ERROR_IO);
    fewray_frame_destroy(&frame);
}

static void test_commit_replaces_or_cleans_up(void **state) {
    (void)state;
    char path[512], content[8] = {0};
    snprintf(path, sizeof path, "%s", path_of("stats.json"));
    write_bytes(path, "old", 3);
    char *temporary = fewray_temporary_name(path), *other = fewray_temporary_name(path);
    assert_non_null(temporary);
    assert_string_not_equal(temporary, other);
    assert_int_equal(strncmp(temporary, path, strlen(folder) + 1), 0);
    write_bytes(temporary, "new", 3);
    assert_int_equal(fewray_commit_file(temporary, path, NULL), FEWRAY_OK);
    read_bytes(path, (unsigned char *)content, 3);
    assert_string_equal(content, "new");
    assert_int_equal(files_in_folder(), 1);

    struct fewray_error error;
    write_bytes(other, "lost", 4);
    snprintf(path, sizeof path, "%s", path_of("missing/stats.json"));
    assert_int_equal(fewray_commit_file(other, path, &error), FEWRAY_ERROR_IO);
    assert_string_equal(error.file, path);
    assert_int_equal(files_in_folder(), 1);
    free(temporary);
    free(other);
}

static void test_error_text(void **state) {
    (void)state;
    struct fewray_error error;
    char text[64];
    assert_int_equal(fewray_fail(&error, FEWRAY_ERROR_FORMAT, "a.xml", 7, "bad\n%s", "word"),
                     FEWRAY_ERROR_FORMAT);
    assert_string_equal(fewray_error_text(&error, text, sizeof text), "a.xml:7: bad word");
    fewray_fail(&error, FEWRAY_ERROR_IO, "a.xml", 0, "gone");
    assert_string_equal(fewray_error_text(&error, text, sizeof text), "a.xml: gone");
    fewray_fail(&error, FEWRAY_ERROR_IO, NULL, 0, "gone");
    assert_string_equal(fewray_error_text(&error, text, 4), "gon");
    assert_int_equal(fewray_fail(NULL, FEWRAY_ERROR_MEMORY, NULL, 0, "-"), FEWRAY_ERROR_MEMORY);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_planes_keep_their_address_and_alignment),
        cmocka_unit_test(test_impossible_sizes_are_refused),
        cmocka_unit_test(test_layers_are_found_whole_or_not_at_all),
        cmocka_unit_test(test_halves_are_rounded_to_nearest_even),
        cmocka_unit_test(test_halves_are_clamped),
        cmocka_unit_test_teardown(test_exr_round_trip, empty_folder),
        cmocka_unit_test_teardown(test_incompressible_blocks_survive, empty_folder),
        cmocka_unit_test_teardown(test_exr_is_the_same_from_any_number_of_threads, empty_folder),
        cmocka_unit_test_teardown(test_cut_off_exr_is_refused_at_every_length, empty_folder),
        cmocka_unit_test_teardown(test_what_is_no_exr_is_refused, empty_folder),
        cmocka_unit_test_teardown(test_failed_write_leaves_nothing, empty_folder),
        cmocka_unit_test_teardown(test_commit_replaces_or_cleans_up, empty_folder),
        cmocka_unit_test(test_error_text),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
