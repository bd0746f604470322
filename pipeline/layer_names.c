/* SPDX-License-Identifier: Apache-2.0 */
/* Finds layers by the channel names of other renderers and gives them ours. */

#include "pipeline/layer_names.h"
#include "fewray/pipeline.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "pipeline/layer_aliases.h"

const char *const LAYER_NAMINGS[NAMING_COUNT + 1] = {
    "auto", "fewray", "mitsuba", "blender", "pbrt", "arnold", "renderman", "vray", "karma", NULL};

/* Component c of an alias, "R" or "red"; false where there are fewer. */
static bool component(const char *components, int c, char text[16]) {
    const bool words = strchr(components, ',') != NULL;
    if (!words) {
        text[0] = components[0] ? components[c] : 0;
        text[1] = 0;
        return c == 0 || text[0];
    }
    for (; c > 0; c--) {
        const char *comma = strchr(components, ',');
        if (!comma)
            return false;
        components = comma + 1;
    }
    snprintf(text, 16, "%.*s", (int)strcspn(components, ","), components);
    return true;
}

/* The length of what stands before "stem + component" in a plane's name: 0, or a prefix that ends
 * with a dot. -1: the name is another. */
static int prefix_of(const char *name, const char *stem, const char *last) {
    char wanted[FEWRAY_NAME_MAX];
    const int length = snprintf(wanted, sizeof wanted, "%s%s", stem, last);
    const int extra = (int)strlen(name) - length;
    const bool placed = extra == 0 || (extra > 1 && name[extra - 1] == '.');
    return placed && !strcasecmp(name + extra, wanted) ? extra : -1;
}

/* The plane named "prefix + stem + component". */
static struct fewray_plane *find_plane(const struct fewray_frame *frame, const char *prefix,
                                       int prefix_length, const char *stem, const char *last) {
    for (size_t i = 0; i < frame->plane_count; i++) {
        struct fewray_plane *plane = &frame->planes[i];
        if (prefix_of(plane->name, stem, last) == prefix_length &&
            !strncmp(plane->name, prefix, (size_t)prefix_length))
            return plane;
    }
    return NULL;
}

/* What was noisy is kept, and Mitsuba's moment integrator has second moments of each layer. */
static bool is_copy(const char *name) {
    return !strncmp(name, "m2_", 3) || !strncmp(name, "noisy.", 6);
}

/* All channels of an alias, of one and the same view layer or integrator: those without a prefix,
 * else the file's first. */
static bool find_alias(const struct fewray_frame *frame, const char *stem, const char *components,
                       bool prefix, struct fewray_plane *found[3]) {
    char last[16];
    component(components, 0, last);
    for (int pass = 0; pass < (prefix ? 2 : 1); pass++)
        for (size_t i = 0; i < frame->plane_count; i++) {
            const char *name = frame->planes[i].name;
            const int length = prefix_of(name, stem, last);
            if (length < 0 || (length > 0) != (pass > 0) || is_copy(name))
                continue;
            found[0] = &frame->planes[i];
            bool all = true;
            char other[16];
            for (int c = 1; c < 3 && component(components, c, other); c++)
                all = (found[c] = find_plane(frame, name, length, stem, other)) && all;
            if (all)
                return true;
        }
    return false;
}

bool layer_find(const struct fewray_frame *frame, const char *stem, const char *components,
                struct fewray_plane *found[3]) {
    return find_alias(frame, stem, components, true, found);
}

bool layer_find_adopted(const struct fewray_frame *frame, const struct adoption *adoption,
                        const char *stem, struct fewray_plane *found[3]) {
    for (int i = 0; i < FEWRAY_LAYER_COUNT; i++) {
        const struct adopted_layer *layer = &adoption->layers[i];
        int count;
        const char *const *names = fewray_layer_channels((enum fewray_layer)i, &count);
        if (!layer->adopted || count != 3 || prefix_of(layer->names[0], stem, "R") < 0)
            continue;
        bool all = true;
        for (int c = 0; c < 3; c++)
            all = (found[c] = find_plane(frame, "", 0, names[c], "")) && all;
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

/* Whether the picture holds the background as well as *emission (NULLs: none): with a transparent
 * film it doesn't, though the pass may be there. */
static bool is_seen(const struct fewray_frame *frame, float *const emission[3],
                    struct fewray_plane *const background[3]) {
    float *color[3];
    double total = 0, beyond = 0;
    if (!fewray_frame_layer(frame, FEWRAY_COLOR, color))
        return true;
    const size_t count = (size_t)frame->width * (size_t)frame->height;
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < count; i++) {
            const float shines =
                (emission[c] ? emission[c][i] : 0) + background[c]->data[i] - color[c][i];
            total += fabsf(color[c][i]);
            beyond += shines > 0 ? shines : 0;
        }
    return !(beyond > 0.01 * total);
}

/* Others keep the background's radiance apart from the surfaces'; our emission is both. */
static void add_background(const struct fewray_frame *frame, struct adoption *adoption) {
    struct fewray_plane *background[3];
    float *emission[3];
    const char *const *stem = layer_backgrounds();
    while (*stem && !find_alias(frame, *stem, "RGB", true, background))
        stem++;
    if (!*stem || !fewray_frame_layer(frame, FEWRAY_EMISSION, emission) ||
        !is_seen(frame, emission, background))
        return;
    const size_t count = (size_t)frame->width * (size_t)frame->height;
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < count; i++)
            emission[c][i] += background[c]->data[i];
    memcpy(adoption->added, background[0]->name, FEWRAY_NAME_MAX);
}

