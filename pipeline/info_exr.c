/* SPDX-License-Identifier: Apache-2.0 */
/* An EXR as a denoiser sees it. */

#include "pipeline/info_exr.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pipeline/pass_sums.h"

/* What the denoiser looks for, and what it does without. */
static const struct {
    enum fewray_layer layer;
    const char *name, *without;
} LAYERS[] = {
    {FEWRAY_COLOR, "beauty", "nothing can be denoised"},
    {FEWRAY_ALBEDO, "albedo", "textures are filtered with the light and may blur"},
    {FEWRAY_NORMAL, "normal", "edges and bumps of one colour may blur"},
    {FEWRAY_DEPTH, "depth", "edges between parallel surfaces may blur"},
    {FEWRAY_VARIANCE, "variance", "the noise is judged by the picture itself"},
    {FEWRAY_EMISSION, "emission", "lamps and windows are guessed from bright, black surfaces"},
};
enum { LAYER_LINES = (int)(sizeof LAYERS / sizeof *LAYERS) };

struct subject {
    const char *path;
    struct fewray_exr_header *header;
    struct fewray_frame *frame;
    struct adoption adoption;
    struct pass_sums sums;
    size_t channel_count;
    char (*names)[FEWRAY_NAME_MAX]; /* of the planes before they were adopted */
};

struct values {
    double least, mean, most;
    size_t finite, others;
};

static struct values values_of(const float *data, size_t count) {
    struct values values = {INFINITY, 0, -INFINITY, 0, 0};
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(data[i]))
            continue;
        values.finite++;
        values.mean += data[i];
        values.least = fmin(values.least, data[i]);
        values.most = fmax(values.most, data[i]);
    }
    values.others = count - values.finite;
    values.mean /= values.finite ? (double)values.finite : 1;
    return values;
}

static const char *naming_text(enum layer_naming naming) {
    return naming == NAMING_AUTO ? "common" : LAYER_NAMINGS[naming];
}

/* Whether denoising uses the channel or changes it. */
static bool is_used(const struct subject *subject, const char *name) {
    const struct adoption *adoption = &subject->adoption;
    for (int i = 0; i < FEWRAY_LAYER_COUNT; i++)
        for (int c = 0; c < 3; c++)
            if (!strcmp(name, adoption->layers[i].names[c]))
                return true;
    for (int c = 0; c < 3; c++)
        if (!strcmp(name, adoption->result[c]))
            return true;
    for (int s = 0; s < subject->sums.count; s++)
        for (int k = 0; k < subject->sums.sums[s].count; k++)
            for (int c = 0; c < 3; c++)
                if (!strcmp(name, subject->sums.sums[s].passes[k].channels[c]))
                    return true;
    return !strcmp(name, "A") || !strcmp(name, adoption->alpha) || !strcmp(name, adoption->added);
}

/* "ViewLayer.Depth" of "ViewLayer.Depth.Z"; a bare channel is its own layer. */
static void layer_of(const char *channel, char layer[FEWRAY_NAME_MAX]) {
    const char *dot = strrchr(channel, '.');
    snprintf(layer, FEWRAY_NAME_MAX, "%.*s", dot ? (int)(dot - channel) : FEWRAY_NAME_MAX - 1,
             channel);
}

/* Calls each layer that isn't used, once. */
static void each_other(const struct subject *subject, void (*take)(void *, const char *),
                       void *user) {
    char before[FEWRAY_NAME_MAX] = "";
    for (size_t i = 0; i < subject->channel_count; i++) {
        char layer[FEWRAY_NAME_MAX];
        if (is_used(subject, subject->names[i]))
            continue;
        layer_of(subject->names[i], layer);
        if (strcmp(layer, before))
            take(user, layer);
        memcpy(before, layer, sizeof before);
    }
}

/* --- text */

static void print_channels(const struct subject *subject) {
    const size_t count = (size_t)subject->frame->width * (size_t)subject->frame->height;
    printf("  %-24s %12s %12s %12s %12s\n", "channel", "min", "mean", "max", "non-finite");
    for (size_t i = 0; i < subject->channel_count; i++) {
        const struct values values = values_of(subject->frame->planes[i].data, count);
        if (values.finite)
            printf("  %-24s %12.5g %12.5g %12.5g", subject->names[i], values.least, values.mean,
                   values.most);
        else
            printf("  %-24s %12s %12s %12s", subject->names[i], "-", "-", "-");
        printf(" %12zu\n", values.others);
    }
}

