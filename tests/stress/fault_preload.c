/* SPDX-License-Identifier: Apache-2.0 */
/* Preloaded into the command: makes one kind of call fail, or something happen in it, by the rule
 * in FEWRAY_FAULT, "CALL FIRST MATCH ACTION [ARGUMENT]":
 *   CALL    open, read, write, close, rename, thread (pthread_create), parallel (OpenMP region)
 *   FIRST   the number, from 1, of the call among those whose file's name holds MATCH ("-": any)
 *   ACTION  fail ERRNO   this call and all later ones fail
 *           signal NUMBER, signals NUMBER   raised once or twice within this call, which goes on
 *           remove, halve   the file is removed, or cut off at half, before this call
 *           count FILE   writes the number of such calls into FILE at the end */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

static struct {
    char call[16], match[64], action[16], argument[256];
    int first;
} rule;
static atomic_int calls;

/* What the dynamic linker would have found without this library. */
#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

__attribute__((constructor)) static void read_rule(void) {
    const char *text = getenv("FEWRAY_FAULT");
    if (text && sscanf(text, "%15s %d %63s %15s %255s", rule.call, &rule.first, rule.match,
                       rule.action, rule.argument) < 4)
        rule.call[0] = 0;
}

__attribute__((destructor)) static void write_count(void) {
    if (strcmp(rule.action, "count"))
        return;
    FILE *file = NEXT(fopen)(rule.argument, "w");
    if (file) {
        fprintf(file, "%d\n", atomic_load(&calls));
        fclose(file);
    }
}

static void change_file(const char *path) {
    struct stat info;
    if (!strcmp(rule.action, "remove"))
        unlink(path);
    else if (!strcmp(rule.action, "halve") && !stat(path, &info) &&
             truncate(path, info.st_size / 2))
        abort();
}

/* Whether this call has to fail, with errno. path: of the file; NULL where the call has none. */
static bool strike(const char *call, const char *path) {
    if (strcmp(call, rule.call) || (rule.match[0] != '-' && (!path || !strstr(path, rule.match))))
        return false;
    const int number = 1 + atomic_fetch_add(&calls, 1);
    if (number >= rule.first && !strcmp(rule.action, "fail")) {
        errno = atoi(rule.argument);
        return true;
    }
    if (number != rule.first)
        return false;
    if (!strncmp(rule.action, "signal", 6)) {
        raise(atoi(rule.argument));
        if (rule.action[6] == 's')
            raise(atoi(rule.argument));
    } else if (path) {
        change_file(path);
    }
    return false;
}

/* The same for a file that is open. */
static bool strike_descriptor(const char *call, int fd) {
    char link[64], path[4096];
    if (strcmp(call, rule.call))
        return false;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    const ssize_t length = readlink(link, path, sizeof path - 1);
    path[length > 0 ? length : 0] = 0;
    return strike(call, path);
}

static mode_t mode_of(int flags, va_list arguments) {
    return flags & (O_CREAT | O_TMPFILE) ? (mode_t)va_arg(arguments, int) : 0;
}

int open(const char *path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = mode_of(flags, arguments);
    va_end(arguments);
    return strike("open", path) ? -1 : NEXT(open)(path, flags, mode);
}

int open64(const char *path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = mode_of(flags, arguments);
    va_end(arguments);
    return strike("open", path) ? -1 : NEXT(open64)(path, flags, mode);
}

/* --- streams, whose reads don't pass through read() here: one that matches a rule for reads gets
 * its own functions */

static ssize_t stream_read(void *cookie, char *buffer, size_t size) {
    if (strike_descriptor("read", fileno(cookie)))
        return -1;
    /* One page at a time, so that a file is read by several calls. */
    const size_t got = fread(buffer, 1, size < 4096 ? size : 4096, cookie);
    return got == 0 && ferror((FILE *)cookie) ? -1 : (ssize_t)got;
}

static int stream_seek(void *cookie, off64_t *place, int whence) {
    if (fseeko(cookie, *place, whence))
        return -1;
    *place = ftello(cookie);
    return 0;
}

static int stream_close(void *cookie) {
    return fclose(cookie);
}

static FILE *open_stream(FILE *(*really)(const char *, const char *), const char *path,
                         const char *mode) {
    if (strike("open", path))
        return NULL;
    FILE *file = really(path, mode);
    const bool read = !strcmp(rule.call, "read") && mode[0] == 'r' && strstr(path, rule.match);
    const cookie_io_functions_t functions = {
        .read = stream_read, .seek = stream_seek, .close = stream_close};
    return file && read ? fopencookie(file, mode, functions) : file;
}

FILE *fopen(const char *path, const char *mode) {
    return open_stream(NEXT(fopen), path, mode);
}

FILE *fopen64(const char *path, const char *mode) {
    return open_stream(NEXT(fopen64), path, mode);
}

/* --- descriptors */

ssize_t read(int fd, void *buffer, size_t size) {
    return strike_descriptor("read", fd) ? -1 : NEXT(read)(fd, buffer, size);
}

ssize_t pread(int fd, void *buffer, size_t size, off_t offset) {
    return strike_descriptor("read", fd) ? -1 : NEXT(pread)(fd, buffer, size, offset);
}

ssize_t pread64(int fd, void *buffer, size_t size, off64_t offset) {
    return strike_descriptor("read", fd) ? -1 : NEXT(pread64)(fd, buffer, size, offset);
}

ssize_t write(int fd, const void *buffer, size_t size) {
    return strike_descriptor("write", fd) ? -1 : NEXT(write)(fd, buffer, size);
}

ssize_t pwrite(int fd, const void *buffer, size_t size, off_t offset) {
    return strike_descriptor("write", fd) ? -1 : NEXT(pwrite)(fd, buffer, size, offset);
}

ssize_t pwrite64(int fd, const void *buffer, size_t size, off64_t offset) {
    return strike_descriptor("write", fd) ? -1 : NEXT(pwrite64)(fd, buffer, size, offset);
}

int close(int fd) {
    const bool fails = strike_descriptor("close", fd);
    const int reason = errno, result = NEXT(close)(fd);
    errno = fails ? reason : errno;
    return fails ? -1 : result;
}

int rename(const char *from, const char *to) {
    return strike("rename", to) ? -1 : NEXT(rename)(from, to);
}

int renameat2(int from_folder, const char *from, int to_folder, const char *to, unsigned flags) {
    return strike("rename", to) ? -1 : NEXT(renameat2)(from_folder, from, to_folder, to, flags);
}

/* --- threads */

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*work)(void *),
                   void *argument) {
    return strike("thread", NULL) ? errno
                                  : NEXT(pthread_create)(thread, attributes, work, argument);
}

/* GCC's OpenMP starts each parallel region by it. */
void GOMP_parallel(void (*work)(void *), void *data, unsigned threads, unsigned flags);

void GOMP_parallel(void (*work)(void *), void *data, unsigned threads, unsigned flags) {
    strike("parallel", NULL);
    NEXT(GOMP_parallel)(work, data, threads, flags);
}
