/* SPDX-License-Identifier: Apache-2.0 */
/* The built command from outside: exit codes, one line on stderr, files that appear all or not at
 * all. */

#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/unit/scratch_folder.h"
#include <jansson.h>

#include "fewray/features.h"

#define SCENE EXAMPLES "/cornell-box.xml"

/* Runs the command in the folder; messages gets what it wrote on stderr. Returns its exit code. */
static int run(char *messages, size_t size, const char *arguments) {
    char line[2048];
    snprintf(line, sizeof line, "cd %s && %s %s > out.txt 2> err.txt < /dev/null", folder,
             FEWRAY_COMMAND, arguments);
    const int status = system(line);
    char path[64];
    snprintf(path, sizeof path, "%s/err.txt", folder);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    messages[fread(messages, 1, size - 1, file)] = 0;
    fclose(file);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static bool exists(const char *name) {
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return access(path, F_OK) == 0;
}

static void expect_error(const char *arguments, int code, const char *named) {
    char messages[4096];
    const int got = run(messages, sizeof messages, arguments);
    if (got != code)
        fail_msg("%s: exit %d, expected %d: %s", arguments, got, code, messages);
    const char *end = strchr(messages, '\n');
    if (strncmp(messages, "fewray: ", 8) || !end || end[1])
        fail_msg("%s: not one line: %s", arguments, messages);
    if (named && !strstr(messages, named))
        fail_msg("%s: doesn't name %s: %s", arguments, named, messages);
}

static void expect_success(const char *arguments) {
    char messages[4096];
    if (run(messages, sizeof messages, arguments))
        fail_msg("%s: %s", arguments, messages);
}

static void test_wrong_command_lines_exit_2_with_one_line(void **state) {
    (void)state;
    static const char *const wrong[] = {
        "",
        "frobnicate",
        "'new\nline'",
        "render -o out.exr",
        "render " SCENE,
        "render " SCENE " -o ''",
        "render " SCENE " -o out.exr --spp 0",
        "render " SCENE " -o out.exr --max-depth 0",
        "render " SCENE " -o out.exr --max-depth -2",
        "render " SCENE " -o out.exr --width 65536 --height 65536",
        "render " SCENE " -o out.exr -D novalue",
        "render " SCENE " -o out.exr --png out.exr",
        "render " SCENE " -o out.exr --preview out.exr",
        "render " SCENE " -o out.exr --png out.png --preview out.png",
        "render " SCENE " -o out.exr --preview out.png --preview-interval -1",
        "render " SCENE " -o out.exr --guide best",
        "render " SCENE " -o out.exr --bsdf-fraction -0.1",
        "render " SCENE " -o out.exr --map-bins 12",
        "render " SCENE " -o out.exr --probes maybe",
        "render " SCENE " -o out.exr --aovs direct,sideways",
        "render " SCENE " -o out.exr --aovs ''",
        "render " SCENE " -o out.exr --part 0/3",
        "render " SCENE " -o out.exr --part 4/3",
        "render " SCENE " -o out.exr --part 1",
        "render " SCENE " -o out.exr --part 1/2 --png out.png",
        "render " SCENE " -o out.exr --part 1/2 --guide ppg",
        "render " SCENE " -o out.exr --skip-existing",
        "merge -o out.exr",
        "merge one.exr two.exr",
        "render " SCENE " -o out.exr --frames 1..4",
        "render " SCENE " -o out.##.exr --stats s.json --frames 1..4",
        "render " SCENE " -o out.##.exr --frames 4..1",
        "render " SCENE " -o out.##.exr --frames 1..4x0",
        "render " SCENE " -o out.##.exr --frames 1..4 --fps 0",
        "render " SCENE " -o out.##.exr --part 1/2 --frames 1..4",
        "render " SCENE " -o out.exr --spp 4 --time 5s",
        "render " SCENE " -o out.exr --spp 4 --error 0.02",
        "render " SCENE " -o out.exr --time 5s --error 0.02",
        "render " SCENE " -o out.exr --time 5h",
        "render " SCENE " -o out.exr --error 0",
        "render " SCENE " -o out.exr --max-spp 8",
        "render " SCENE " -o out.exr --time 5s --guide ppg",
        "render " SCENE " -o out.exr --time 5s --part 1/2",
        "render " SCENE " -o out.##.exr --time 5s --frames 1..4",
        "render " SCENE " -o out.exr --checkpoint-every 5s",
        "render " SCENE " -o out.exr --checkpoint out.exr",
        "render " SCENE " -o out.exr --checkpoint a --resume b",
        "render " SCENE " -o out.exr --time 5s --checkpoint a",
        "render " SCENE " -o out.##.exr --frames 1..4 --checkpoint a",
        "render " SCENE " -o out.exr --guide ppg --checkpoint a",
        "report",
        "report . -o ''",
        "report . --max-width 1",
        "bench " SCENE " --reference r.exr -o out --spp 1,2 --keep-pictures 4",
        "denoise -o out.exr",
        "denoise in.exr -o out.exr --aov direct,,indirect",
        "denoise in.exr -o out.exr --aov direct,",
        "denoise in.exr",
        "denoise in.exr -o out.exr --layers frobnicate",
        "denoise in.##.exr -o out.exr",
        "denoise in.##.exr -o out.##.exr --png out.png",
        "denoise in.##.exr -o out.##.exr --frames 4..1",
        "denoise in.exr -o out.exr --frames 1..4",
        "denoise in.exr -o out.exr --skip-existing",
        "compare one.exr",
        "compare one.exr two.exr three.exr",
        "composite one.exr two.exr",
        "composite one.exr two.exr -o out.png --crop 1,2,3",
        "composite one.exr two.exr -o out.png --crop 1,2,3,4x",
        "info",
        "bench " SCENE " -o bench",
        "bench " SCENE " --reference ref.exr",
        "bench " SCENE " --reference ref.exr -o bench --spp 0",
        "bench " SCENE " --reference ref.exr -o bench --spp 4x",
        "bench " SCENE " --reference ref.exr -o bench --spp 2,4,2",
        "bench " SCENE " --reference ref.exr -o bench --max-depth 0",
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        expect_error(wrong[i], 2, NULL);
    assert_false(exists("out.exr") || exists("bench"));
}

static void test_failed_work_exits_1_and_names_the_file(void **state) {
    (void)state;
    expect_error("render nowhere.xml -o out.exr", 1, "nowhere.xml");
    expect_error("render " SCENE " -o none/out.exr", 1, "none/out.exr");
    expect_error("render " SCENE " -o out.exr --stats none/out.json", 1, "none/out.json");
    expect_error("render " SCENE " -o out.exr --resume nowhere.state", 1, "nowhere.state");
    expect_error("render " SCENE " -o out.exr --checkpoint none/state", 1, "none/state");
    expect_error("merge nowhere.exr -o out.exr", 1, "nowhere.exr");
    expect_error("render " SCENE " -o out.exr --preview none/out.png", 1, "none/out.png");
    expect_error("denoise nowhere.exr -o out.exr", 1, "nowhere.exr");
    expect_error("denoise nowhere.##.exr -o out.##.exr", 1, "nowhere.##.exr");
    expect_error("denoise nowhere.##.exr -o out.##.exr --frames 3..5", 1, "3..5");
    expect_error("compare nowhere.exr other.exr", 1, "nowhere.exr");
    expect_error("composite nowhere.exr other.exr -o out.png", 1, "nowhere.exr");
    expect_error("bench " SCENE " --reference nowhere.exr -o bench", 1, "nowhere.exr");
    expect_error("bench " SCENE " --reference nowhere.exr -o no/bench", 1, "no/bench");
    expect_error("info nowhere.exr", 1, "nowhere.exr");
    expect_error("info nowhere.xml", 1, "nowhere.xml");
    assert_false(exists("out.exr") || exists("out.png"));
}

static void test_help_and_version_exit_0(void **state) {
    (void)state;
    static const char *const asked[] = {"--help",         "--version",      "render --help",
                                        "denoise --help", "compare --help", "composite --help",
                                        "info --help",    "merge --help",   "bench --help"};
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++)
        expect_success(asked[i]);
}

/* From a scene to a composite and back through every subcommand. */
static void test_the_whole_way(void **state) {
    (void)state;
    expect_success("render " SCENE
                   " -o out.exr --width 40 --height 30 --spp 2 --png out.png --stats out.json");
    assert_true(exists("out.exr") && exists("out.png"));
    expect_success(
        "render " SCENE
        " -o ref.exr --width 40 --height 30 --spp 16 --seed 9 --guide off --denoise off");
    expect_success("denoise ref.exr -o again.exr --stats again.json");
    expect_success("compare out.exr ref.exr --json");
    expect_success(
        "composite out.exr out.exr ref.exr -o all.png --stats out.json --crop 0,0,10,10");
    expect_success("composite out.exr out.exr -o two.png");
    expect_success("info out.exr");
    expect_success("info " SCENE);
    char path[64];
    snprintf(path, sizeof path, "%s/out.json", folder);
    json_t *stats = json_load_file(path, 0, NULL);
    assert_int_equal(json_integer_value(json_object_get(stats, "spp")), 2);
    assert_true(json_integer_value(json_object_get(stats, "paths")) <= 40 * 30 * 2);
    json_decref(stats);
}

/* The largest difference of direct + indirect from the colour, as a part of it. */
static double parts_difference(const char *name, const char *prefix) {
    char path[128], channels[3][32];
    struct fewray_frame *frame = NULL;
    double largest = 0;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_int_equal(fewray_frame_read_exr(path, &frame, NULL), FEWRAY_OK);
    for (int c = 0; c < 3; c++) {
        const float *planes[3];
        for (int k = 0; k < 3; k++) {
            snprintf(channels[k], sizeof channels[k], "%s%s%c", prefix,
                     k == 0 ? "" : (k == 1 ? "direct." : "indirect."), "RGB"[c]);
            planes[k] = fewray_frame_plane(frame, channels[k]);
            assert_non_null(planes[k]);
        }
        for (int i = 0; i < frame->width * frame->height; i++) {
            assert_true(planes[1][i] >= 0 && planes[2][i] >= 0);
            largest = fmax(largest, fabs((double)planes[1][i] + planes[2][i] - planes[0][i]) /
                                        fmax(planes[0][i], 1e-4));
        }
    }
    fewray_frame_destroy(&frame);
    return largest;
}

static void test_direct_and_indirect_light_add_up(void **state) {
    (void)state;
    static const char *const guides[] = {"off", "ppg", "odis --pilot off"};
    for (int g = 0; g < 3; g++) {
        char line[512];
        snprintf(line, sizeof line,
                 "render " SCENE " -o parts.exr --width 40 --height 30 --spp 6 --float "
                 "--aovs direct,indirect --guide %s",
                 guides[g]);
        expect_success(line);
        assert_true(parts_difference("parts.exr", "noisy.") < 3e-7);
        assert_true(parts_difference("parts.exr", "") < 3e-6);
    }
}

static void test_named_layers_are_denoised(void **state) {
    (void)state;
    expect_success("render " SCENE " -o parts.exr --width 40 --height 30 --spp 2 --float "
                   "--denoise off --aovs direct --aovs indirect");
    assert_true(parts_difference("parts.exr", "") < 3e-7);
    expect_success("denoise parts.exr -o clean.exr --float --aov direct,indirect");
    assert_true(parts_difference("clean.exr", "noisy.") < 3e-7);
    assert_true(parts_difference("clean.exr", "") < 3e-6);
    /* again, from the noisy layers */
    expect_success("denoise clean.exr -o again.exr --float --aov direct:emission,indirect,A");
    assert_true(parts_difference("again.exr", "noisy.") < 3e-7);
    assert_true(parts_difference("again.exr", "") < 3e-6);
    expect_success("denoise parts.exr -o auto.exr --float --aov auto");
    assert_true(parts_difference("auto.exr", "noisy.") < 3e-7);
    assert_true(parts_difference("auto.exr", "") < 3e-6);
    expect_success("info auto.exr --json");
    expect_error("denoise parts.exr -o none.exr --aov direct,sideways", 1, "sideways");
    expect_error("denoise parts.exr -o none.exr --aov albedo", 1, "albedo");
    assert_false(exists("none.exr"));
}

static void test_parts_are_merged(void **state) {
    (void)state;
    expect_success("render " SCENE " -o p1.exr --width 40 --height 30 --spp 2 --part 1/2");
    expect_error("merge p1.exr -o all.exr", 1, "2");
    expect_success("render " SCENE " -o p2.exr --width 40 --height 30 --spp 2 --part 2/2");
    expect_success("render " SCENE
                   " -o p2.exr --width 40 --height 30 --spp 2 --part 2/2 --skip-existing");
    expect_success("merge p2.exr p1.exr -o all.exr --png all.png --stats all.json");
    assert_true(exists("all.exr") && exists("all.png") && exists("all.json"));
}

static long long stat_of_render(const char *options, const char *name) {
    char line[512], path[64];
    snprintf(line, sizeof line,
             "render " SCENE " -o guide.exr --stats guide.json --width 40 --height 30 --spp 6 "
             "--denoise off %s",
             options);
    expect_success(line);
    snprintf(path, sizeof path, "%s/guide.json", folder);
    json_t *stats = json_load_file(path, 0, NULL);
    assert_non_null(stats);
    const long long value = json_integer_value(json_object_get(stats, name));
    assert_int_equal(json_integer_value(json_object_get(stats, "paths")), 40 * 30 * 6);
    json_decref(stats);
    return value;
}

static void test_every_guide_can_be_chosen(void **state) {
    (void)state;
    assert_int_equal(stat_of_render("--guide off", "grids"), 0);
    assert_int_equal(stat_of_render("--guide ppg", "grids"), 0);
    assert_true(stat_of_render("--guide ppg", "pixels_guided") > 0);
    assert_int_equal(stat_of_render("--guide odis", "grids"),
                     0); /* so small a picture does without */
    assert_int_equal(stat_of_render("--guide odis --pilot off", "grids"), 5 * 4);
    assert_int_equal(stat_of_render("--guide paper", "grids"), 5 * 4);
    assert_true(
        stat_of_render("--pilot off --probes off --refine off --map-bins 8 --bsdf-fraction 0",
                       "pixels_guided") > 0);
}

/* The order on the command line doesn't matter. */
static void test_given_options_override_the_papers(void **state) {
    (void)state;
    assert_true(stat_of_render("--guide paper", "pixels_guided") > 0);
    /* nothing but the BSDF: no pixel is guided */
    assert_int_equal(stat_of_render("--bsdf-fraction 1 --guide paper", "pixels_guided"), 0);
    assert_int_equal(stat_of_render("--guide paper --bsdf-fraction 1", "pixels_guided"), 0);
}

/* Whether the command opens a shared library of this name, at its start or later, which the
 * dynamic linker (glibc) tells. */
static bool opens(const char *arguments, const char *library) {
    char line[2048];
    snprintf(
        line, sizeof line,
        "cd %s && LD_DEBUG=files %s %s 2> opened.txt > out.txt && grep -q 'libc.so' opened.txt "
        "&& grep -q '%s' opened.txt",
        folder, FEWRAY_COMMAND, arguments, library);
    const int status = system(line);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status) == 0;
}

