/* SPDX-License-Identifier: Apache-2.0 */
/* One table from the channel names of other renderers to ours. */

#include "pipeline/layer_names.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

struct alias {
    enum layer_naming naming;
    enum fewray_layer layer;
    const char *path; /* what stands before the last dot, without Blender's view layer; case doesn't
                         count */
    const char *components; /* the letter of each channel */
};

/* For each layer the best first. Mitsuba's AOV names are the scene author's; these are the ones of
 * its documentation and of common scenes. Blender's channels begin with the name of the view layer,
 * which may be anything. */
static const struct alias ALIASES[] = {
    {NAMING_BLENDER, FEWRAY_COLOR, "Noisy Image", "RGB"},
    {NAMING_BLENDER, FEWRAY_COLOR, "Combined", "RGB"},
    {NAMING_BLENDER, FEWRAY_ALBEDO, "Denoising Albedo", "RGB"},
    {NAMING_BLENDER, FEWRAY_ALBEDO, "DiffCol", "RGB"},
    {NAMING_BLENDER, FEWRAY_NORMAL, "Denoising Normal", "XYZ"},
    {NAMING_BLENDER, FEWRAY_NORMAL, "Normal", "XYZ"},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Denoising Depth", "Z"},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Denoising Depth", "V"},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Depth", "Z"},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Depth", "V"},
    {NAMING_BLENDER, FEWRAY_EMISSION, "Emit", "RGB"},
    {NAMING_MITSUBA, FEWRAY_COLOR, "img", "RGB"},
    {NAMING_MITSUBA, FEWRAY_COLOR, "image", "RGB"},
    {NAMING_MITSUBA, FEWRAY_ALBEDO, "albedo", "RGB"},
    {NAMING_MITSUBA, FEWRAY_ALBEDO, "alb", "RGB"},
    {NAMING_MITSUBA, FEWRAY_ALBEDO, "albedo", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "sh_normal", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "nn", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "normals", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "geo_normal", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "sh_normal", "RGB"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "normal", "RGB"},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "depth", "T"},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "dd.y", "T"},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "dd", "T"},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "depth", "Y"},
};

/* The plane "[view layer.]path.component"; a view layer is asked for only where prefix is true. */
static struct fewray_plane *find_alias(const struct fewray_frame *frame, const char *path,
                                       char component, bool prefix) {
    char wanted[FEWRAY_NAME_MAX];
    const int length = snprintf(wanted, sizeof wanted, "%s.%c", path, component);
    for (size_t i = 0; i < frame->plane_count; i++) {
        struct fewray_plane *plane = &frame->planes[i];
        const int extra = (int)strlen(plane->name) - length;
        const bool placed = extra == 0 || (prefix && extra > 1 && plane->name[extra - 1] == '.');
        if (placed && !strcasecmp(plane->name + extra, wanted))
            return plane;
    }
    return NULL;
}

/* A renderer that marks a miss by a huge depth means our 0. */
static void mend_depth(const struct fewray_frame *frame, float *depth) {
    const float miss = 6e7f; /* Blender: 1e10; farther than any scene in metres */
    const size_t count = (size_t)frame->width * (size_t)frame->height;
    for (size_t i = 0; i < count; i++)
        if (depth[i] >= miss)
            depth[i] = 0;
}

static bool adopt(struct fewray_frame *frame, const struct alias *alias) {
    struct fewray_plane *found[3];
    int count;
    const char *const *names = fewray_layer_channels(alias->layer, &count);
    for (int c = 0; c < count; c++)
        if (!(found[c] = find_alias(frame, alias->path, alias->components[c],
                                    alias->naming == NAMING_BLENDER)))
            return false;
    for (int c = 0; c < count; c++)
        snprintf(found[c]->name, sizeof found[c]->name, "%s", names[c]);
    if (alias->layer == FEWRAY_DEPTH)
        mend_depth(frame, found[0]->data);
    return true;
}

void adopt_layer_names(struct fewray_frame *frame, enum layer_naming naming) {
    float *planes[3];
    for (size_t i = 0; i < sizeof ALIASES / sizeof *ALIASES; i++) {
        const struct alias *alias = &ALIASES[i];
        if ((naming == NAMING_AUTO || naming == alias->naming) &&
            !fewray_frame_layer(frame, alias->layer, planes))
            adopt(frame, alias);
    }
}

int read_picture(const char *path, enum layer_naming naming, struct fewray_frame **out,
                 struct fewray_error *error) {
    int status = fewray_frame_read_exr(path, out, error);
    if (status)
        return status;
    adopt_layer_names(*out, naming);
    float *color[3];
    if (!fewray_frame_layer(*out, FEWRAY_COLOR, color)) {
        status = fewray_fail(
            error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
            "there are no colour channels R, G, B; `fewray info` lists what the file has");
        fewray_frame_destroy(out);
    }
    return status;
}
