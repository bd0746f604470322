/* SPDX-License-Identifier: Apache-2.0 */
/* Processes that are killed, and disks that are full: the last whole checkpoint is there, and gives
 * the picture of a render that nothing happened to, to the byte. */

#include "checkpoint_job.h"

#include <errno.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>

#include "pipeline/checkpoint.h"

/* What the child is told: which folder, whether guided, the tile that it dies after. */
enum { CHILD_ARGUMENTS = 5 };

static struct fewray_job crash_job(bool guided, const char *exr, const char *checkpoint) {
    struct fewray_job job = small_job(exr, checkpoint);
    job.guided = guided;
    job.checkpoint_interval = 0; /* after every tile */
    job.settings.threads = 2;
    return job;
}

static void render_whole(bool guided) {
    struct fewray_job job = crash_job(guided, scratch_name("whole.exr"), NULL);
    assert_int_equal(fewray_job_run(&job, NULL, NULL, NULL), FEWRAY_OK);
}

/* --- a process that dies */

static void die_at(void *user, const char *phase, double part) {
    struct stopper *stopper = user;
    stop_at(stopper, phase, part);
    if (stopper->cancel)
        kill(getpid(), SIGKILL);
}

static int child(char **arguments) {
    snprintf(scratch_folder, sizeof scratch_folder, "%s", arguments[2]);
    struct stopper stopper = {.calls = atoi(arguments[4])};
    struct fewray_job job =
        crash_job(atoi(arguments[3]), scratch_name("resumed.exr"), scratch_name("state"));
    job.settings.progress = die_at;
    job.settings.progress_user = &stopper;
    fewray_job_run(&job, NULL, NULL, NULL);
    return 0; /* it lived too long */
}

static void run_child_until_killed(bool guided, int tiles) {
    char count[16];
    snprintf(count, sizeof count, "%d", tiles);
    const pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        execl("/proc/self/exe", "child", "--child", scratch_folder, guided ? "1" : "0", count,
              (char *)NULL);
        _exit(127);
    }
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
}

static const struct {
    bool guided;
    int tiles; /* after which it dies; two threads, so that the file holds at least 2 fewer */
} DEATHS[] = {{false, 3}, {false, 7}, {true, 3}, {true, 6}, {true, 10}, {true, GUIDED_TILES}};

static void test_a_killed_process_loses_no_more_than_since_the_last_checkpoint(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof DEATHS / sizeof *DEATHS; i++) {
        struct fewray_run_stats stats;
        struct fewray_error error = {0};
        if (i == 0 || DEATHS[i].guided != DEATHS[i - 1].guided)
            render_whole(DEATHS[i].guided);
        run_child_until_killed(DEATHS[i].guided, DEATHS[i].tiles);
        assert_false(exists(scratch_name("resumed.exr")));
        struct fewray_job job =
            crash_job(DEATHS[i].guided, scratch_name("resumed.exr"), scratch_name("state"));
        job.must_resume = true;
        job.settings.threads = 3;
        if (fewray_job_run(&job, NULL, &stats, &error))
            fail_msg("killed after tile %d: %s", DEATHS[i].tiles, error.what);
        assert_int_equal(stats.resumes, 1);
        assert_true(stats.resumed_spp > 0 && stats.earlier_s > 0);
        if (!same_files(scratch_name("whole.exr"), scratch_name("resumed.exr")))
            fail_msg("killed after tile %d: another picture", DEATHS[i].tiles);
        unlink(scratch_name("resumed.exr"));
    }
}

/* --- the command */

static pid_t start_command(const char *const arguments[]) {
    const pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        if (!freopen(scratch_name("messages"), "w", stderr))
            _exit(126);
        execv(FEWRAY_COMMAND, (char *const *)arguments);
        _exit(127);
    }
    return pid;
}

