/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a picture to the picture: check, merge, denoise, write. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "features/cancel.h"
#include "pipeline/clock.h"
#include "pipeline/outputs.h"
#include "pipeline/part.h"
#include "pipeline/stats.h"

struct part_file {
    const char *path;
    struct part_label label;
};

static int read_label(struct part_file *file, struct fewray_error *error) {
    struct fewray_frame *header = NULL;
    int status = fewray_frame_read_exr_header(file->path, &header, error);
    if (!status)
        status = part_label_read(header, file->path, &file->label, error);
    fewray_frame_destroy(&header);
    return status;
}

static int by_number(const void *a, const void *b) {
    return ((const struct part_file *)a)->label.part - ((const struct part_file *)b)->label.part;
}

/* Appends "2" or "5-7" to a list. */
static void list_range(char *text, size_t size, int first, int last) {
    const size_t used = strlen(text);
    if (last < first || used + 24 > size)
        return;
    const char *comma = used ? ", " : "";
    if (first == last)
        snprintf(text + used, size - used, "%s%d", comma, first);
    else
        snprintf(text + used, size - used, "%s%d-%d", comma, first, last);
}

/* The numbers that the sorted files lack. Returns how many there are. */
static int list_missing(const struct part_file *files, int count, char *text, size_t size) {
    int next = 1;
    text[0] = 0;
    for (int i = 0; i < count; i++) {
        list_range(text, size, next, files[i].label.part - 1);
        next = files[i].label.part + 1;
    }
    list_range(text, size, next, files[0].label.parts);
    return files[0].label.parts - count;
}

/* Reads all labels, sorts the files by number, and refuses what doesn't belong together. */
static int check_parts(const struct fewray_merge_job *job, struct part_file *files,
                       struct fewray_error *error) {
    char missing[256];
    for (int i = 0; i < job->count; i++) {
        files[i].path = job->paths[i];
        const int status = read_label(&files[i], error);
        if (status)
            return status;
        const char *what = part_difference(&files[0].label, &files[i].label);
        if (what)
            return fewray_fail(error, FEWRAY_ERROR_FORMAT, files[i].path, 0,
                               "the part doesn't belong to %s: %s differs", files[0].path, what);
    }
    qsort(files, (size_t)job->count, sizeof *files, by_number);
    for (int i = 1; i < job->count; i++)
        if (files[i].label.part == files[i - 1].label.part)
            return fewray_fail(error, FEWRAY_ERROR_FORMAT, files[i].path, 0,
                               "part %d is given twice, %s is the same; give one of them",
                               files[i].label.part, files[i - 1].path);
    const int lacking = list_missing(files, job->count, missing, sizeof missing);
    if (lacking && !job->partial)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "of %d parts these are missing: %s; give them all, or merge without "
                           "them by --partial",
                           files[0].label.parts, missing);
    return FEWRAY_OK;
}

/* Merges the files one after another, always in the order of their numbers. */
static int merge_files(const struct fewray_merge_job *job, const struct part_file *files,
                       struct fewray_frame **sum, struct fewray_error *error) {
    int status = part_read(files[0].path, sum, error);
    for (int i = 1; i < job->count && !status; i++) {
        struct fewray_frame *part = NULL;
        if (cancel_wanted(job->cancel))
            return FEWRAY_ERROR_CANCELLED;
        if (job->progress)
            job->progress(job->progress_user, "merge", (double)i / job->count);
        status = part_read(files[i].path, &part, error);
        if (!status && !part_add(*sum, part))
            status = fewray_fail(error, FEWRAY_ERROR_FORMAT, files[i].path, 0,
                                 "the part has other layers than %s", files[0].path);
        fewray_frame_destroy(&part);
    }
    if (!status)
        part_finish(*sum);
    return status;
}

/* The header tells what was merged; it is no part any more. */
static bool label_picture(const struct part_file *files, int count, struct fewray_frame *frame) {
    char parts[64], spp[24];
    snprintf(parts, sizeof parts, "merged %d of %d", count, files[0].label.parts);
    snprintf(spp, sizeof spp, "%lld", (long long)files[0].label.spp * count);
    return fewray_frame_set_attribute(frame, "fewray.part", parts) &&
           fewray_frame_set_attribute(frame, "fewray.spp", spp);
}

struct denoise_watch {
    const struct fewray_merge_job *job;
};

static void denoise_progress(void *user, double fraction) {
    const struct fewray_merge_job *job = ((const struct denoise_watch *)user)->job;
    job->progress(job->progress_user, "denoise", fraction);
}

static int denoise(const struct fewray_merge_job *job, struct fewray_frame *frame,
                   struct fewray_run_stats *stats, struct fewray_error *error) {
    const char *layers[2];
    int layer_count = 0;
    if (fewray_frame_plane(frame, "direct.R"))
        layers[layer_count++] = "direct";
    if (fewray_frame_plane(frame, "indirect.R"))
        layers[layer_count++] = "indirect";
    struct denoise_watch watch = {job};
    struct fewray_denoise_options options = job->denoise;
    options.threads = stats->threads;
    options.cancel = job->cancel;
    options.progress = job->progress ? denoise_progress : NULL;
    options.progress_user = &watch;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_denoise_stats work = {0};
    int status = fewray_denoiser_create(&options, &denoiser, error);
    if (!status)
        status = fewray_denoise_frame_layers(denoiser, frame, layers, layer_count, &work, error);
    fewray_denoiser_destroy(&denoiser);
    stats->tiles = work.tiles;
    stats->tiles_denoised = work.tiles_denoised;
    return status;
}

void fewray_merge_job_init(struct fewray_merge_job *job) {
    *job = (struct fewray_merge_job){.denoised = true};
    fewray_denoise_options_init(&job->denoise);
}

int fewray_merge_run(const struct fewray_merge_job *job, struct fewray_frame **picture,
                     struct fewray_run_stats *stats, struct fewray_error *error) {
    struct fewray_run_stats run = {.threads = stats_threads(job->threads),
                                   .no_images = !job->outputs.png};
    struct fewray_frame *frame = NULL;
    const double start = clock_seconds();
    double lap = start;
    struct part_file *files = calloc((size_t)job->count + 1, sizeof *files);
    int status;
    if (picture)
        *picture = NULL;
    if (!files || job->count < 1) {
        status = fewray_fail(error, files ? FEWRAY_ERROR_ARGUMENT : FEWRAY_ERROR_MEMORY, NULL, 0,
                             files ? "there is no part to merge" : "no memory for the parts");
        goto done;
    }
    if ((status = outputs_check(&job->outputs, error)) ||
        (status = check_parts(job, files, error)) ||
        (status = merge_files(job, files, &frame, error)))
        goto done;
    run.width = frame->width;
    run.height = frame->height;
    run.spp = files[0].label.spp * job->count;
    run.load_s = clock_lap(&lap);
    if (!label_picture(files, job->count, frame)) {
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for a name");
        goto done;
    }
    if (job->denoised && (status = denoise(job, frame, &run, error)))
        goto done;
    run.denoise_s = clock_lap(&lap);
    status = outputs_write(&job->outputs, frame, &run, start, error);
done:
    if (status == FEWRAY_ERROR_CANCELLED)
        fewray_fail(error, status, job->outputs.exr, 0, "interrupted; nothing is written");
    if (picture && !status) {
        *picture = frame;
        frame = NULL;
    }
    if (stats)
        *stats = run;
    fewray_frame_destroy(&frame);
    free(files);
    return status;
}
