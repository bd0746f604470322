/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_SCRATCH_FOLDER_H
#define FEWRAY_TESTS_SCRATCH_FOLDER_H

/* A folder for a group of tests' files, below the present one: set-up and tear-down for
 * cmocka_run_group_tests(). */

#include <stdio.h>

#include "tests/unit/check.h"

static char folder[] = "test-XXXXXX";

static inline int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static inline int remove_folder(void **state) {
    (void)state;
    char line[64];
    snprintf(line, sizeof line, "rm -r %s", folder);
    return system(line);
}

#endif
