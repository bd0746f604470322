/* SPDX-License-Identifier: Apache-2.0 */
/* One table from the channel names of other renderers to ours. */

#include "pipeline/layer_names.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

struct alias {
    enum layer_naming naming;
    enum fewray_layer layer;
    const char *stem; /* what stands before the component, without Blender's view layer and the
                         name of Mitsuba's outer integrators; case doesn't count */
    const char *components; /* the letter of each channel */
};

/* For each layer the best first. Mitsuba's AOV names are the scene author's; these are the ones of
 * its documentation and of common scenes. Blender's channels begin with the name of the view layer,
 * which may be anything; its long pass names are those of Blender 5. pbrt's are its GBufferFilm's,
 * the ones without a dot those of its first years. NAMING_AUTO: the names of parts and channels in
 * use among compositing programs. */
static const struct alias ALIASES[] = {
    {NAMING_BLENDER, FEWRAY_COLOR, "Noisy Image.", "RGB"},
    {NAMING_BLENDER, FEWRAY_COLOR, "Combined.", "RGB"},
    {NAMING_BLENDER, FEWRAY_ALBEDO, "Denoising Albedo.", "RGB"},
    {NAMING_BLENDER, FEWRAY_ALBEDO, "DiffCol.", "RGB"},
    {NAMING_BLENDER, FEWRAY_ALBEDO, "Diffuse Color.", "RGB"},
    {NAMING_BLENDER, FEWRAY_NORMAL, "Denoising Normal.", "XYZ"},
    {NAMING_BLENDER, FEWRAY_NORMAL, "Normal.", "XYZ"},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Denoising Depth.", "Z"},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Denoising Depth.", "V"},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Depth.", "Z"},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Depth.", "V"},
    {NAMING_BLENDER, FEWRAY_EMISSION, "Emit.", "RGB"},
    {NAMING_BLENDER, FEWRAY_EMISSION, "Emission.", "RGB"},
    {NAMING_MITSUBA, FEWRAY_COLOR, "img.", "RGB"},
    {NAMING_MITSUBA, FEWRAY_COLOR, "image.", "RGB"},
    {NAMING_MITSUBA, FEWRAY_ALBEDO, "albedo.", "RGB"},
    {NAMING_MITSUBA, FEWRAY_ALBEDO, "alb.", "RGB"},
    {NAMING_MITSUBA, FEWRAY_ALBEDO, "aa.", "RGB"},
    {NAMING_MITSUBA, FEWRAY_ALBEDO, "albedo.", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "sh_normal.", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "nn.", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "normal.", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "normals.", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "shading_normal.", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "geo_normal.", "XYZ"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "sh_normal.", "RGB"},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "normal.", "RGB"},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "depth.", "T"},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "dd.y.", "T"},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "dd.", "T"},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "depth.", "Y"},
    {NAMING_PBRT, FEWRAY_ALBEDO, "Albedo.", "RGB"},
    {NAMING_PBRT, FEWRAY_NORMAL, "Ns.", "XYZ"},
    {NAMING_PBRT, FEWRAY_NORMAL, "Ns", "xyz"},
    {NAMING_PBRT, FEWRAY_NORMAL, "N.", "XYZ"},
    {NAMING_PBRT, FEWRAY_NORMAL, "N", "xyz"},
    {NAMING_PBRT, FEWRAY_VARIANCE, "Variance.", "RGB"},
    {NAMING_AUTO, FEWRAY_COLOR, "rgba.", "RGB"},
    {NAMING_AUTO, FEWRAY_COLOR, "rgb.", "RGB"},
    {NAMING_AUTO, FEWRAY_COLOR, "beauty.", "RGB"},
    {NAMING_AUTO, FEWRAY_COLOR, "color.", "RGB"},
    {NAMING_AUTO, FEWRAY_COLOR, "C.", "RGB"},
    {NAMING_AUTO, FEWRAY_COLOR, "subimage00.", "RGB"},
    {NAMING_AUTO, FEWRAY_DEPTH, "", "Z"},
    {NAMING_AUTO, FEWRAY_DEPTH, "Z.", "Z"},
    {NAMING_AUTO, FEWRAY_DEPTH, "depth.", "R"},
};

/* The length of what stands before "stem + component" in a plane's name: 0, or a prefix that ends
 * with a dot. -1: the name is another. */
static int prefix_of(const char *name, const char *stem, char component) {
    char wanted[FEWRAY_NAME_MAX];
    const int length = snprintf(wanted, sizeof wanted, "%s%c", stem, component);
    const int extra = (int)strlen(name) - length;
    const bool placed = extra == 0 || (extra > 1 && name[extra - 1] == '.');
    return placed && !strcasecmp(name + extra, wanted) ? extra : -1;
}

