/* SPDX-License-Identifier: Apache-2.0 */
/* The page of `fewray report`: whole, loads nothing, says nothing that files' names could forge. */

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/unit/scratch_folder.h"

#include "pipeline/bench.h"
#include "pipeline/origin.h"
#include "pipeline/page/page.h"

enum { WIDTH = 24, HEIGHT = 16 };

static void path_of(const char *name, char path[256]) {
    snprintf(path, 256, "%s/%s", folder, name);
}

/* A folder of its own below the scratch folder, as "NAME/". */
static void start(const char *name, char path[128]) {
    snprintf(path, 128, "%s/%s", folder, name);
    assert_int_equal(mkdir(path, 0777), 0);
}

static void write_text(const char *in, const char *name, const char *text) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", in, name);
    assert_int_equal(fewray_write_file(path, text, strlen(text), NULL), 0);
}

/* A picture of one value everywhere but for its first pixel; noisy: 0, or the value of the noisy
 * layer. */
static void write_picture(const char *in, const char *name, int width, float value, float noisy) {
    struct fewray_frame *frame = NULL;
    float *planes[3];
    char path[512];
    assert_int_equal(fewray_frame_create(width, HEIGHT, &frame, NULL), 0);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, planes));
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < width * HEIGHT; i++)
            planes[c][i] = i ? value : 1;
    if (noisy > 0) {
        assert_true(fewray_frame_add_layer(frame, FEWRAY_NOISY, planes));
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < width * HEIGHT; i++)
                planes[c][i] = noisy;
    }
    snprintf(path, sizeof path, "%s/%s", in, name);
    assert_int_equal(fewray_frame_write_exr(frame, path, false, NULL), 0);
    fewray_frame_destroy(&frame);
}

static char *read_text(const char *path) {
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    const long size = ftell(file);
    char *text = malloc((size_t)size + 1);
    assert_non_null(text);
    rewind(file);
    assert_int_equal(fread(text, 1, (size_t)size, file), size);
    text[size] = 0;
    fclose(file);
    return text;
}

/* The page of a folder; to be freed. */
static char *make(const char *in, struct page_options options) {
    char path[512];
    struct fewray_error error;
    options.folder = in;
    options.max_width = options.max_width ? options.max_width : 1920;
    if (page_write(&options, &error))
        fail_msg("%s: %s", error.file, error.what);
    snprintf(path, sizeof path, "%s/report.html", in);
    return read_text(options.output ? options.output : path);
}

static void expect_failure(const char *in, int status, const char *named) {
    char path[512];
    struct fewray_error error;
    const struct page_options options = {.folder = in, .max_width = 1920};
    assert_int_equal(page_write(&options, &error), status);
    if (!strstr(error.file, named) && !strstr(error.what, named))
        fail_msg("doesn't name %s: %s: %s", named, error.file, error.what);
    snprintf(path, sizeof path, "%s/report.html", in);
    assert_int_equal(access(path, F_OK), -1);
    snprintf(path, sizeof path, "ls -A %s | grep -q '[.]tmp$'", in);
    assert_int_not_equal(system(path), 0);
}

static int count(const char *text, const char *word) {
    int found = 0;
    while ((text = strstr(text, word))) {
        found++;
        text += strlen(word);
    }
    return found;
}

static void has(const char *text, const char *word) {
    if (!strstr(text, word))
        fail_msg("the page lacks %s", word);
}

static void test_pictures_are_there_once_with_metrics_and_maps(void **state) {
    (void)state;
    char in[128];
    start("whole", in);
    write_picture(in, "b.exr", WIDTH, 0.5f, 0.25f);
    write_picture(in, "a.EXR", WIDTH, 0.75f, 0);
    write_picture(in, "reference.exr", WIDTH, 0.5f, 0);
    write_picture(in, ".hidden.exr", WIDTH, 0.5f, 0);
    write_text(in, "b.json",
               "{\"initial_s\": 0.5, \"guide_s\": 0.25, \"render_s\": 1, "
               "\"denoise_s\": 2, \"spp\": 7, \"threads\": 3, \"cpu\": \"a CPU\", "
               "\"command\": \"fewray render x\", \"version\": \"9.9\"}");
    char *page = make(in, (struct page_options){0});
    assert_int_equal(count(page, "class=\"shown\""), 4);
    assert_int_equal(count(page, "class=\"error\""), 3);
    assert_int_equal(count(page, "src=\"data:image/png;base64,iVBORw0KGgo"), 8); /* the legend's */
    has(page, "data-name=\"a\"");
    has(page, "data-name=\"b, before the denoiser\"");
    has(page, "data-left=\"1\" data-right=\"2\""); /* before and after */
    /* b is its reference: the least mrse is marked, PSNR has no end */
    has(page, "<th scope=\"row\">b</th><td><strong>0</strong></td>");
    has(page, "<strong>&infin;</strong>");
    /* (0.75 - 0.5)^2 / (0.5^2 + 0.01) in all pixels but one of 384 */
    has(page, "<th scope=\"row\">a</th><td>0.2398</td>");
    has(page, "<td>7</td><td>1.75</td>");
    has(page, "<td>7</td><td>3.75</td>");
    has(page, "3 threads of a CPU, fewray 9.9");
    free(page);
}