static void test_libraries_are_opened_where_they_are_needed(void **state) {
    (void)state;
    static const char *const heavy[] = {
        "libembree",
        "libtbb",
        "OpenImageIO",
        "opencv",
#if !defined(__SANITIZE_ADDRESS__) && !defined(__clang__) /* whose libraries need it */
        "libstdc",
#endif
    };
    static const char render[] = "render " SCENE " -o few.exr --width 8 --height 8 --spp 1";
    expect_success(render);
    assert_true(opens("denoise few.exr -o clean.exr", "OpenEXRCore"));
    for (size_t i = 0; i < sizeof heavy / sizeof *heavy; i++)
        assert_false(opens("denoise few.exr -o clean.exr --png clean.png", heavy[i]));
    assert_true(opens(render, "libembree"));
    assert_false(opens(render, "OpenImageIO"));
}

static void test_an_interrupted_render_leaves_what_is_done(void **state) {
    (void)state;
    char line[1024];
    snprintf(
        line, sizeof line,
        "cd %s && { %s render %s -o cut.exr --preview cut.png --spp 512 --width 1024 --height 1024 "
        "2> err.txt & "
        "sleep 1; kill -TERM $!; wait $!; }",
        folder, FEWRAY_COMMAND, SCENE);
    const int status = system(line);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 1);
    assert_true(exists("cut.exr"));
    expect_success("info cut.exr");
    struct fewray_image *preview = NULL;
    char path[64];
    snprintf(path, sizeof path, "%s/cut.png", folder);
    assert_int_equal(fewray_image_read(path, &preview, NULL), FEWRAY_OK);
    assert_int_equal(preview->width, 1024);
    fewray_image_destroy(&preview);
}