/* The plane named "prefix + stem + component". */
static struct fewray_plane *find_plane(const struct fewray_frame *frame, const char *prefix,
                                       int prefix_length, const char *stem, char component) {
    for (size_t i = 0; i < frame->plane_count; i++) {
        struct fewray_plane *plane = &frame->planes[i];
        if (prefix_of(plane->name, stem, component) == prefix_length &&
            !strncmp(plane->name, prefix, (size_t)prefix_length))
            return plane;
    }
    return NULL;
}

/* All channels of an alias, of one and the same view layer or integrator: those without a prefix,
 * else the file's first. Mitsuba's moment integrator has second moments of each layer as well. */
static bool find_alias(const struct fewray_frame *frame, const char *stem, const char *components,
                       bool prefix, struct fewray_plane *found[3]) {
    for (int pass = 0; pass < (prefix ? 2 : 1); pass++)
        for (size_t i = 0; i < frame->plane_count; i++) {
            const char *name = frame->planes[i].name;
            const int length = prefix_of(name, stem, components[0]);
            if (length < 0 || (length > 0) != (pass > 0) || !strncmp(name, "m2_", 3))
                continue;
            found[0] = &frame->planes[i];
            bool all = true;
            for (int c = 1; components[c]; c++)
                all = (found[c] = find_plane(frame, name, length, stem, components[c])) && all;
            if (all)
                return true;
        }
    return false;
}

/* A renderer that marks a miss by a huge depth means our 0. */
static void mend_depth(const struct fewray_frame *frame, float *depth) {
    const float miss = 6e7f; /* Blender: 1e10; farther than any scene in metres */
    const size_t count = (size_t)frame->width * (size_t)frame->height;
    for (size_t i = 0; i < count; i++)
        if (depth[i] >= miss)
            depth[i] = 0;
}

/* pbrt's variance is that of its samples, ours of their mean. */
static void average_variance(const struct fewray_frame *frame, float *variance) {
    const size_t count = (size_t)frame->width * (size_t)frame->height;
    for (size_t i = 0; i < count; i++)
        variance[i] /= (float)frame->spp;
}

/* Blender keeps the background's radiance apart from the surfaces'; our emission is both. */
static void add_background(const struct fewray_frame *frame, struct fewray_plane *emission[3]) {
    struct fewray_plane *background[3];
    if (!find_alias(frame, "Env.", "RGB", true, background) &&
        !find_alias(frame, "Environment.", "RGB", true, background))
        return;
    const size_t count = (size_t)frame->width * (size_t)frame->height;
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < count; i++)
            emission[c]->data[i] += background[c]->data[i];
}

/* pbrt's GBufferFilm has the place of what is seen, in camera space unless the scene says otherwise
 * (then some of it lies behind 0, mostly), instead of the depth. */
static void depth_of_place(struct fewray_frame *frame) {
    struct fewray_plane *place[3];
    const size_t count = (size_t)frame->width * (size_t)frame->height;
    if (!find_alias(frame, "P.", "XYZ", true, place) && !find_alias(frame, "P", "xyz", true, place))
        return;
    const float *p[3] = {place[0]->data, place[1]->data, place[2]->data};
    for (size_t i = 0; i < count; i++)
        if (p[2][i] < 0)
            return;
    float *depth[3];
    if (!fewray_frame_add_layer(frame, FEWRAY_DEPTH, depth))
        return;
    for (size_t i = 0; i < count; i++)
        depth[0][i] = sqrtf(p[0][i] * p[0][i] + p[1][i] * p[1][i] + p[2][i] * p[2][i]);
}

static void adopt(struct fewray_frame *frame, const struct alias *alias) {
    struct fewray_plane *found[3] = {NULL, NULL, NULL};
    int count;
    const char *const *names = fewray_layer_channels(alias->layer, &count);
    if (!find_alias(frame, alias->stem, alias->components, alias->stem[0] != 0, found))
        return;
    if (alias->layer == FEWRAY_VARIANCE && frame->spp < 1)
        return;
    for (int c = 0; c < count; c++) {
        snprintf(found[c]->name, sizeof found[c]->name, "%s", names[c]);
        if (alias->layer == FEWRAY_VARIANCE)
            average_variance(frame, found[c]->data);
    }
    if (alias->layer == FEWRAY_DEPTH)
        mend_depth(frame, found[0]->data);
    if (alias->layer == FEWRAY_EMISSION)
        add_background(frame, found);
}

void adopt_layer_names(struct fewray_frame *frame, enum layer_naming naming) {
    float *planes[3];
    for (size_t i = 0; i < sizeof ALIASES / sizeof *ALIASES; i++) {
        const struct alias *alias = &ALIASES[i];
        if ((naming == NAMING_AUTO || naming == alias->naming) &&
            !fewray_frame_layer(frame, alias->layer, planes))
            adopt(frame, alias);
    }
    if ((naming == NAMING_AUTO || naming == NAMING_PBRT) &&
        !fewray_frame_layer(frame, FEWRAY_DEPTH, planes))
        depth_of_place(frame);
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
