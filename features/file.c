/* SPDX-License-Identifier: Apache-2.0 */
/* Files that appear whole or not at all: written beside, then renamed. */
#include "features/features_private.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Renaming onto a device or a pipe would replace it by a plain file. */
int fewray_check_replaceable(const char *path, struct fewray_error *error) {
    struct stat info;
    if (stat(path, &info) != 0 || S_ISREG(info.st_mode))
        return FEWRAY_OK;
    return fewray_fail(error, FEWRAY_ERROR_IO, path, 0,
                       "isn't a regular file, give another name for the output");
}

int fewray_commit_file(const char *temporary, const char *path, struct fewray_error *error) {
    const int status = fewray_check_replaceable(path, error);
    if (status != FEWRAY_OK) {
        fewray_discard_file(temporary);
        return status;
    }
    if (rename(temporary, path) == 0) {
        temporary_forget(temporary);
        return FEWRAY_OK;
    }
    const int reason = errno;
    fewray_discard_file(temporary);
    return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't write the file: %s",
                       strerror(reason));
}

int file_create_temporary(const char *path, char **temporary, struct fewray_error *error) {
    *temporary = NULL;
    if (!path[0])
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0, "the output file has no name");
    const int status = fewray_check_replaceable(path, error);
    if (status != FEWRAY_OK)
        return status;
    char *name = fewray_temporary_name(path);
    if (!name)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    const int fd = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0) {
        const int reason = errno;
        temporary_forget(name);
        free(name);
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't write into the folder: %s",
                           strerror(reason));
    }
    *temporary = name;
    return fd;
}

int file_check_readable(const char *path, uint64_t *size, struct fewray_error *error) {
    struct stat info;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0 || fstat(fd, &info) != 0) {
        const int reason = errno;
        if (fd >= 0)
            close(fd);
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't open the file: %s",
                           strerror(reason));
    }
    close(fd);
    if (!S_ISREG(info.st_mode))
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "isn't a regular file");
    *size = (uint64_t)info.st_size;
    return FEWRAY_OK;
}

bool file_write_all(int fd, const void *data, size_t size, int64_t offset) {
    const char *rest = data;
    while (size > 0) {
        const ssize_t n =
            offset < 0 ? write(fd, rest, size) : pwrite(fd, rest, size, (off_t)offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0) {
            errno = n == 0 ? ENOSPC : errno;
            return false;
        }
        rest += n;
        size -= (size_t)n;
        offset = offset < 0 ? offset : offset + n;
    }
    return true;
}

int fewray_write_file(const char *path, const void *data, size_t size, struct fewray_error *error) {
    char *temporary = NULL;
    const int fd = file_create_temporary(path, &temporary, error);
    if (fd < 0)
        return fd;
    int reason = file_write_all(fd, data, size, -1) ? 0 : errno;
    if (close(fd) != 0 && !reason)
        reason = errno;
    int status;
    if (reason) {
        fewray_discard_file(temporary);
        status = fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't write the file: %s",
                             strerror(reason));
    } else {
        status = fewray_commit_file(temporary, path, error);
    }
    free(temporary);
    return status;
}
