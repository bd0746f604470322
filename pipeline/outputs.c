/* SPDX-License-Identifier: Apache-2.0 */
/* Output files are staged under temporary names and renamed together: a failure leaves none of
 * them. */

#include "pipeline/outputs.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "pipeline/clock.h"
#include "pipeline/stats.h"

enum { OUTPUT_MAX = 4 };

struct staged_file {
    const char *path;
    char *temporary;
};

static bool same_name(const char *a, const char *b) {
    return a && b && !strcmp(a, b);
}

bool outputs_clash(const struct fewray_outputs *outputs) {
    const char *const paths[OUTPUT_MAX] = {outputs->exr, outputs->png, outputs->stats,
                                           outputs->preview};
    for (int i = 0; i < OUTPUT_MAX; i++)
        for (int j = 0; j < i; j++)
            if (same_name(paths[i], paths[j]))
                return true;
    return false;
}

static int check_path(const char *path, struct fewray_error *error) {
    const int status = fewray_check_replaceable(path, error);
    if (status)
        return status;
    char *temporary = fewray_temporary_name(path);
    if (!temporary)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for a file name");
    const int file = open(temporary, O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    const int fault = errno;
    if (file >= 0)
        close(file);
    fewray_discard_file(temporary);
    free(temporary);
    return file >= 0 ? FEWRAY_OK
                     : fewray_fail(error, FEWRAY_ERROR_IO, path, 0,
                                   "can't be written: %s; check the folder and its permissions",
                                   strerror(fault));
}

int outputs_check(const struct fewray_outputs *outputs, struct fewray_error *error) {
    const char *const paths[OUTPUT_MAX] = {outputs->exr, outputs->png, outputs->stats,
                                           outputs->preview};
    int status = FEWRAY_OK;
    for (int i = 0; i < OUTPUT_MAX && !status; i++)
        if (paths[i])
            status = check_path(paths[i], error);
    return status;
}

/* Names the temporary file of the next output in list, or returns NULL without memory. */
static const char *stage(struct staged_file *list, int *count, const char *path,
                         struct fewray_error *error) {
    char *temporary = fewray_temporary_name(path);
    if (!temporary)
        fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for a file name");
    else
        list[(*count)++] = (struct staged_file){path, temporary};
    return temporary;
}

static int stage_png(const char *path, const struct fewray_frame *frame, struct staged_file *list,
                     int *count, struct fewray_error *error) {
    const char *temporary = path ? stage(list, count, path, error) : NULL;
    if (!path)
        return FEWRAY_OK;
    return temporary ? fewray_frame_write_png(frame, temporary, error) : FEWRAY_ERROR_MEMORY;
}

static int stage_exr(const struct fewray_outputs *outputs, const struct fewray_frame *frame,
                     const struct kept_file *kept, const char *temporary,
                     struct fewray_run_stats *stats, struct fewray_error *error) {
    const int status = kept ? fewray_exr_rewrite(kept->source, kept->changes, kept->change_count,
                                                 outputs->float32, temporary, error)
                            : fewray_frame_write_exr(frame, temporary, outputs->float32, error);
    if (kept ? kept->half : !outputs->float32)
        fewray_frame_half_losses(frame, &stats->clipped, &stats->lost);
    return status;
}

static int stage_all(const struct fewray_outputs *outputs, const struct fewray_frame *frame,
                     const struct kept_file *kept, struct fewray_run_stats *stats, double start,
                     struct staged_file *list, int *count, struct fewray_error *error) {
    double lap = clock_seconds();
    int status = FEWRAY_OK;
    const char *temporary;
    if (outputs->exr) {
        if (!(temporary = stage(list, count, outputs->exr, error)))
            return FEWRAY_ERROR_MEMORY;
        status = stage_exr(outputs, frame, kept, temporary, stats, error);
    }
    if (!status)
        status = stage_png(outputs->png, frame, list, count, error);
    if (!status)
        status = stage_png(outputs->preview, frame, list, count, error);
    stats->write_s = clock_lap(&lap);
    stats->total_s = lap - start;
    if (!status && outputs->stats) {
        if (!(temporary = stage(list, count, outputs->stats, error)))
            return FEWRAY_ERROR_MEMORY;
        status = stats_write(stats, temporary, error);
    }
    return status;
}

/* The new file into the old one's place, which then has the temporary name; false, with errno,
 * where there is no old one or the file system can't. */
static bool exchange(const struct staged_file *file) {
#ifdef RENAME_EXCHANGE
    return !renameat2(AT_FDCWD, file->temporary, AT_FDCWD, file->path, RENAME_EXCHANGE);
#else
    errno = ENOSYS;
    return false;
#endif
}

/* Gives all files their names. Where one can't have it, those before it get their old content back,
 * as far as the file system can exchange files. */
static int commit_all(struct staged_file *list, int count, struct fewray_error *error) {
    enum { NOT_YET, NEW, EXCHANGED, RENAMED } fate[OUTPUT_MAX] = {NOT_YET};
    int status = FEWRAY_OK;
    for (int i = 0; i < count && !status; i++)
        status = fewray_check_replaceable(list[i].path, error);
    for (int i = 0; i < count && !status; i++) {
        const bool exchanged = exchange(&list[i]);
        fate[i] = exchanged ? EXCHANGED : errno == ENOENT ? NEW : RENAMED;
        if (!exchanged)
            status = fewray_commit_file(list[i].temporary, list[i].path, error);
        if (status)
            fate[i] = NOT_YET;
    }
    for (int i = 0; i < count && status; i++)
        if (fate[i] == NEW)
            unlink(list[i].path);
        else if (fate[i] == EXCHANGED)
            exchange(&list[i]);
    return status;
}

int outputs_write_kept(const struct fewray_outputs *outputs, const struct fewray_frame *frame,
                       const struct kept_file *kept, struct fewray_run_stats *stats, double start,
                       struct fewray_error *error) {
    struct staged_file list[OUTPUT_MAX];
    int count = 0;
    int status = stage_all(outputs, frame, kept, stats, start, list, &count, error);
    if (status && count > 0 && error && same_name(error->file, list[count - 1].temporary))
        snprintf(error->file, sizeof error->file, "%s", list[count - 1].path); /* the user's name */
    if (!status)
        status = commit_all(list, count, error);
    for (int i = 0; i < count; i++) {
        fewray_discard_file(list[i].temporary);
        free(list[i].temporary);
    }
    return status;
}

int outputs_write(const struct fewray_outputs *outputs, const struct fewray_frame *frame,
                  struct fewray_run_stats *stats, double start, struct fewray_error *error) {
    return outputs_write_kept(outputs, frame, NULL, stats, start, error);
}