/* pbrt's GBufferFilm has the place of what is seen, in camera space unless the scene says otherwise
 * (then some of it lies behind 0, mostly), instead of the depth. */
static void depth_of_place(struct fewray_frame *frame, struct adoption *adoption) {
    struct fewray_plane *place[3];
    const size_t count = (size_t)frame->width * (size_t)frame->height;
    if (!find_alias(frame, "P.", "XYZ", true, place) && !find_alias(frame, "P", "xyz", true, place))
        return;
    const float *p[3] = {place[0]->data, place[1]->data, place[2]->data};
    for (size_t i = 0; i < count; i++)
        if (p[2][i] < 0)
            return;
    float *depth[3];
    char name[FEWRAY_NAME_MAX]; /* adding a layer moves the planes, not their data */
    memcpy(name, place[0]->name, sizeof name);
    if (!fewray_frame_add_layer(frame, FEWRAY_DEPTH, depth))
        return;
    for (size_t i = 0; i < count; i++)
        depth[0][i] = sqrtf(p[0][i] * p[0][i] + p[1][i] * p[1][i] + p[2][i] * p[2][i]);
    struct adopted_layer *layer = &adoption->layers[FEWRAY_DEPTH];
    *layer = (struct adopted_layer){.found = true, .adopted = true, .naming = NAMING_PBRT};
    memcpy(layer->names[0], name, sizeof name);
    adoption->depth_of_place = true;
}

/* Alpha that goes with a colour, of one name but for the last letter. */
static void adopt_alpha(struct fewray_frame *frame, const char *color, struct adoption *adoption) {
    char name[FEWRAY_NAME_MAX];
    snprintf(name, sizeof name, "%s", color);
    name[strlen(name) - 1] = name[strlen(name) - 1] == 'r' ? 'a' : 'A';
    if (fewray_frame_plane(frame, "A") || !fewray_frame_plane(frame, name))
        return;
    for (size_t i = 0; i < frame->plane_count; i++)
        if (!strcmp(frame->planes[i].name, name))
            memcpy(frame->planes[i].name, "A", 2);
    memcpy(adoption->alpha, name, sizeof name);
}

/* Blender's noisy picture lies beside the denoised one, which ours is to replace. */
static void find_result(struct fewray_frame *frame, struct adoption *adoption) {
    struct adopted_layer *color = &adoption->layers[FEWRAY_COLOR];
    struct fewray_plane *combined[3];
    memcpy(adoption->result, color->names, sizeof color->names);
    adoption->keeps_noisy = color->adopted && strstr(color->names[0], "Noisy Image.") &&
                            find_alias(frame, "Combined.", "RGB", true, combined);
    for (int c = 0; adoption->keeps_noisy && c < 3; c++)
        memcpy(adoption->result[c], combined[c]->name, FEWRAY_NAME_MAX);
    if (color->adopted)
        adopt_alpha(frame, adoption->result[0], adoption);
}