static void test_nothing_is_loaded_from_anywhere(void **state) {
    (void)state;
    char in[128];
    start("alone", in);
    write_picture(in, "a.exr", WIDTH, 0.5f, 0.25f);
    char *page = make(in, (struct page_options){0});
    static const char *const wrong[] = {"http:",   "https:", "//",         "url(",
                                        "@import", "{{",     "<script src"};
    char *script = strstr(page, "<script>"), *image;
    assert_non_null(script);
    *script = 0; /* whose comments begin with slashes; the browser test watches what it does */
    while ((image = strstr(page, "base64,"))) /* in which // is nothing */
        memset(image, ' ', strcspn(image, "\""));
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        if (strstr(page, wrong[i]))
            fail_msg("the page has %s", wrong[i]);
    has(page, "default-src 'none'");
    assert_null(strstr(script + 1, "http"));
    assert_null(strstr(script + 1, "fetch("));
    free(page);
}

static void test_names_are_text_whatever_they_hold(void **state) {
    (void)state;
    char in[128];
    start("names", in);
    write_picture(in, "<b>&\"'.exr", WIDTH, 0.5f, 0);
    write_picture(in, "{{title}}.exr", WIDTH, 0.5f, 0);
    write_text(in, "<b>&\"'.json", "{\"command\": \"x <script>alert(1)</script>\"}");
    write_text(
        in, "bench.json",
        "{\"methods\": [{\"method\": \"<img src=x>\", \"points\": [{\"spp\": 1, \"work_s\": 1, "
        "\"flip\": {\"median\": 0.5, \"least\": 0.25, \"most\": 0.75}}]}]}");
    char *page = make(in, (struct page_options){.title = "</title><script>"});
    has(page, "data-name=\"&lt;b&gt;&amp;&quot;&#39;\"");
    has(page, "data-name=\"{{title}}\"");
    has(page, "<title>&lt;/title&gt;&lt;script&gt;</title>");
    assert_int_equal(count(page, "<script"), 1);
    assert_null(strstr(page, "<b>"));
    assert_null(strstr(page, "<img src=x"));
    has(page, "&lt;img src=x&gt;, 1 samples a pixel: 1 s, flip 0.5 (0.25 to 0.75)");
    free(page);
}

static void test_without_a_reference_there_are_no_error_maps(void **state) {
    (void)state;
    char in[128];
    start("no-reference", in);
    write_picture(in, "a.exr", WIDTH, 0.5f, 0);
    write_picture(in, "b.exr", WIDTH, 0.25f, 0);
    char *page = make(in, (struct page_options){0});
    assert_int_equal(count(page, "class=\"shown\""), 2);
    assert_int_equal(count(page, "class=\"error\""), 0);
    assert_null(strstr(page, "mrse &"));
    assert_null(strstr(page, "class=\"legend\""));
    has(page, "There is no reference");
    has(page, "data-left=\"0\" data-right=\"1\"");
    free(page);
}

static void test_a_named_reference_is_no_picture_of_its_own(void **state) {
    (void)state;
    char in[128], path[256], page_path[256];
    start("named", in);
    write_picture(in, "a.exr", WIDTH, 0.5f, 0);
    write_picture(in, "truth.exr", WIDTH, 0.25f, 0);
    path_of("named/truth.exr", path);
    path_of("elsewhere.html", page_path);
    char *page = make(in, (struct page_options){.reference = path, .output = page_path});
    assert_int_equal(count(page, "class=\"shown\""), 2);
    assert_int_equal(count(page, "class=\"error\""), 1);
    free(page);
}