static void print_layers(const struct subject *subject) {
    const struct adoption *adoption = &subject->adoption;
    printf("for the denoiser:\n");
    for (int i = 0; i < LAYER_LINES; i++) {
        const struct adopted_layer *layer = &adoption->layers[LAYERS[i].layer];
        printf("  %-10s ", LAYERS[i].name);
        if (!layer->found) {
            printf("missing: %s\n", LAYERS[i].without);
            continue;
        }
        for (int c = 0; c < 3 && layer->names[c][0]; c++)
            printf("%s%s", c ? ", " : "", layer->names[c]);
        printf(" (%s names)", naming_text(layer->naming));
        if (LAYERS[i].layer == FEWRAY_COLOR && adoption->keeps_noisy)
            printf("; the result replaces %s", adoption->result[0]);
        if (LAYERS[i].layer == FEWRAY_EMISSION && adoption->added[0])
            printf(", and %s", adoption->added);
        if (LAYERS[i].layer == FEWRAY_DEPTH && adoption->depth_of_place)
            printf("; the length of the place in camera space");
        putchar('\n');
    }
}

static void print_sums(const struct subject *subject) {
    for (int s = 0; s < subject->sums.count; s++) {
        const struct pass_sum *sum = &subject->sums.sums[s];
        if (sum->holds)
            printf("  %-10s sum of %d %s%s equals the picture to %.2g %%; `--aov auto` filters "
                   "them\n",
                   "passes", sum->count, sum->count == 1 ? "pass" : "passes",
                   sum->emission ? " and the emission" : "", fmax(100 * sum->error, 0.01));
        else
            printf("  %-10s sum of %d %s%s is %.2g %% off the picture: passes are missing, or "
                   "aren't parts of it\n",
                   "passes", sum->count, sum->count == 1 ? "pass" : "passes",
                   sum->emission ? " and the emission" : "", 100 * sum->error);
        printf("  %-10s (%s, %s names):", "", sum->what, naming_text(sum->naming));
        for (int k = 0; k < sum->count; k++) {
            char layer[FEWRAY_NAME_MAX];
            layer_of(sum->passes[k].channels[0], layer);
            printf("%s %s%s", k ? "," : "", layer,
                   sum->passes[k].color[0] ? " (times colour)" : "");
        }
        putchar('\n');
    }
}

static void print_other(void *user, const char *layer) {
    int *count = user;
    printf("%s %s", (*count)++ ? "," : "kept as they are:", layer);
}

/* Attributes of all parts; of equal ones the first part's. */
static bool is_told(const struct fewray_exr_header *header, int part, int attribute) {
    const struct fewray_exr_attribute *this = &header->parts[part].attributes[attribute];
    for (int p = 0; p < part; p++)
        for (int a = 0; a < header->parts[p].attribute_count; a++)
            if (!strcmp(this->name, header->parts[p].attributes[a].name) &&
                !strcmp(this->text, header->parts[p].attributes[a].text))
                return true;
    return false;
}

static void print_text(const char *text) {
    int column = 0;
    for (; *text && column < 100; text++, column++)
        putchar((unsigned char)*text < ' ' ? ' ' : *text);
    puts(*text ? "..." : "");
}

static void print_metadata(const struct subject *subject) {
    const struct fewray_exr_header *header = subject->header;
    printf("metadata:\n");
    for (int p = 0; p < header->part_count; p++)
        for (int a = 0; a < header->parts[p].attribute_count; a++) {
            if (is_told(header, p, a))
                continue;
            printf("  %-24s ", header->parts[p].attributes[a].name);
            print_text(header->parts[p].attributes[a].text);
        }
}

static void print_file(const struct subject *subject) {
    const struct fewray_exr_part *first = &subject->header->parts[0];
    printf("%s: EXR, %dx%d pixels, %zu channels", subject->path, subject->frame->width,
           subject->frame->height, subject->channel_count);
    if (subject->header->part_count > 1)
        printf(" in %d parts", subject->header->part_count);
    printf(", %s%s\n", first->compression, first->tiled ? ", tiled" : "");
    if (memcmp(first->data_window, first->display_window, sizeof first->data_window))
        printf("  data window %d..%d, %d..%d of the picture %d..%d, %d..%d\n",
               first->data_window[0], first->data_window[2], first->data_window[1],
               first->data_window[3], first->display_window[0], first->display_window[2],
               first->display_window[1], first->display_window[3]);
    print_channels(subject);
    print_layers(subject);
    print_sums(subject);
    int others = 0;
    each_other(subject, print_other, &others);
    if (others)
        putchar('\n');
    print_metadata(subject);
}

/* --- JSON */

