/* SPDX-License-Identifier: Apache-2.0 */
/* Weights that are finite but beyond reason, and what the command says of damaged ones. */

#include <sys/wait.h>
#include <unistd.h>

#include "weights_stage.h"

/* --- weights beyond reason */

/* All of them the largest half: the layers overflow, the picture doesn't. */
static void test_the_largest_weights_leave_a_finite_picture(void **state) {
    (void)state;
    enum { SIDE = 16 };
    static float color[3 * SIDE * SIDE], out[3 * SIDE * SIDE];
    for (int i = 0; i < 3 * SIDE * SIDE; i++)
        color[i] = 0.1f + (float)(i * 37 % 101) / 101;
    for (int sparse = 0; sparse < 2; sparse++) {
        struct file f = file_of(1);
        const uint32_t tensors = integer_at(&f, count_at(&f));
        for (uint32_t k = 0; k < tensors; k++) {
            size_t values;
            const size_t at = tensor_at(&f, k, &values) + HEAD_BYTES;
            if (!memcmp(f.bytes + at - HEAD_BYTES, "scale", 5))
                continue; /* logarithms: see the next test */
            for (size_t i = 0; i < values; i += 1 + (size_t)sparse) {
                f.bytes[at + 2 * i] = 0xff;
                f.bytes[at + 2 * i + 1] = i % 3 && sparse ? 0xfb : 0x7b;
            }
        }
        sign(&f);
        store(&f);
        char path[64];
        path_of(path, sizeof path);
        struct fewray_denoise_options options;
        struct fewray_denoiser *denoiser = NULL;
        fewray_denoise_options_init(&options);
        options.weights_path = path;
        options.threads = 1;
        const struct fewray_denoise_input in = {
            .width = SIDE, .height = SIDE, .color = fewray_interleaved(color, SIDE)};
        assert_int_equal(fewray_denoiser_create(&options, &denoiser, NULL), FEWRAY_OK);
        assert_int_equal(fewray_denoiser_run(denoiser, &in, out, NULL, NULL), FEWRAY_OK);
        fewray_denoiser_destroy(&denoiser);
        for (int i = 0; i < 3 * SIDE * SIDE; i++) /* weights sum to at most 1 */
            assert_true(out[i] >= 0 && out[i] <= 1.11f);
        free(f.bytes);
    }
}

static void test_scales_beyond_floats_are_refused(void **state) {
    (void)state;
    for (int n = 0; n < 2; n++) {
        struct file f = file_of(n);
        const uint32_t tensors = integer_at(&f, count_at(&f));
        for (uint32_t k = 0; k < tensors; k++) {
            size_t values;
            const size_t at = tensor_at(&f, k, &values) + HEAD_BYTES;
            if (memcmp(f.bytes + at - HEAD_BYTES, "scale", 5))
                continue;
            const uint8_t kept[2] = {f.bytes[at], f.bytes[at + 1]};
            f.bytes[at] = 0xff; /* e^65504 */
            f.bytes[at + 1] = 0x7b;
            sign(&f);
            refuse(n, &f, FEWRAY_ERROR_FORMAT, "an infinite scale", k);
            memcpy(f.bytes + at, kept, 2);
        }
        free(f.bytes);
    }
}

/* --- the command */

static void expect_one_line(const char *arguments) {
    char line[1024], path[64], messages[4096];
    snprintf(line, sizeof line, "cd %s && %s %s > out.txt 2> err.txt < /dev/null", folder,
             FEWRAY_COMMAND, arguments);
    const int status = system(line);
    snprintf(path, sizeof path, "%s/err.txt", folder);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    messages[fread(messages, 1, sizeof messages - 1, file)] = 0;
    fclose(file);
    const char *end = strchr(messages, '\n');
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 1 || !end || end[1] ||
        strncmp(messages, "fewray: damaged.bin: ", 21))
        fail_msg("%s: exit %d: %s", arguments, WEXITSTATUS(status), messages);
    snprintf(path, sizeof path, "%s/out.exr", folder);
    assert_int_equal(access(path, F_OK), -1);
}

static void test_the_command_says_one_line_and_leaves_nothing(void **state) {
    (void)state;
    struct fewray_frame *frame = NULL;
    float *planes[3];
    char path[64];
    assert_int_equal(fewray_frame_create(8, 8, &frame, NULL), FEWRAY_OK);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, planes));
    snprintf(path, sizeof path, "%s/in.exr", folder);
    assert_int_equal(fewray_frame_write_exr(frame, path, false, NULL), FEWRAY_OK);
    fewray_frame_destroy(&frame);

    struct file f = file_of(0);
    f.bytes[5000] ^= 4;
    store(&f);
    expect_one_line("denoise in.exr -o out.exr --denoise-weights damaged.bin");
    free(f.bytes);
    f = file_of(0);
    store(&f);
    expect_one_line("render " EXAMPLES "/door-ajar.xml -o out.exr --width 128 --height 128 "
                    "--pilot off --guide-weights damaged.bin");
    free(f.bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_largest_weights_leave_a_finite_picture),
        cmocka_unit_test(test_scales_beyond_floats_are_refused),
        cmocka_unit_test(test_the_command_says_one_line_and_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
