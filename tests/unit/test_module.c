/* SPDX-License-Identifier: Apache-2.0 */
/* Modules: found beside the program, told by one line where they are missing. */
#include "features/module.h"

#include <setjmp.h>
#include <stdarg.h>
/* cmocka wants the three above first */
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void test_a_module_is_found_from_any_directory(void **state) {
    (void)state;
    struct fewray_error error = {0};
    assert_int_equal(chdir("/"), 0);
    const char *version = fewray_module_symbol("image", "fewray_module_version", &error);
    assert_string_equal(error.what, "");
    assert_non_null(version);
    assert_ptr_equal(fewray_module_symbol("image", "fewray_module_version", &error), version);
}

static void need_failure(const char *module, const char *symbol, const char *said) {
    struct fewray_error error = {0};
    assert_null(fewray_module_symbol(module, symbol, &error));
    assert_non_null(strstr(error.what, said));
    assert_null(strchr(error.what, '\n'));
    assert_null(fewray_module_symbol(module, symbol, NULL));
}

static void test_a_missing_module_is_named_in_one_line(void **state) {
    (void)state;
    need_failure("nowhere", "anything", "fewray_nowhere.so is missing");
    need_failure("image", "no_such_symbol", "fewray_image.so");
}

/* A folder with a file that is no shared object, as the current directory and by the variable. */
static void test_only_an_absolute_path_is_searched(void **state) {
    (void)state;
    char folder[] = "/tmp/fewray-test-module-XXXXXX";
    assert_non_null(mkdtemp(folder));
    assert_int_equal(chdir(folder), 0);
    FILE *file = fopen("fewray_broken.so", "w");
    assert_non_null(file);
    assert_true(fputs("not a module", file) >= 0 && fclose(file) == 0);
    need_failure("broken", "anything", "is missing");
    setenv("FEWRAY_MODULE_PATH", ".", 1);
    need_failure("broken", "anything", "is missing");
    setenv("FEWRAY_MODULE_PATH", folder, 1);
    need_failure("broken", "anything", "can't be opened");
    unsetenv("FEWRAY_MODULE_PATH");
    unlink("fewray_broken.so");
    assert_int_equal(chdir("/"), 0);
    assert_int_equal(rmdir(folder), 0);
}

static void test_threads_open_a_module_together(void **state) {
    (void)state;
    int opened = 0;
#pragma omp parallel for num_threads(8) reduction(+ : opened)
    for (int i = 0; i < 64; i++)
        opened += fewray_module_symbol("image", "fewray_image_module", NULL) != NULL;
    assert_int_equal(opened, 64);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_threads_open_a_module_together),
        cmocka_unit_test(test_a_module_is_found_from_any_directory),
        cmocka_unit_test(test_a_missing_module_is_named_in_one_line),
        cmocka_unit_test(test_only_an_absolute_path_is_searched),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
