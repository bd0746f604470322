/* SPDX-License-Identifier: Apache-2.0 */
/* One picture: read, denoised by what it has, and written with all else as it was. */

#include "pipeline/denoise_job.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pipeline/clock.h"
#include "pipeline/kept.h"
#include "pipeline/stats.h"

/* What is known of the picture that is denoised. */
struct picture {
    struct fewray_frame *frame;
    struct adoption adoption;
    struct kept_file kept;
    struct pass_sums passes;
    char names[NAME_LIST_MAX + PASSES_MAX][80]; /* of the layers to filter as well */
    int name_count;
    bool filters_passes;
};

/* Whether a channel belongs to a layer of the list, "NAME" or "NAME:emission". */
static bool is_named(const struct name_list *aovs, const char *channel) {
    for (int k = 0; k < aovs->count; k++) {
        const size_t length = strcspn(aovs->names[k], ":");
        if (!strncmp(aovs->names[k], channel, length) &&
            (channel[length] == '.' || channel[length] == 0))
            return true;
    }
    return false;
}

/* What was denoised before is denoised again from its noisy layers, which the denoiser's input is.
 */
static void undo_denoising(struct fewray_frame *frame, const struct name_list *aovs) {
    for (size_t i = 0; i < frame->plane_count; i++) {
        const char *name = frame->planes[i].name;
        if (strncmp(name, "noisy.", 6))
            continue;
        name += 6;
        const bool wanted = (*name && strchr("RGBA", *name) && !name[1]) || is_named(aovs, name);
        float *denoised = wanted ? fewray_frame_plane(frame, name) : NULL;
        if (denoised)
            memcpy(denoised, frame->planes[i].data,
                   sizeof(float) * (size_t)frame->width * (size_t)frame->height);
    }
}

/* Bad pixels of the layers that the denoiser is to filter, as in the colour. */
static void repair_aovs(const struct fewray_frame *frame, const struct name_list *aovs) {
    for (int k = 0; k < aovs->count; k++)
        for (int c = 0; c < 3; c++) {
            char channel[sizeof *aovs->names + 2];
            const int length = (int)strcspn(aovs->names[k], ":");
            snprintf(channel, sizeof channel, "%.*s.%c", length, aovs->names[k], "RGB"[c]);
            float *data = fewray_frame_plane(frame, channel);
            if (data)
                fewray_frame_repair_radiance(frame, data);
        }
}

/* The layers that are filtered: those of the list, for "auto" the passes whose sum is the picture.
 */
static int take_layers(const struct denoise_job *job, struct picture *picture,
                       struct fewray_error *error) {
    bool automatic = false;
    for (int k = 0; k < job->aovs->count; k++)
        if (!strcmp(job->aovs->names[k], "auto"))
            automatic = true;
        else
            memcpy(picture->names[picture->name_count++], job->aovs->names[k], 80);
    if (!automatic)
        return FEWRAY_OK;
    int count = 0;
    pass_sums_find(picture->frame, &picture->adoption, job->naming, true, &picture->passes);
    const int status = pass_sums_start(picture->frame, &picture->passes,
                                       picture->names + picture->name_count, &count, error);
    picture->name_count += count;
    picture->filters_passes = count > 0;
    if (!status && !count && job->note) {
        char text[640];
        snprintf(text, sizeof text, "%.500s: --aov auto finds no passes that sum up to the picture",
                 job->input);
        job->note(text);
    }
    return status;
}

static int load(const struct denoise_job *job, struct picture *picture,
                struct fewray_run_stats *stats, struct fewray_error *error) {
    int status = outputs_check(&job->outputs, error);
    if (!status)
        status =
            read_noisy_picture(job->input, job->naming, &picture->adoption, &picture->frame, error);
    if (!status)
        status =
            kept_start(job->input, &picture->adoption, job->outputs.float32, &picture->kept, error);
    if (status)
        return status;
    undo_denoising(picture->frame, job->aovs);
    stats->repaired = fewray_frame_repair(picture->frame);
    repair_aovs(picture->frame, job->aovs);
    if ((status = take_layers(job, picture, error)))
        return status;
    if (!picture->filters_passes)
        fewray_frame_compact(picture->frame);
    stats->width = picture->frame->width;
    stats->height = picture->frame->height;
    return FEWRAY_OK;
}

static int filter(const struct denoise_job *job, struct picture *picture,
                  struct fewray_denoiser **denoiser, struct fewray_run_stats *stats,
                  struct fewray_error *error) {
    struct fewray_denoise_stats work = {0};
    const char *names[NAME_LIST_MAX + PASSES_MAX];
    for (int k = 0; k < picture->name_count; k++)
        names[k] = picture->names[k];
    int status = *denoiser ? FEWRAY_OK : fewray_denoiser_create(&job->denoise, denoiser, error);
    if (!status)
        status = fewray_denoise_frame_layers(*denoiser, picture->frame, names, picture->name_count,
                                             &work, error);
    if (status)
        return status;
    stats->tiles = work.tiles;
    stats->tiles_denoised = work.tiles_denoised;
    if (picture->filters_passes)
        pass_sums_finish(picture->frame, &picture->passes);
    return kept_changes(picture->frame, &picture->adoption,
                        picture->filters_passes ? &picture->passes : NULL, &picture->kept, error);
}

int denoise_job_run(const struct denoise_job *job, struct fewray_denoiser **denoiser,
                    struct run_progress *progress, struct fewray_run_stats *stats,
                    struct fewray_error *error) {
    const double start = clock_seconds();
    double lap = start;
    struct picture *picture = calloc(1, sizeof *picture);
    if (!picture)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, job->input, 0, "out of memory");
    run_progress_update(progress, "load", 0);
    int status = load(job, picture, stats, error);
    stats->load_s = clock_lap(&lap);
    if (!status) {
        const struct run_work expected = {.pixels = (long long)stats->width * stats->height,
                                          .threads = stats->threads,
                                          .denoised = true,
                                          .pictures = !!job->outputs.png};
        run_progress_expect(progress, &expected);
        status = filter(job, picture, denoiser, stats, error);
        stats->denoise_s = clock_lap(&lap);
    }
    if (!status) {
        run_progress_update(progress, "write", 0);
        status =
            outputs_write_kept(&job->outputs, picture->frame, &picture->kept, stats, start, error);
    }
    if (status == FEWRAY_ERROR_CANCELLED)
        fewray_fail(error, FEWRAY_ERROR_CANCELLED, job->input, 0,
                    "interrupted; nothing is written");
    kept_end(&picture->kept);
    fewray_frame_destroy(&picture->frame);
    free(picture);
    return status;
}