static int end_command(pid_t pid, char *messages, size_t size) {
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    FILE *file = fopen(scratch_name("messages"), "r");
    assert_non_null(file);
    messages[fread(messages, 1, size - 1, file)] = 0;
    fclose(file);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/* The same command line goes on with what a killed process left. */
static void test_the_command_goes_on_with_a_killed_render(void **state) {
    (void)state;
    char messages[2000], exr[256], checkpoint[256];
    strcpy(exr, scratch_name("resumed.exr"));
    strcpy(checkpoint, scratch_name("state"));
    const char *const arguments[] = {"fewray",       "render",   SCENE,      "-o",        exr,
                                     "--width",      "18",       "--height", "17",        "--spp",
                                     "20",           "--seed",   "7",        "--pilot",   "off",
                                     "--denoise",    "off",      "--float",  "--threads", "1",
                                     "--checkpoint", checkpoint, NULL};
    render_whole(true);
    run_child_until_killed(true, 10);
    const int code = end_command(start_command(arguments), messages, sizeof messages);
    if (code || !strstr(messages, "resumed at ") || !strstr(messages, "of 20 samples a pixel\n"))
        fail_msg("exit %d: %s", code, messages);
    assert_true(same_files(scratch_name("whole.exr"), exr));
    assert_false(exists(checkpoint));
}

/* SIGTERM, as a queue sends it, while there are years of work left: waits for the first checkpoint
 * itself, not for a time. */
static void test_a_signal_leaves_a_checkpoint_and_the_picture_so_far(void **state) {
    (void)state;
    char messages[2000], exr[256], checkpoint[256];
    strcpy(exr, scratch_name("far.exr"));
    strcpy(checkpoint, scratch_name("far"));
    const char *const arguments[] = {"fewray", "render",       SCENE,      "-o",
                                     exr,      "--width",      "30",       "--height",
                                     "20",     "--spp",        "65536",    "--threads",
                                     "1",      "--denoise",    "off",      "--checkpoint-every",
                                     "1ms",    "--checkpoint", checkpoint, NULL};
    const pid_t pid = start_command(arguments);
    const struct timespec moment = {.tv_nsec = 2000000};
    while (!exists(checkpoint) && waitpid(pid, NULL, WNOHANG) == 0)
        nanosleep(&moment, NULL);
    assert_int_equal(kill(pid, SIGTERM), 0);
    const int code = end_command(pid, messages, sizeof messages);
    if (code != 1 || !strstr(messages, "go on with --resume"))
        fail_msg("exit %d: %s", code, messages);
    struct checkpoint_file file;
    struct fewray_frame *frame = NULL;
    assert_int_equal(checkpoint_open(checkpoint, true, &file, NULL), FEWRAY_OK);
    assert_true(file.info.samples > 0 && file.info.samples < 65536);
    checkpoint_close(&file);
    assert_int_equal(fewray_frame_read_exr(exr, &frame, NULL), FEWRAY_OK);
    fewray_frame_destroy(&frame);
}

/* --- a full disk */

/* The limit on files' sizes stands in for a disk that is full: writing fails with a reason, whoever
 * runs the test. */
static void limit_files(rlim_t bytes) {
    struct rlimit limit;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = bytes < limit.rlim_max ? bytes : limit.rlim_max;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

struct full_disk {
    int tiles;
    double samples_before,
        samples_during; /* of the file, when the disk fills and before it frees */
    int notes;
    char note[700];
};

static double samples_in(const char *path) {
    struct checkpoint_file file;
    assert_int_equal(checkpoint_open(path, true, &file, NULL), FEWRAY_OK);
    checkpoint_close(&file);
    return file.info.samples;
}

/* Full from the 5th to the 9th tile. */
static void fill_disk(void *user, const char *phase, double part) {
    struct full_disk *disk = user;
    if (strcmp(phase, "render") || part == 0)
        return;
    disk->tiles++;
    if (disk->tiles == 5) {
        disk->samples_before = samples_in(scratch_name("state"));
        limit_files(1000);
    } else if (disk->tiles == 9) {
        disk->samples_during = samples_in(scratch_name("state"));
        limit_files(RLIM_INFINITY);
    }
}

static void note_fault(void *user, const char *text) {
    struct full_disk *disk = user;
    disk->notes++;
    snprintf(disk->note, sizeof disk->note, "%s", text);
}

static void test_a_full_disk_is_told_once_and_costs_a_checkpoint_alone(void **state) {
    (void)state;
    struct fewray_run_stats stats;
    struct full_disk disk = {.tiles = 0};
    signal(SIGXFSZ, SIG_IGN);
    render_whole(true);
    struct fewray_job job = crash_job(true, scratch_name("resumed.exr"), scratch_name("state"));
    job.settings.threads = 1;
    job.settings.progress = fill_disk;
    job.settings.progress_user = &disk;
    job.note = note_fault;
    job.note_user = &disk;
    assert_int_equal(fewray_job_run(&job, NULL, &stats, NULL), FEWRAY_OK);
    assert_int_equal(disk.notes, 1);
    assert_non_null(strstr(disk.note, strerror(EFBIG)));
    assert_true(disk.samples_before > 0 && disk.samples_during == disk.samples_before);
    /* one after each of the look's and the rest's tiles, but those of the full disk */
    assert_int_equal(stats.checkpoints, GUIDED_TILES - 4);
    assert_true(same_files(scratch_name("whole.exr"), scratch_name("resumed.exr")));
}

/* A folder takes the picture's place at the last moment. */
static void block_output(void *user, const char *phase, double part) {
    (void)part;
    if (!strcmp(phase, "write"))
        mkdir(user, 0777);
}

static void test_a_picture_that_cannot_be_written_costs_no_sample(void **state) {
    (void)state;
    struct fewray_run_stats stats;
    render_whole(true);
    struct fewray_job job = crash_job(true, scratch_name("blocked.exr"), scratch_name("state"));
    job.checkpoint_interval = 300; /* none before the fault */
    job.settings.progress = block_output;
    job.settings.progress_user = (void *)job.outputs.exr;
    assert_int_equal(fewray_job_run(&job, NULL, NULL, NULL), FEWRAY_ERROR_IO);
    assert_int_equal(rmdir(job.outputs.exr), 0);
    job.settings.progress = NULL;
    job.must_resume = true;
    assert_int_equal(fewray_job_run(&job, NULL, &stats, NULL), FEWRAY_OK);
    assert_true(stats.resumed_spp == SPP);
    assert_true(same_files(scratch_name("whole.exr"), job.outputs.exr));
}

int main(int count, char **arguments) {
    if (count == CHILD_ARGUMENTS && !strcmp(arguments[1], "--child"))
        return child(arguments);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_killed_process_loses_no_more_than_since_the_last_checkpoint),
        cmocka_unit_test(test_the_command_goes_on_with_a_killed_render),
        cmocka_unit_test(test_a_signal_leaves_a_checkpoint_and_the_picture_so_far),
        cmocka_unit_test(test_a_picture_that_cannot_be_written_costs_no_sample),
        cmocka_unit_test(test_a_full_disk_is_told_once_and_costs_a_checkpoint_alone),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
