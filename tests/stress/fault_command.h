/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_FAULT_COMMAND_H
#define FEWRAY_TESTS_FAULT_COMMAND_H

/* Runs the command with something wrong (fault_preload.c, resource limits), and checks what it
 * leaves. Every program that includes this works in a folder of its own. */

#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/unit/sanitized.h"
#include "tests/unit/scratch_folder.h"

#define SCENE EXAMPLES "/cornell-box.xml"
/* A picture of 16x16 pixels in some ten milliseconds. */
#define RENDER_PLAIN "render " SCENE " --width 16 --spp 2 --threads 2 --guide off --denoise off"
#define RENDER_WHOLE "render " SCENE " --width 16 --spp 2 --threads 2 --pilot off"

/* Sanitizers want to be the first library and own the allocator: nothing is preloaded with them. */
#define FAULT_PRELOADS !SANITIZED

/* Beyond this many seconds a command hangs: the slowest takes a tenth of one. */
enum { HANG_SECONDS = 60 };

struct outcome {
    int code; /* exit code, or minus the signal that ended it */
    char messages[4096];
};

struct limit {
    int resource;
    rlim_t value;
};

static inline const char *in_folder(const char *name) {
    static char paths[4][256];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, 256, "%s/%s", folder, name);
    return path;
}

static inline size_t read_text(const char *path, char *text, size_t size) {
    FILE *file = fopen(path, "rb");
    const size_t got = file ? fread(text, 1, size - 1, file) : 0;
    text[got] = 0;
    if (file)
        fclose(file);
    return got;
}

static inline void write_text(const char *path, const char *text) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* Runs `fewray ARGUMENTS` in the folder. fault: a rule of fault_preload.c, or NULL; limit: NULL. */
static inline struct outcome run_command(const char *arguments, const char *fault,
                                         const struct limit *limit) {
    char line[4096], files[32] = "";
    struct outcome outcome;
    if (limit && limit->resource == RLIMIT_NOFILE) /* not of the shell, which opens files itself */
        snprintf(files, sizeof files, "ulimit -n %d;", (int)limit->value);
    snprintf(line, sizeof line, "exec > out.txt 2> err.txt < /dev/null; %s exec %s %s", files,
             FEWRAY_COMMAND, arguments);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        const struct rlimit both =
            limit ? (struct rlimit){limit->value, limit->value} : (struct rlimit){0};
        if (chdir(folder))
            _exit(99);
        if (limit && limit->resource == RLIMIT_FSIZE)
            signal(SIGXFSZ, SIG_DFL);
        if (limit && !files[0] && setrlimit((__rlimit_resource_t)limit->resource, &both))
            _exit(99);
        if (fault) {
            setenv("FEWRAY_FAULT", fault, 1);
            setenv("LD_PRELOAD", FAULT_LIBRARY, 1);
        }
        setenv("OMP_WAIT_POLICY", "passive", 1); /* many run at once on few cores */
        alarm(HANG_SECONDS);
        execl("/bin/sh", "sh", "-c", line, (char *)NULL);
        _exit(99);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    read_text(in_folder("err.txt"), outcome.messages, sizeof outcome.messages);
    return outcome;
}

/* How often the call happens in a run without fault. */
static inline int count_calls(const char *arguments, const char *call, const char *match) {
    char rule[128], text[32];
    snprintf(rule, sizeof rule, "%s 1 %s count calls.txt", call, match);
    const struct outcome outcome = run_command(arguments, rule, NULL);
    if (outcome.code)
        fail_msg("%s: exit %d: %s", arguments, outcome.code, outcome.messages);
    read_text(in_folder("calls.txt"), text, sizeof text);
    return atoi(text);
}

/* No temporary file may be left. */
static inline void expect_tidy(const char *what) {
    DIR *entries = opendir(folder);
    assert_non_null(entries);
    for (struct dirent *entry; (entry = readdir(entries));)
        if (!strncmp(entry->d_name, ".fewray", 7))
            fail_msg("%s: leaves %s", what, entry->d_name);
    closedir(entries);
}

/* Exit code 1 and one line that begins with fewray: and holds each of the two words, where given.
 */
static inline void expect_failure(const char *what, const struct outcome *outcome,
                                  const char *named, const char *reason) {
    const char *end = strchr(outcome->messages, '\n');
    if (outcome->code != 1)
        fail_msg("%s: exit %d instead of 1: %s", what, outcome->code, outcome->messages);
    if (strncmp(outcome->messages, "fewray: ", 8) || !end || end[1])
        fail_msg("%s: not one line: %s", what, outcome->messages);
    if ((named && !strstr(outcome->messages, named)) ||
        (reason && !strstr(outcome->messages, reason)))
        fail_msg("%s: doesn't say %s and %s: %s", what, named ? named : "", reason ? reason : "",
                 outcome->messages);
    expect_tidy(what);
}

static inline void expect_success(const char *arguments) {
    const struct outcome outcome = run_command(arguments, NULL, NULL);
    if (outcome.code)
        fail_msg("%s: exit %d: %s", arguments, outcome.code, outcome.messages);
    expect_tidy(arguments);
}

/* Makes the folder, with a picture and two parts of one. */
static inline int make_inputs(void **state) {
    if (make_folder(state))
        return -1;
    expect_success(RENDER_PLAIN " -o in.exr");
    mkdir(in_folder("pictures"), 0777);
    expect_success(RENDER_PLAIN " -o pictures/in.exr");
    expect_success(RENDER_PLAIN " --part 1/2 -o part-1.exr");
    expect_success(RENDER_PLAIN " --part 2/2 -o part-2.exr");
    return 0;
}

#endif