/* A second signal doesn't wait for the files. */
static void test_a_second_interrupt_kills(void **state) {
    (void)state;
    char line[1024];
    snprintf(line, sizeof line,
             "cd %s && { %s render %s -o killed.exr --preview killed.png --spp 512 --width 3000 "
             "--height 3000 2> err.txt & sleep 0.5; kill -TERM $!; kill -TERM $!; sleep 0.02; "
             "kill -TERM $! 2> err.txt; wait $!; }",
             folder, FEWRAY_COMMAND, SCENE);
    const int status = system(line);
    assert_int_equal(WEXITSTATUS(status), 128 + SIGTERM);
    assert_false(exists("killed.exr"));
}

/* The columns of the first line and the lines below it; each line must have as many columns. */
static void count_table(const char *name, int *columns, int *rows) {
    char path[128], line[2048];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    for (*columns = 0, *rows = -1; fgets(line, sizeof line, file); ++*rows) {
        int count = 1;
        for (const char *c = line; *c; c++)
            count += *c == ',';
        if (*columns == 0)
            *columns = count;
        assert_int_equal(count, *columns);
    }
    fclose(file);
}

static void test_a_bench_leaves_table_json_and_plot(void **state) {
    (void)state;
    char messages[4096], path[64];
    int columns, rows;
    expect_success("render " SCENE " -o ref.exr --width 40 --height 30 --spp 16 --seed 9 "
                   "--guide off --denoise off");
    assert_int_equal(run(messages, sizeof messages,
                         "bench " SCENE " --reference ref.exr -o bench --spp 2,1 --seeds 1 "
                         "--peers --python /nowhere/python"),
                     0);
    assert_non_null(strstr(messages, "warning")); /* of the peers alone */
    count_table("bench/bench.csv", &columns, &rows);
    assert_int_equal(rows, 4 * 2);
    assert_true(columns > 20 && exists("bench/bench.png"));
    snprintf(path, sizeof path, "%s/bench/bench.json", folder);
    json_t *bench = json_load_file(path, 0, NULL);
    json_t *methods = json_object_get(bench, "methods");
    assert_int_equal(json_array_size(methods), 4);
    for (size_t i = 0; i < json_array_size(methods); i++) {
        json_t *points = json_object_get(json_array_get(methods, i), "points");
        assert_int_equal(json_array_size(points), 2);
        assert_int_equal(json_integer_value(json_object_get(json_array_get(points, 0), "spp")), 1);
    }
    assert_true(json_is_null(json_object_get(bench, "peers")));
    json_decref(bench);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_wrong_command_lines_exit_2_with_one_line),
        cmocka_unit_test(test_failed_work_exits_1_and_names_the_file),
        cmocka_unit_test(test_help_and_version_exit_0),
        cmocka_unit_test(test_the_whole_way),
        cmocka_unit_test(test_direct_and_indirect_light_add_up),
        cmocka_unit_test(test_named_layers_are_denoised),
        cmocka_unit_test(test_parts_are_merged),
        cmocka_unit_test(test_every_guide_can_be_chosen),
        cmocka_unit_test(test_given_options_override_the_papers),
        cmocka_unit_test(test_libraries_are_opened_where_they_are_needed),
        cmocka_unit_test(test_a_bench_leaves_table_json_and_plot),
        cmocka_unit_test(test_an_interrupted_render_leaves_what_is_done),
        cmocka_unit_test(test_a_second_interrupt_kills),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
