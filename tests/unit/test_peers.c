/* SPDX-License-Identifier: Apache-2.0 */
/* Talking with the peers' Python, whose place a shell script takes here: `sh FILE -c SCRIPT WISH`.
 */

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "check.h"
#include "pipeline/peers.h"

static char script_path[] = "/tmp/fewray-test-XXXXXX";

/* Makes the script that plays Python. */
static void play(const char *body) {
    FILE *file = fopen(script_path, "w");
    assert_non_null(file);
    fprintf(file, "#!/bin/sh\n%s\n", body);
    fclose(file);
    assert_int_equal(chmod(script_path, 0700), 0);
}

static int open_peers(struct peers **peers, struct peers_info *info, const volatile int *cancel,
                      struct fewray_error *error) {
    static const char *const defines[] = {"spp=4"};
    const struct peers_settings settings = {.python = script_path,
                                            .scene_path = "scene.xml",
                                            .defines = defines,
                                            .define_count = 1,
                                            .width = 4,
                                            .height = 3,
                                            .threads = 2,
                                            .cancel = cancel};
    return peers_open(&settings, peers, info, error);
}

#define HELLO "echo '{\"names\": \"X 1\", \"oidn\": true, \"load_s\": 1.5, \"compile_s\": 2}'\n"

static void test_peers_are_asked_and_answer(void **state) {
    (void)state;
    struct peers *peers;
    struct peers_info info;
    double seconds;
    play("case $3 in *'\"defines\":{\"spp\":\"4\"}'*) ;; *) exit 1;; esac\n" HELLO
         "read line; case $line in *'\"spp\":8'*) echo '{\"seconds\": 0.25}';; esac\n"
         "read line; echo '{\"error\": \"no such scene\"}'\n");
    assert_int_equal(open_peers(&peers, &info, NULL, NULL), FEWRAY_OK);
    assert_string_equal(info.names, "X 1");
    assert_true(info.oidn && info.load_s == 1.5 && info.compile_s == 2);
    assert_int_equal(peers_render(peers, 8, 1, false, NULL, &seconds, NULL), FEWRAY_OK);
    assert_near(seconds, 0.25, 0);
    struct fewray_error error;
    assert_int_not_equal(peers_render(peers, 8, 1, false, NULL, &seconds, &error), FEWRAY_OK);
    assert_non_null(strstr(error.what, "no such scene"));
    peers_close(&peers);
    assert_null(peers);
}

static void test_a_python_that_ends_tells_its_last_words(void **state) {
    (void)state;
    struct peers *peers;
    struct peers_info info;
    struct fewray_error error;
    play("echo Traceback >&2; echo 'SyntaxError: too old' >&2; exit 1");
    assert_int_not_equal(open_peers(&peers, &info, NULL, &error), FEWRAY_OK);
    assert_null(peers);
    assert_non_null(strstr(error.what, "SyntaxError: too old"));
    play("echo this is no JSON");
    assert_int_not_equal(open_peers(&peers, &info, NULL, &error), FEWRAY_OK);
    play(HELLO);
    double seconds;
    assert_int_equal(open_peers(&peers, &info, NULL, &error), FEWRAY_OK);
    assert_int_not_equal(peers_render(peers, 1, 1, false, NULL, &seconds, &error), FEWRAY_OK);
    peers_close(&peers);
}

static void test_waiting_for_peers_can_be_cancelled(void **state) {
    (void)state;
    const volatile int cancel = 1;
    struct peers *peers;
    struct peers_info info;
    play("exec sleep 60");
    assert_int_equal(open_peers(&peers, &info, &cancel, NULL), FEWRAY_ERROR_CANCELLED);
    assert_null(peers);
}

static int make_script(void **state) {
    (void)state;
    const int file = mkstemp(script_path);
    return file < 0 ? -1 : close(file);
}

static int remove_script(void **state) {
    (void)state;
    return unlink(script_path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_peers_are_asked_and_answer),
        cmocka_unit_test(test_a_python_that_ends_tells_its_last_words),
        cmocka_unit_test(test_waiting_for_peers_can_be_cancelled),
    };
    return cmocka_run_group_tests(tests, make_script, remove_script);
}