static void adopt(struct fewray_frame *frame, const struct layer_alias *alias,
                  struct adoption *adoption) {
    struct fewray_plane *found[3] = {NULL, NULL, NULL};
    int count;
    const char *const *names = fewray_layer_channels(alias->layer, &count);
    if (!find_alias(frame, alias->stem, alias->components, alias->stem[0] != 0, found))
        return;
    const bool of_samples = alias->layer == FEWRAY_VARIANCE && alias->naming == NAMING_PBRT;
    if (of_samples && frame->spp < 1)
        return;
    float *const none[3] = {NULL, NULL, NULL};
    if (alias->layer == FEWRAY_EMISSION && alias->naming == NAMING_AUTO &&
        !is_seen(frame, none, found))
        return;
    struct adopted_layer *layer = &adoption->layers[alias->layer];
    layer->found = layer->adopted = true;
    layer->naming = alias->naming;
    for (int c = 0; c < count; c++) {
        memcpy(layer->names[c], found[c]->name, FEWRAY_NAME_MAX);
        snprintf(found[c]->name, sizeof found[c]->name, "%s", names[c]);
        if (of_samples)
            average_variance(frame, found[c]->data);
    }
    if (alias->layer == FEWRAY_DEPTH)
        mend_depth(frame, found[0]->data);
}

/* The layers that have our names already. */
static void find_own(const struct fewray_frame *frame, struct adoption *adoption) {
    float *planes[3];
    for (int i = 0; i < FEWRAY_LAYER_COUNT; i++) {
        int count;
        const char *const *names = fewray_layer_channels((enum fewray_layer)i, &count);
        struct adopted_layer *layer = &adoption->layers[i];
        layer->found = fewray_frame_layer(frame, (enum fewray_layer)i, planes);
        layer->naming = NAMING_FEWRAY;
        for (int c = 0; layer->found && c < count; c++)
            snprintf(layer->names[c], sizeof layer->names[c], "%s", names[c]);
    }
}

static bool is_asked(const struct layer_alias *alias, enum layer_naming naming, bool noisy) {
    if (!noisy && !strcmp(alias->stem, "Noisy Image."))
        return false;
    if (naming == NAMING_AUTO)
        return !alias->only_asked;
    return naming == alias->naming || (alias->naming == NAMING_AUTO && naming != NAMING_FEWRAY);
}

void adopt_layers(struct fewray_frame *frame, enum layer_naming naming, bool noisy,
                  struct adoption *adoption) {
    struct adoption unwanted;
    adoption = adoption ? adoption : &unwanted;
    memset(adoption, 0, sizeof *adoption);
    find_own(frame, adoption);
    int count;
    const struct layer_alias *aliases = layer_aliases(&count);
    for (int i = 0; i < count; i++)
        if (is_asked(&aliases[i], naming, noisy) && !adoption->layers[aliases[i].layer].found)
            adopt(frame, &aliases[i], adoption);
    find_result(frame, adoption);
    if (naming != NAMING_FEWRAY && adoption->layers[FEWRAY_EMISSION].found)
        add_background(frame, adoption);
    if ((naming == NAMING_AUTO || naming == NAMING_PBRT) && !adoption->layers[FEWRAY_DEPTH].found)
        depth_of_place(frame, adoption);
}

void adopt_layer_names(struct fewray_frame *frame, enum layer_naming naming) {
    adopt_layers(frame, naming, true, NULL);
}

void fewray_frame_adopt_names(struct fewray_frame *frame, bool noisy) {
    adopt_layers(frame, NAMING_AUTO, noisy, NULL);
}

const char *adopted_name(const struct adoption *adoption, const char *plane) {
    for (int layer = 0; layer < FEWRAY_LAYER_COUNT; layer++) {
        int count;
        const char *const *names = fewray_layer_channels((enum fewray_layer)layer, &count);
        for (int c = 0; c < count && adoption->layers[layer].found; c++)
            if (!strcmp(names[c], plane))
                return layer == FEWRAY_COLOR ? adoption->result[c]
                                             : adoption->layers[layer].names[c];
    }
    return !strcmp(plane, "A") && adoption->alpha[0] ? adoption->alpha : plane;
}

static int read_layers(const char *path, enum layer_naming naming, bool noisy,
                       struct adoption *adoption, struct fewray_frame **out,
                       struct fewray_error *error) {
    int status = fewray_frame_read_exr(path, out, error);
    if (status)
        return status;
    adopt_layers(*out, naming, noisy, adoption);
    float *color[3];
    if (!fewray_frame_layer(*out, FEWRAY_COLOR, color)) {
        status = fewray_fail(
            error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
            "there are no colour channels R, G, B; `fewray info` lists what the file has");
        fewray_frame_destroy(out);
    }
    return status;
}

int read_picture(const char *path, enum layer_naming naming, struct fewray_frame **out,
                 struct fewray_error *error) {
    return read_layers(path, naming, false, NULL, out, error);
}

int read_noisy_picture(const char *path, enum layer_naming naming, struct adoption *adoption,
                       struct fewray_frame **out, struct fewray_error *error) {
    return read_layers(path, naming, true, adoption, out, error);
}