static void test_large_pictures_are_shown_smaller_and_judged_in_full(void **state) {
    (void)state;
    char in[128];
    start("large", in);
    write_picture(in, "a.exr", 300, 0.75f, 0);
    write_picture(in, "reference.exr", 300, 0.5f, 0);
    char *page = make(in, (struct page_options){.max_width = 70});
    has(page, "width=\"70\" height=\"4\"");
    has(page, "shown as 70&times;4");
    has(page, "<td><strong>0.2403</strong></td>"); /* all pixels but one of 4800 */
    free(page);
}

static void test_areas_are_averaged(void **state) {
    (void)state;
    /* three pixels to two: the middle one belongs to both by half */
    float plane[3] = {0, 0.5f, 1}, *planes[3] = {plane, plane, plane};
    void *png;
    size_t bytes;
    struct fewray_image *image;
    assert_int_equal(page_show(planes, 3, 1, 0, (struct page_size){2, 1}, &png, &bytes, NULL), 0);
    assert_int_equal(fewray_image_read_memory("shown", png, bytes, &image, NULL), 0);
    assert_int_equal(image->width, 2);
    assert_int_equal(image->bytes[0], 113); /* sRGB of 1 / 6 */
    assert_int_equal(image->bytes[3], 235); /* of 5 / 6 */
    fewray_image_destroy(&image);
    free(png);
}

static void test_infinities_and_nan_are_errors_as_the_metrics_count_them(void **state) {
    (void)state;
    float x[4] = {NAN, INFINITY, 1, 1}, r[4] = {0, 1, NAN, 1};
    float *xs[3] = {x, x, x}, *rs[3] = {r, r, r};
    uint8_t palette[256 * 3];
    void *png;
    size_t bytes;
    struct fewray_image *image;
    for (int i = 0; i < 256; i++)
        memset(palette + 3 * i, i, 3);
    assert_int_equal(
        page_error_map(xs, rs, 4, 1, (struct page_size){4, 1}, palette, &png, &bytes, NULL), 0);
    assert_int_equal(fewray_image_read_memory("map", png, bytes, &image, NULL), 0);
    assert_int_equal(image->bytes[0], 255); /* 1 / 0.01, beyond the scale */
    assert_near(image->bytes[image->channels], 234.5,
                1); /* 4 / 1.01: log(39600) / log(1e5) of the scale */
    assert_int_equal(image->bytes[2 * image->channels], 0); /* nothing to judge by */
    assert_int_equal(image->bytes[3 * image->channels], 0); /* no error */
    fewray_image_destroy(&image);
    free(png);
}

static void test_the_same_folder_gives_the_same_bytes(void **state) {
    (void)state;
    char in[128];
    start("again", in);
    write_picture(in, "a.exr", WIDTH, 0.5f, 0.25f);
    write_picture(in, "reference.exr", WIDTH, 0.5f, 0);
    char *first = make(in, (struct page_options){0}), *second = make(in, (struct page_options){0});
    assert_string_equal(first, second);
    free(first);
    free(second);
}

static void test_a_folder_that_gives_no_page_is_one_error(void **state) {
    (void)state;
    char in[128];
    start("empty", in);
    expect_failure(in, FEWRAY_ERROR_ARGUMENT, "empty");
    write_picture(in, "reference.exr", WIDTH, 0.5f, 0);
    expect_failure(in, FEWRAY_ERROR_ARGUMENT, "nothing to compare");
    write_picture(in, "a.exr", WIDTH, 0.5f, 0);
    write_picture(in, "b.exr", WIDTH + 1, 0.5f, 0);
    expect_failure(in, FEWRAY_ERROR_ARGUMENT, "b.exr");
    write_text(in, "a.json", "{\n\n,");
    expect_failure(in, FEWRAY_ERROR_FORMAT, "a.json");
    write_text(in, "bench.json", "[]");
    expect_failure(in, FEWRAY_ERROR_FORMAT, "bench.json");
    struct page_options options = {.folder = "not/there", .max_width = 1920};
    assert_int_equal(page_write(&options, NULL), FEWRAY_ERROR_IO);
}