static json_t *json_layers(const struct subject *subject) {
    json_t *layers = json_object();
    for (int i = 0; i < LAYER_LINES; i++) {
        const struct adopted_layer *layer = &subject->adoption.layers[LAYERS[i].layer];
        json_t *channels = json_array();
        for (int c = 0; c < 3 && layer->found && layer->names[c][0]; c++)
            json_array_append_new(channels, json_string(layer->names[c]));
        json_object_set_new(layers, LAYERS[i].name,
                            layer->found ? json_pack("{s:o,s:s}", "channels", channels, "names",
                                                     naming_text(layer->naming))
                                         : json_null());
        if (!layer->found)
            json_decref(channels);
    }
    return layers;
}

static json_t *json_sums(const struct subject *subject) {
    json_t *sums = json_array();
    for (int s = 0; s < subject->sums.count; s++) {
        const struct pass_sum *sum = &subject->sums.sums[s];
        json_t *passes = json_array();
        for (int k = 0; k < sum->count; k++) {
            char layer[FEWRAY_NAME_MAX];
            layer_of(sum->passes[k].channels[0], layer);
            json_array_append_new(passes, json_string(layer));
        }
        json_array_append_new(
            sums, json_pack("{s:s,s:s,s:o,s:b,s:b,s:o}", "what", sum->what, "names",
                            naming_text(sum->naming), "passes", passes, "emission", sum->emission,
                            "equals_picture", sum->holds, "relative_error",
                            isfinite(sum->error) ? json_real(sum->error) : json_null()));
    }
    return sums;
}

static void add_other(void *user, const char *layer) {
    json_array_append_new(user, json_string(layer));
}

static json_t *json_metadata(const struct subject *subject) {
    const struct fewray_exr_header *header = subject->header;
    json_t *metadata = json_object();
    for (int p = 0; p < header->part_count; p++)
        for (int a = 0; a < header->parts[p].attribute_count; a++) {
            const struct fewray_exr_attribute *attribute = &header->parts[p].attributes[a];
            json_t *text = json_string(attribute->text);
            if (text && !json_object_get(metadata, attribute->name)) /* NULL: not UTF-8 */
                json_object_set_new(metadata, attribute->name, text);
            else
                json_decref(text);
        }
    return metadata;
}

static void print_json(const struct subject *subject) {
    const size_t count = (size_t)subject->frame->width * (size_t)subject->frame->height;
    json_t *channels = json_array(), *others = json_array();
    for (size_t i = 0; i < subject->channel_count; i++) {
        const struct values v = values_of(subject->frame->planes[i].data, count);
        json_t *channel =
            json_pack("{s:s,s:I}", "name", subject->names[i], "non_finite", (json_int_t)v.others);
        if (channel && v.finite) {
            json_object_set_new(channel, "min", json_real(v.least));
            json_object_set_new(channel, "mean", json_real(v.mean));
            json_object_set_new(channel, "max", json_real(v.most));
        }
        json_array_append_new(channels, channel);
    }
    each_other(subject, add_other, others);
    json_t *object = json_pack(
        "{s:i,s:i,s:i,s:s,s:o,s:o,s:o,s:o,s:o}", "width", subject->frame->width, "height",
        subject->frame->height, "parts", subject->header->part_count, "compression",
        subject->header->parts[0].compression, "channels", channels, "layers", json_layers(subject),
        "sums", json_sums(subject), "others", others, "metadata", json_metadata(subject));
    json_dumpf(object, stdout, JSON_INDENT(2));
    putchar('\n');
    json_decref(object);
}

int info_exr(const char *path, bool as_json, struct fewray_error *error) {
    struct subject *subject = calloc(1, sizeof *subject);
    if (!subject)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    subject->path = path;
    int status = fewray_frame_read_exr(path, &subject->frame, error);
    if (!status)
        status = fewray_exr_header_read(path, &subject->header, error);
    if (!status) {
        struct fewray_frame *frame = subject->frame;
        subject->channel_count = frame->plane_count;
        subject->names = calloc(frame->plane_count + 1, sizeof *subject->names);
        for (size_t i = 0; subject->names && i < frame->plane_count; i++)
            memcpy(subject->names[i], frame->planes[i].name, FEWRAY_NAME_MAX);
        if (!subject->names)
            status = fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    }
    if (!status) {
        adopt_layers(subject->frame, NAMING_AUTO, true, &subject->adoption);
        pass_sums_find(subject->frame, &subject->adoption, NAMING_AUTO, false, &subject->sums);
        as_json ? print_json(subject) : print_file(subject);
    }
    free(subject->names);
    fewray_exr_header_destroy(&subject->header);
    fewray_frame_destroy(&subject->frame);
    free(subject);
    return status;
}
