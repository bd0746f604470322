/* SPDX-License-Identifier: Apache-2.0 */
/* The channels of a foreign file that denoising changes. */

#include "pipeline/kept.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Whether the channel, called as in the frame, is of half floats. */
static bool is_half(const struct fewray_exr_header *header, const char *name) {
    for (int p = 0; p < header->part_count; p++)
        for (int c = 0; c < header->parts[p].channel_count; c++) {
            const struct fewray_exr_channel *channel = &header->parts[p].channels[c];
            const size_t length = strlen(channel->name), whole = strlen(name);
            if (length <= whole && !strcmp(name + whole - length, channel->name))
                return !strcmp(channel->type, "half");
        }
    return false;
}

int kept_start(const char *path, const struct adoption *adoption, bool float32,
               struct kept_file *kept, struct fewray_error *error) {
    struct fewray_exr_header *header;
    *kept = (struct kept_file){.source = path};
    int status = fewray_exr_header_read(path, &header, error);
    if (status)
        return status;
    kept->half = !float32 && is_half(header, adoption->result[0]);
    for (int p = 0; p < header->part_count && !status; p++)
        if (header->parts[p].deep)
            status = fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                                 "part %d is deep, which isn't supported: flatten it or leave it "
                                 "out",
                                 p);
    fewray_exr_header_destroy(&header);
    return status;
}

static void add(struct kept_file *kept, const char *name, const float *data) {
    kept->changes[kept->change_count++] = (struct fewray_exr_change){name, data};
}

static bool has(const struct kept_file *kept, const char *name) {
    for (int i = 0; i < kept->change_count; i++)
        if (!strcmp(kept->changes[i].name, name))
            return true;
    return false;
}

/* Filtered passes in place of the file's, which stay as noisy.NAME where that isn't too long. */
static void add_passes(const struct fewray_frame *frame, const struct pass_sums *passes,
                       struct kept_file *kept) {
    for (int k = 0; k < passes->pass_count; k++)
        for (int c = 0; c < 3; c++) {
            const struct light_pass *pass = &passes->passes[k];
            const float *filtered = pass_sums_plane(frame, k, c);
            char noisy[FEWRAY_NAME_MAX + 8];
            if (!filtered || has(kept, pass->channels[c]))
                continue;
            add(kept, pass->channels[c], filtered);
            snprintf(noisy, sizeof noisy, "noisy.%s", pass->channels[c]);
            if (strlen(noisy) < FEWRAY_NAME_MAX && !has(kept, noisy)) {
                memcpy(kept->noisy_names[kept->noisy_count], noisy, FEWRAY_NAME_MAX);
                add(kept, kept->noisy_names[kept->noisy_count++], pass->data[c]);
            }
        }
}

int kept_changes(const struct fewray_frame *frame, const struct adoption *adoption,
                 const struct pass_sums *passes, struct kept_file *kept,
                 struct fewray_error *error) {
    static const char *const colors[3] = {"R", "G", "B"};
    kept->changes = calloc(2 * frame->plane_count + 3, sizeof *kept->changes);
    kept->noisy_names = calloc(frame->plane_count + 1, sizeof *kept->noisy_names);
    if (!kept->changes || !kept->noisy_names)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, kept->source, 0, "out of memory");
    for (int c = 0; c < 3; c++) /* the first decides where new channels go */
        add(kept, adopted_name(adoption, colors[c]), fewray_frame_plane(frame, colors[c]));
    for (size_t i = 0; i < frame->plane_count; i++) {
        const struct fewray_plane *noisy = &frame->planes[i];
        const char *name = noisy->name + strlen("noisy.");
        if (strncmp(noisy->name, "noisy.", strlen("noisy.")) ||
            !strncmp(name, "fewray.pass", strlen("fewray.pass")))
            continue;
        const bool color = *name && strchr("RGB", *name) && !name[1];
        const float *data = fewray_frame_plane(frame, name);
        if (!(color && adoption->keeps_noisy))
            add(kept, noisy->name, noisy->data);
        if (!color && data)
            add(kept, adopted_name(adoption, name), data);
    }
    if (passes)
        add_passes(frame, passes, kept);
    return FEWRAY_OK;
}

void kept_end(struct kept_file *kept) {
    free(kept->changes);
    free(kept->noisy_names);
    kept->changes = NULL;
    kept->noisy_names = NULL;
}
