/* SPDX-License-Identifier: Apache-2.0 */
/* A sequence of files, one after another. They are denoised each for itself: the mean over frames
 * that `fewray render` makes needs the depth that each surface had in the frame before, which the
 * motion vectors of no renderer tell. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "pipeline/denoise_job.h"
#include "pipeline/frames.h"

struct run {
    const struct denoise_sequence *sequence;
    int index, count; /* of the frame that is denoised, for the progress */
};

static bool exists(const char *path) {
    struct stat info;
    return !stat(path, &info);
}

/* A frame's progress as that of the sequence. */
static void frame_progress(void *user, const struct fewray_progress *of_frame) {
    const struct run *run = user;
    struct fewray_progress now = *of_frame;
    now.fraction = (run->index + of_frame->fraction) / run->count;
    if (of_frame->seconds_left >= 0 && of_frame->fraction < 1) /* later frames take as long */
        now.seconds_left *= 1 + (run->count - run->index - 1) / (1 - of_frame->fraction);
    run->sequence->tell(run->sequence->tell_user, &now);
}

/* "3, 5..7": numbers in text, which is cut with "...". */
static void list_numbers(const int *numbers, int count, char *text, size_t size) {
    size_t used = 0;
    text[0] = 0;
    for (int i = 0; i < count && used + 40 < size;) {
        int end = i;
        while (end + 1 < count && numbers[end + 1] == numbers[end] + 1)
            end++;
        used += (size_t)(end > i ? snprintf(text + used, size - used, "%s%d..%d", i ? ", " : "",
                                            numbers[i], numbers[end])
                                 : snprintf(text + used, size - used, "%s%d", i ? ", " : "",
                                            numbers[i]));
        i = end + 1;
        if (i < count && used + 40 >= size)
            snprintf(text + used, size - used, ", ...");
    }
}

/* The numbers that are asked for, malloc'd; a missing file is an error that names it. */
static int asked_frames(const struct denoise_job *job, const struct fewray_frames *frames,
                        int **numbers, int *count, struct fewray_error *error) {
    int *missing = malloc(sizeof(int) * (size_t)frames_count(frames));
    int absent = 0, status = FEWRAY_OK;
    *count = 0;
    *numbers = malloc(sizeof(int) * (size_t)frames_count(frames));
    bool good = missing && *numbers;
    for (int frame = frames->first; good && frame <= frames->last; frame += frames->step) {
        char *name = frames_name(job->input, frame);
        good = name != NULL;
        if (good && exists(name))
            (*numbers)[(*count)++] = frame;
        else if (good)
            missing[absent++] = frame;
        free(name);
    }
    char text[200];
    if (!good)
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, job->input, 0, "out of memory");
    else if (absent) {
        list_numbers(missing, absent, text, sizeof text);
        status = fewray_fail(error, FEWRAY_ERROR_IO, job->input, 0,
                             "%d of %d frames are missing: %s", absent, frames_count(frames), text);
    }
    free(missing);
    return status;
}

/* All that are there; a gap is told. */
static int present_frames(const struct denoise_job *job, int **numbers, int *count,
                          struct fewray_error *error) {
    const int status = frames_find(job->input, numbers, count, error);
    if (status)
        return status;
    if (*count == 0)
        return fewray_fail(error, FEWRAY_ERROR_IO, job->input, 0,
                           "there is no file of that name with a number in its place");
    const int span = (*numbers)[*count - 1] - (*numbers)[0] + 1;
    int *missing = span > *count ? malloc(sizeof(int) * (size_t)(span - *count)) : NULL;
    int absent = 0;
    for (int i = 1; missing && i < *count; i++)
        for (int frame = (*numbers)[i - 1] + 1; frame < (*numbers)[i]; frame++)
            missing[absent++] = frame;
    if (absent && job->note) {
        char list[200], text[840];
        list_numbers(missing, absent, list, sizeof list);
        snprintf(text, sizeof text, "%.500s: between frames %d and %d these are missing: %s",
                 job->input, (*numbers)[0], (*numbers)[*count - 1], list);
        job->note(text);
    }
    free(missing);
    return FEWRAY_OK;
}

/* One frame, or nothing where it is there. */
static int run_frame(const struct denoise_job *job, const struct denoise_sequence *sequence,
                     int frame, struct fewray_denoiser **denoiser, struct run_progress *progress,
                     int threads, struct fewray_error *error) {
    struct denoise_job one = *job;
    char *names[4] = {frames_name(job->input, frame), NULL, NULL, NULL};
    const char *const patterns[4] = {job->input, job->outputs.exr, job->outputs.png,
                                     job->outputs.stats};
    bool good = names[0] != NULL, there = true;
    for (int i = 1; i < 4 && good; i++) {
        if (!patterns[i])
            continue;
        good = (names[i] = frames_name(patterns[i], frame)) != NULL;
        there = there && good && exists(names[i]);
    }
    one.input = names[0];
    one.outputs.exr = names[1];
    one.outputs.png = names[2];
    one.outputs.stats = names[3];
    int status =
        good ? FEWRAY_OK : fewray_fail(error, FEWRAY_ERROR_MEMORY, job->input, 0, "out of memory");
    if (good && !(there && sequence->skip_existing)) {
        struct fewray_run_stats stats = {.threads = threads};
        status = denoise_job_run(&one, denoiser, progress, &stats, error);
        if (!status && sequence->frame_done)
            sequence->frame_done(sequence->frame_user, frame, &stats);
    }
    for (int i = 0; i < 4; i++)
        free(names[i]);
    return status;
}

int denoise_sequence_run(const struct denoise_job *job, const struct denoise_sequence *sequence,
                         int threads, struct fewray_error *error) {
    int *numbers = NULL, count = 0;
    int status = sequence->frames ? asked_frames(job, sequence->frames, &numbers, &count, error)
                                  : present_frames(job, &numbers, &count, error);
    struct run run = {.sequence = sequence, .count = count};
    struct run_progress progress = {0};
    struct denoise_job frames_job = *job;
    struct fewray_denoiser *denoiser = NULL;
    frames_job.denoise.progress_user = &progress;
    for (; run.index < count && !status; run.index++) {
        progress =
            (struct run_progress){.tell = sequence->tell ? frame_progress : NULL, .user = &run};
        run_progress_start_denoise(&progress);
        status = run_frame(&frames_job, sequence, numbers[run.index], &denoiser, &progress, threads,
                           error);
        frames_job.note = NULL; /* once is enough */
    }
    fewray_denoiser_destroy(&denoiser);
    free(numbers);
    return status;
}
