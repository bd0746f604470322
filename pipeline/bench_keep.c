/* SPDX-License-Identifier: Apache-2.0 */
/* Some of a bench's pictures as files, for `fewray report`. */

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "pipeline/bench.h"
#include "pipeline/origin.h"
#include "pipeline/stats.h"

static const char *const FILE_NAMES[BENCH_METHODS] = {
    [BENCH_PT] = "path-traced",
    [BENCH_GUIDED] = "guided",
    [BENCH_PT_DENOISED] = "path-traced-denoised",
    [BENCH_GUIDED_DENOISED] = "guided-denoised",
    [BENCH_PT_OIDN] = "path-traced-oidn",
    [BENCH_MITSUBA] = "mitsuba",
    [BENCH_MITSUBA_OIDN] = "mitsuba-oidn",
};

/* Writes R, G, B and, where there are any, the reference's standard errors. */
static int write_picture(const struct fewray_frame *picture, const char *path, bool float32,
                         struct fewray_error *error) {
    static const char *const names[] = {"R", "G", "B", "stderr.R", "stderr.G", "stderr.B"};
    struct fewray_plane planes[6];
    struct fewray_frame kept = {.width = picture->width, .height = picture->height};
    kept.planes = planes;
    for (int i = 0; i < 6; i++) {
        float *data = fewray_frame_plane(picture, names[i]);
        if (!data)
            continue;
        struct fewray_plane *plane = &planes[kept.plane_count++];
        *plane = (struct fewray_plane){.data = data};
        snprintf(plane->name, sizeof plane->name, "%s", names[i]);
    }
    return fewray_frame_write_exr(&kept, path, float32, error);
}

static int write_stats(const struct bench_settings *settings, const struct bench_row *row,
                       const char *path, struct fewray_error *error) {
    char cpu[128];
    origin_cpu(cpu, sizeof cpu);
    json_t *object = json_pack("{s:s, s:s, s:s, s:i, s:i, s:f, s:f, s:f, s:f, s:s}", "method",
                               BENCH_METHOD_NAMES[row->method], "scene", settings->scene_path,
                               "guide", row->guide, "spp", row->spp, "seed", row->seed, "initial_s",
                               row->initial_s, "guide_s", row->guide_s, "render_s", row->render_s,
                               "denoise_s", row->denoise_s, "cpu", cpu);
    return stats_write_json(object, path, error);
}

int bench_keep_picture(const struct bench_settings *settings, const struct bench_row *row,
                       const struct fewray_frame *picture, struct fewray_error *error) {
    char path[1200];
    if (row->spp != settings->keep_spp || row->seed != 1)
        return FEWRAY_OK;
    snprintf(path, sizeof path, "%s/%s-%dspp.exr", settings->keep_folder, FILE_NAMES[row->method],
             row->spp);
    const int status = write_picture(picture, path, false, error);
    strcpy(strrchr(path, '.'), ".json");
    return status ? status : write_stats(settings, row, path, error);
}

int bench_keep_reference(const struct bench_settings *settings,
                         const struct fewray_frame *reference, struct fewray_error *error) {
    char path[1200];
    struct stat kept, given;
    if (!settings->keep_spp)
        return FEWRAY_OK;
    snprintf(path, sizeof path, "%s/reference.exr", settings->keep_folder);
    if (!stat(path, &kept) && !stat(settings->reference_path, &given) &&
        kept.st_dev == given.st_dev && kept.st_ino == given.st_ino)
        return FEWRAY_OK;
    return write_picture(reference, path, true, error);
}
