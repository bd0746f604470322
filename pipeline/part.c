/* SPDX-License-Identifier: Apache-2.0 */
/* What a part is of: labels in EXR headers, and whether a file is a part. */

#include "pipeline/part.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const MOMENTS[] = {
    "part.count",  "part.factor",      "part.mean.R",      "part.mean.G",
    "part.mean.B", "part.deviation.R", "part.deviation.G", "part.deviation.B",
};
enum { MOMENT_COUNT = sizeof MOMENTS / sizeof *MOMENTS };

static const char *guide_name(const struct fewray_job *job) {
    if (!job->guided)
        return "off";
    return job->settings.paper_weights ? "paper" : "odis";
}

void part_label_of_job(const struct fewray_job *job, const struct fewray_render_settings *settings,
                       uint64_t fingerprint, int width, int height, struct part_label *label) {
    *label = (struct part_label){.part = job->part,
                                 .parts = job->parts,
                                 .spp = settings->spp,
                                 .width = width,
                                 .height = height};
    snprintf(label->seed, sizeof label->seed, "%" PRIu64, settings->seed);
    snprintf(label->fingerprint, sizeof label->fingerprint, "%016" PRIx64, fingerprint);
    snprintf(label->scene, sizeof label->scene, "%s", job->scene_path);
    snprintf(label->settings, sizeof label->settings,
             "guide=%s pilot=%d initial=%d max_depth=%d bsdf_fraction=%g look_weight=%g probes=%d "
             "share_maps=%d refine=%d map_bins=%d camera_rays=%d direct=%d indirect=%d "
             "guide_weights=%s",
             guide_name(job), job->pilot, settings->initial, settings->max_depth,
             (double)job->settings.bsdf_fraction, (double)job->settings.look_weight,
             settings->probes, settings->share_maps, settings->refine, settings->map_bins,
             settings->camera_rays, settings->direct, settings->indirect,
             settings->weights_path ? settings->weights_path : "built-in");
}

bool part_label_write(const struct part_label *label, struct fewray_frame *frame) {
    char part[32], spp[16];
    snprintf(part, sizeof part, "%d/%d", label->part, label->parts);
    snprintf(spp, sizeof spp, "%d", label->spp);
    return fewray_frame_set_attribute(frame, "fewray.part", part) &&
           fewray_frame_set_attribute(frame, "fewray.spp", spp) &&
           fewray_frame_set_attribute(frame, "fewray.seed", label->seed) &&
           fewray_frame_set_attribute(frame, "fewray.scene", label->scene) &&
           fewray_frame_set_attribute(frame, "fewray.scene_fingerprint", label->fingerprint) &&
           fewray_frame_set_attribute(frame, "fewray.settings", label->settings);
}

static bool copy_text(const struct fewray_frame *frame, const char *name, char *text, size_t size) {
    const char *found = fewray_frame_attribute(frame, name);
    snprintf(text, size, "%s", found ? found : "");
    return found && strlen(found) < size;
}

int part_label_read(const struct fewray_frame *frame, const char *path, struct part_label *label,
                    struct fewray_error *error) {
    *label = (struct part_label){.width = frame->width, .height = frame->height};
    const char *part = fewray_frame_attribute(frame, "fewray.part");
    const char *spp = fewray_frame_attribute(frame, "fewray.spp");
    label->spp = spp ? atoi(spp) : 0;
    char rest;
    if (!part || sscanf(part, "%d/%d%c", &label->part, &label->parts, &rest) != 2 ||
        label->part < 1 || label->part > label->parts || label->spp < 1 ||
        !copy_text(frame, "fewray.seed", label->seed, sizeof label->seed) ||
        !copy_text(frame, "fewray.scene", label->scene, sizeof label->scene) ||
        !copy_text(frame, "fewray.scene_fingerprint", label->fingerprint,
                   sizeof label->fingerprint) ||
        !copy_text(frame, "fewray.settings", label->settings, sizeof label->settings))
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                           "this is no part of a picture; give files that `fewray render --part` "
                           "wrote");
    return FEWRAY_OK;
}

const char *part_difference(const struct part_label *a, const struct part_label *b) {
    return strcmp(a->fingerprint, b->fingerprint)           ? "the scene"
           : a->width != b->width || a->height != b->height ? "the picture's size"
           : a->parts != b->parts                           ? "the number of parts"
           : a->spp != b->spp                               ? "the samples a pixel"
           : strcmp(a->seed, b->seed)                       ? "the seed"
           : strcmp(a->settings, b->settings)               ? "the settings"
                                                            : NULL;
}

/* Whether a part's pixels can be what a render left. */
static bool is_sound(const struct fewray_frame *frame) {
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    for (int m = 0; m < MOMENT_COUNT; m++)
        if (!fewray_frame_plane(frame, MOMENTS[m]))
            return false;
    for (size_t k = 0; k < frame->plane_count; k++)
        for (size_t i = 0; i < pixels; i++)
            if (!isfinite(frame->planes[k].data[i]))
                return false;
    const float *count = fewray_frame_plane(frame, "part.count");
    const float *factor = fewray_frame_plane(frame, "part.factor");
    for (size_t i = 0; i < pixels; i++)
        if (!(count[i] >= 0 && factor[i] >= 0))
            return false;
    return true;
}

int part_read(const char *path, struct fewray_frame **out, struct fewray_error *error) {
    const int status = fewray_frame_read_exr(path, out, error);
    if (status || is_sound(*out))
        return status;
    fewray_frame_destroy(out);
    return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                       "the part is damaged: layers are missing or hold impossible values; render "
                       "it again");
}

bool part_is_there(const struct part_label *label, const char *path) {
    struct fewray_frame *frame = NULL;
    struct part_label found;
    const bool same = !part_read(path, &frame, NULL) &&
                      !part_label_read(frame, path, &found, NULL) &&
                      !part_difference(label, &found) && found.part == label->part;
    fewray_frame_destroy(&frame);
    return same;
}