static void test_a_bench_alone_gives_curves(void **state) {
    (void)state;
    char in[128];
    start("bench", in);
    write_text(
        in, "bench.json",
        "{\"settings\": {\"scene\": \"s.xml\", \"seeds\": 3}, \"machine\": {\"threads\": 2, "
        "\"cpu\": "
        "\"a CPU\"}, \"methods\": [{\"method\": \"PT\", \"points\": [{\"spp\": 1, \"work_s\": 1, "
        "\"mrse_trimmed\": {\"median\": 1, \"least\": 0.5, \"most\": 2}}, {\"spp\": 4, "
        "\"work_s\": 4, \"mrse_trimmed\": {\"median\": 0.25, \"least\": -1, \"most\": "
        "null}}, {\"spp\": 16, \"work_s\": 1e999}, {}, 7]}, \"text\"]}");
    char path[512];
    struct fewray_error error;
    const struct page_options options = {.folder = in, .max_width = 1920};
    assert_int_equal(page_write(&options, &error), FEWRAY_ERROR_FORMAT); /* 1e999 isn't JSON's */
    write_text(
        in, "bench.json",
        "{\"settings\": {\"scene\": \"s.xml\", \"seeds\": 3}, \"machine\": {\"threads\": 2, "
        "\"cpu\": "
        "\"a CPU\"}, \"methods\": [{\"method\": \"PT\", \"points\": [{\"spp\": 1, \"work_s\": 1, "
        "\"mrse_trimmed\": {\"median\": 1, \"least\": 0.5, \"most\": 2}}, {\"spp\": 4, "
        "\"work_s\": 4, \"mrse_trimmed\": {\"median\": 0.25, \"least\": -1, \"most\": "
        "null}}, {}, 7]}, \"text\"]}");
    char *page = make(in, (struct page_options){0});
    assert_int_equal(count(page, "class=\"point "), 2);
    assert_int_equal(count(page, "class=\"spread "), 1);
    assert_int_equal(count(page, "<svg viewBox=\"0 0 420 340\""), 1);
    has(page, "fewray: path tracing, 4 samples a pixel: 4 s");
    assert_null(strstr(page, "class=\"shown\""));
    assert_null(strstr(page, "nan"));
    free(page);
    snprintf(path, sizeof path, "%s/report.html", in);
    assert_int_equal(access(path, F_OK), 0);
}

static void test_a_bench_keeps_pictures_that_a_report_takes(void **state) {
    (void)state;
    char in[128], path[256];
    start("kept", in);
    write_picture(in, "given.exr", WIDTH, 0.5f, 0);
    path_of("kept/given.exr", path);
    struct bench_settings settings = {
        .scene_path = "s.xml", .reference_path = path, .keep_spp = 4, .keep_folder = in};
    struct fewray_frame *frame = NULL;
    assert_int_equal(fewray_frame_read_exr(path, &frame, NULL), 0);
    struct bench_row row = {
        .method = BENCH_GUIDED, .spp = 4, .seed = 1, .render_s = 2, .guide = "on"};
    assert_int_equal(bench_keep_reference(&settings, frame, NULL), 0);
    assert_int_equal(bench_keep_picture(&settings, &row, frame, NULL), 0);
    row.seed = 2;
    row.method = BENCH_PT;
    assert_int_equal(bench_keep_picture(&settings, &row, frame, NULL), 0);
    fewray_frame_destroy(&frame);
    assert_int_equal(unlink(path), 0);
    char *page = make(in, (struct page_options){0});
    assert_int_equal(count(page, "class=\"shown\""), 2); /* and the reference; not seed 2's */
    has(page, "<td>4</td><td>2</td>");
    has(page, "guided, scene s.xml, seed 1");
    free(page);
}

static void test_the_command_line_is_quoted_as_a_shell_takes_it(void **state) {
    (void)state;
    char text[4096], tiny[4];
    assert_true(origin_command(text, sizeof text));
    assert_int_equal(strncmp(text, "test_report", 11), 0);
    assert_false(origin_command(tiny, sizeof tiny));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pictures_are_there_once_with_metrics_and_maps),
        cmocka_unit_test(test_nothing_is_loaded_from_anywhere),
        cmocka_unit_test(test_names_are_text_whatever_they_hold),
        cmocka_unit_test(test_without_a_reference_there_are_no_error_maps),
        cmocka_unit_test(test_a_named_reference_is_no_picture_of_its_own),
        cmocka_unit_test(test_large_pictures_are_shown_smaller_and_judged_in_full),
        cmocka_unit_test(test_areas_are_averaged),
        cmocka_unit_test(test_infinities_and_nan_are_errors_as_the_metrics_count_them),
        cmocka_unit_test(test_the_same_folder_gives_the_same_bytes),
        cmocka_unit_test(test_a_folder_that_gives_no_page_is_one_error),
        cmocka_unit_test(test_a_bench_alone_gives_curves),
        cmocka_unit_test(test_a_bench_keeps_pictures_that_a_report_takes),
        cmocka_unit_test(test_the_command_line_is_quoted_as_a_shell_takes_it),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
