/* SPDX-License-Identifier: Apache-2.0 */
/* A whole file in memory. It isn't mapped: a mapped file that another program cuts off ends the
 * process by SIGBUS. */

#include "guide/scene/file_bytes.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int fail_io(struct fewray_error *error, const char *path, int code) {
    return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't read the file: %s", strerror(code));
}

/* Opens a regular file and tells its size. */
static int open_file(const char *path, int *descriptor, size_t *size, struct fewray_error *error) {
    struct stat info;
    *descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (*descriptor < 0)
        return fail_io(error, path, errno);
    int code = fstat(*descriptor, &info) ? errno : S_ISREG(info.st_mode) ? 0 : EINVAL;
    if (S_ISDIR(info.st_mode))
        code = EISDIR;
    if (code) {
        close(*descriptor);
        return fail_io(error, path, code);
    }
    *size = (size_t)info.st_size;
    if (*size == 0) {
        close(*descriptor);
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0, "the file is empty");
    }
    return FEWRAY_OK;
}

int file_check_regular(const char *path, struct fewray_error *error) {
    struct stat info;
    if (stat(path, &info) || S_ISREG(info.st_mode))
        return FEWRAY_OK;
    return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "isn't a regular file");
}

int file_read(const char *path, struct file_bytes *out, struct fewray_error *error) {
    int descriptor;
    *out = (struct file_bytes){0};
    int status = open_file(path, &descriptor, &out->size, error);
    if (status)
        return status;
    out->data = malloc(out->size + 1);
    if (!out->data) {
        close(descriptor);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    }
    size_t done = 0;
    while (done < out->size) {
        ssize_t got = read(descriptor, out->data + done, out->size - done);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            status = fail_io(error, path, errno);
        else if (got == 0)
            status = fewray_fail(error, FEWRAY_ERROR_IO, path, 0,
                                 "the file became shorter while it was read");
        if (status)
            break;
        done += (size_t)got;
    }
    close(descriptor);
    out->data[done] = 0;
    if (status)
        file_free(out);
    return status;
}

void file_free(struct file_bytes *file) {
    free(file->data);
    *file = (struct file_bytes){0};
}
