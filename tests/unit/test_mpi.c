/* SPDX-License-Identifier: Apache-2.0 */
/* The command under mpirun. Where mpirun, or the module that a build without MPI lacks, isn't there
 * these tests are skipped. */

#include "tests/unit/scratch_folder.h"

#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define SCENE  EXAMPLES "/window-room.xml"
#define MPIRUN "mpirun $MPIRUN_OPTIONS --oversubscribe "

/* Runs a shell line in the folder; errors gets what it wrote on stderr. Returns its exit code. */
static int run(const char *line, char *errors, size_t size) {
    char whole[2048];
    snprintf(whole, sizeof whole, "cd %s && { %s; } > out.txt 2> err.txt < /dev/null", folder,
             line);
    const int status = system(whole);
    snprintf(whole, sizeof whole, "%s/err.txt", folder);
    FILE *file = fopen(whole, "r");
    assert_non_null(file);
    errors[fread(errors, 1, size - 1, file)] = 0;
    fclose(file);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void expect_success(const char *line) {
    char errors[4096];
    if (run(line, errors, sizeof errors))
        fail_msg("%s: %s", line, errors);
}

/* One line of ours, whatever mpirun adds. */
static void expect_failure(const char *line, const char *named) {
    char errors[8192];
    int lines = 0;
    if (run(line, errors, sizeof errors) != 1)
        fail_msg("%s: didn't exit with 1: %s", line, errors);
    for (const char *at = errors; (at = strstr(at, "fewray: ")); at++)
        lines++;
    if (lines != 1 || !strstr(errors, named))
        fail_msg("%s: %d lines of ours, or none with %s: %s", line, lines, named, errors);
}

static void need_mpi(void) {
    if (system("command -v mpirun > /dev/null") || access(FEWRAY_MODULES "/fewray_mpi.so", R_OK))
        skip();
}

/* Maps are made, and refined at 4 samples a pixel. */
static void test_any_number_of_processes_and_threads_writes_the_file_of_one(void **state) {
    (void)state;
    need_mpi();
    static const struct { int processes, threads; } cases[] = {{1, 7}, {2, 7}, {3, 2}};
    static const char options[] = "--width 72 --spp 6 --pilot off --aovs direct,indirect";
    char line[1024];
    snprintf(line, sizeof line, "%s render " SCENE " -o one.exr %s --threads 1", FEWRAY_COMMAND,
             options);
    expect_success(line);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        snprintf(line, sizeof line, MPIRUN "-n %d %s render " SCENE " -o many.exr %s --threads %d",
                 cases[k].processes, FEWRAY_COMMAND, options, cases[k].threads);
        expect_success(line);
        expect_success("cmp one.exr many.exr && rm many.exr");
    }
}

static void test_a_failure_is_told_once_and_leaves_nothing(void **state) {
    (void)state;
    need_mpi();
    expect_failure(MPIRUN "-n 3 " FEWRAY_COMMAND " render nowhere.xml -o none.exr", "nowhere.xml");
    expect_failure(MPIRUN "-n 3 " FEWRAY_COMMAND " render " SCENE " -o none.exr --guide ppg",
                   "path guiding");
    /* in the second process alone */
    expect_failure(MPIRUN "-n 3 sh -c '[ $OMPI_COMM_WORLD_RANK = 1 ] && scene=nowhere.xml || "
                          "scene=" SCENE "; exec " FEWRAY_COMMAND
                          " render $scene -o none.exr --width 48'",
                   "nowhere.xml");
    expect_success("! ls none.exr");
}

/* Each would write the whole picture over the others'. */
static void test_without_the_module_several_processes_are_refused(void **state) {
    (void)state;
    expect_success("cp " FEWRAY_COMMAND " alone");
    expect_failure("OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=0 FEWRAY_MODULE_PATH= "
                   "./alone render " SCENE " -o none.exr --width 48",
                   "fewray_mpi.so");
    expect_success("! ls none.exr");
}

static int prepare(void **state) {
    setenv("OMPI_MCA_plm", "isolated", 1);                /* this machine alone: no ssh is needed */
    setenv("OMPI_MCA_odls_base_sigkill_timeout", "0", 1); /* of what a failure leaves: no second */
    if (geteuid() == 0)
        setenv("MPIRUN_OPTIONS", "--allow-run-as-root", 1); /* its variables differ by version */
    return make_folder(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any_number_of_processes_and_threads_writes_the_file_of_one),
        cmocka_unit_test(test_a_failure_is_told_once_and_leaves_nothing),
        cmocka_unit_test(test_without_the_module_several_processes_are_refused),
    };
    return cmocka_run_group_tests(tests, prepare, remove_folder);
}
