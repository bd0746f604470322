/* SPDX-License-Identifier: Apache-2.0 */
/* Denoising a frame in place: its colour and other layers by their channel names. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "denoise/features_kpn.h"
#include "denoise/run.h"

#define EMISSION_SUFFIX ":emission"
#define SHARED_SUFFIX   ":shared"

static struct fewray_channels frame_layer(const struct fewray_frame *frame,
                                          enum fewray_layer layer) {
    float *planes[3] = {NULL, NULL, NULL};
    const uint16_t *half[3];
    if (fewray_frame_compact_layer(frame, layer, half))
        return (struct fewray_channels){
            .half = {half[0], half[1], half[2]}, .pixel_stride = 1, .row_stride = frame->width};
    if (!fewray_frame_layer(frame, layer, planes))
        return (struct fewray_channels){0};
    if (layer == FEWRAY_DEPTH)
        planes[1] = planes[2] = NULL;
    return fewray_planar(planes, frame->width);
}

static size_t plane_bytes(const struct fewray_frame *frame) {
    return (size_t)frame->width * (size_t)frame->height * sizeof(float);
}

/* What the denoiser reads can't be filtered in place. */
static bool is_read(const char *name) {
    for (int layer = 0; layer < FEWRAY_LAYER_COUNT; layer++) {
        int count;
        const char *const *names = fewray_layer_channels((enum fewray_layer)layer, &count);
        for (int c = 0; c < count; c++)
            if (!strcmp(names[c], name))
                return true;
    }
    return false;
}

/* Makes a layer of `count` planes: what they hold goes to noisy.* and comes back filtered. Adding
 * planes doesn't move the data of others. */
static int take_planes(struct fewray_frame *frame, const char *const names[3], int count,
                       struct fewray_denoise_layer *layer, struct fewray_error *error) {
    float *noisy[3] = {NULL, NULL, NULL};
    for (int c = 0; c < count; c++) {
        char name[FEWRAY_NAME_MAX + 8];
        snprintf(name, sizeof name, "noisy.%s", names[c]);
        if (strlen(name) >= FEWRAY_NAME_MAX)
            return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, NULL, 0,
                               "the channel's name %s is too long to denoise it", names[c]);
        if (!(noisy[c] = fewray_frame_add(frame, name)))
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                               "no memory for the denoised picture");
        layer->out[c] = fewray_frame_plane(frame, names[c]);
        memcpy(noisy[c], layer->out[c], plane_bytes(frame));
    }
    layer->in = fewray_planar(noisy, frame->width);
    layer->out_pixel_stride = 1;
    layer->out_row_stride = frame->width;
    return FEWRAY_OK;
}

/* The other way round: the frame is as it was. */
static void give_back(struct fewray_frame *frame, const struct fewray_denoise_layer *layer) {
    for (int c = 0; c < 3; c++) {
        const float *noisy = layer->in.channel[c];
        if (!noisy)
            continue;
        memcpy(layer->out[c], noisy, plane_bytes(frame));
        for (size_t i = 0; i < frame->plane_count; i++)
            if (frame->planes[i].data == noisy) {
                fewray_frame_remove(frame, frame->planes[i].name);
                break;
            }
    }
}

static bool ends_with(const char *text, const char *suffix) {
    const size_t length = strlen(text), end = strlen(suffix);
    return length >= end && !strcmp(text + length - end, suffix);
}

/* NAME, NAME:emission or NAME:shared. */
static int take_named(struct fewray_frame *frame, const char *text,
                      struct fewray_denoise_layer *layer, struct fewray_error *error) {
    char name[FEWRAY_NAME_MAX], channels[3][FEWRAY_NAME_MAX + 2];
    const char *const names[3] = {channels[0], channels[1], channels[2]};
    const bool inside = ends_with(text, EMISSION_SUFFIX), shared = ends_with(text, SHARED_SUFFIX);
    const bool marked = inside || shared;
    const size_t length = strlen(text) - (inside   ? strlen(EMISSION_SUFFIX)
                                          : shared ? strlen(SHARED_SUFFIX)
                                                   : 0);
    snprintf(name, sizeof name, "%.*s", (int)length, text);
    bool complete = true;
    for (int c = 0; c < 3; c++) {
        snprintf(channels[c], sizeof channels[c], "%s.%c", name, "RGB"[c]);
        complete = complete && fewray_frame_plane(frame, channels[c]);
    }
    if (is_read(channels[0]) || is_read(name))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "%s isn't a layer to denoise: the denoiser itself needs it", name);
    if (length < sizeof name && complete) {
        const struct fewray_channels emission = frame_layer(frame, FEWRAY_EMISSION);
        if (inside || (!shared && !strcmp(name, "direct")))
            layer->emission = FEWRAY_EMISSION_INSIDE;
        else if (shared || !kpn_has(&emission))
            layer->emission = FEWRAY_EMISSION_SHARED;
        return take_planes(frame, names, 3, layer, error);
    }
    const char *const single[3] = {name, NULL, NULL};
    layer->coverage = true;
    if (length < sizeof name && !marked && fewray_frame_plane(frame, name))
        return take_planes(frame, single, 1, layer, error);
    return fewray_fail(error, FEWRAY_ERROR_FORMAT, NULL, 0,
                       "the picture has no layer %s.R, %s.G, %s.B to denoise", name, name, name);
}

/* Alpha, where there is anything to filter. */
static int take_alpha(struct fewray_frame *frame, struct fewray_denoise_layer *layer, int *count,
                      struct fewray_error *error) {
    static const char *const names[3] = {"A", NULL, NULL};
    const float *alpha = fewray_frame_plane(frame, "A");
    const size_t pixels = plane_bytes(frame) / sizeof(float);
    size_t i = 0;
    while (alpha && i < pixels && alpha[i] == 1.0f)
        i++;
    if (!alpha || i == pixels)
        return FEWRAY_OK;
    layer[*count].coverage = true;
    return take_planes(frame, names, 1, &layer[(*count)++], error);
}

/* Alpha and the named layers; a name that comes twice is taken once. */
static int take_layers(struct fewray_frame *frame, const char *const *names, int name_count,
                       struct fewray_denoise_layer *layers, int *count,
                       struct fewray_error *error) {
    int status = FEWRAY_OK;
    bool alpha = false;
    for (int i = 0; i < name_count && !status; i++) {
        bool again = false;
        for (int k = 0; k < i; k++)
            again |= !strcmp(names[i], names[k]);
        alpha |= !strcmp(names[i], "A");
        if (!again)
            status = take_named(frame, names[i], &layers[(*count)++], error);
    }
    return status || alpha ? status : take_alpha(frame, layers, count, error);
}

static void copy_channels(const struct fewray_denoise_input *in, const struct fewray_channels *from,
                          float *const to[3]) {
    for (int c = 0; c < 3; c++)
        for (int y = 0; y < in->height; y++)
            for (int x = 0; x < in->width; x++)
                to[c][(size_t)y * (size_t)in->width + (size_t)x] = kpn_value(from, c, y, x);
}

/* The filtered planes of a frame become their mean over the frames so far. */
static int join_history(struct fewray_denoise_history *history,
                        const struct fewray_denoise_motion *motion,
                        const struct fewray_denoise_input *noisy, float *const color[3],
                        struct fewray_denoise_layer *layers, struct fewray_error *error) {
    struct fewray_denoise_input in = *noisy, out;
    in.color = fewray_planar(color, in.width);
    for (int k = 0; k < in.layer_count; k++)
        if (!layers[k].coverage)
            layers[k].in = fewray_planar(layers[k].out, in.width);
    const int status = fewray_denoise_history_add(history, &in, motion, &out, error);
    if (status)
        return status;
    copy_channels(&in, &out.color, color);
    for (int k = 0; k < in.layer_count; k++)
        if (!layers[k].coverage)
            copy_channels(&in, &out.layers[k].in, layers[k].out);
    return FEWRAY_OK;
}

int fewray_denoise_frame_after(struct fewray_denoiser *denoiser,
                               struct fewray_denoise_history *history,
                               const struct fewray_denoise_motion *motion,
                               struct fewray_frame *frame, const char *const *names, int name_count,
                               struct fewray_denoise_stats *stats, struct fewray_error *error) {
    static const char *const rgb[3] = {"R", "G", "B"};
    struct fewray_denoise_input in = {
        .width = frame->width,
        .height = frame->height,
        .variance = frame_layer(frame, FEWRAY_VARIANCE),
        .albedo = frame_layer(frame, FEWRAY_ALBEDO),
        .shaded_albedo = frame_layer(frame, FEWRAY_SHADED_ALBEDO),
        .normal = frame_layer(frame, FEWRAY_NORMAL),
        .emission = frame_layer(frame, FEWRAY_EMISSION),
        .depth = frame_layer(frame, FEWRAY_DEPTH),
        .irradiance = frame_layer(frame, FEWRAY_IRRADIANCE),
        .confidence = frame_layer(frame, FEWRAY_IRRADIANCE_CONFIDENCE),
    };
    float *color[3];
    if (!fewray_frame_layer(frame, FEWRAY_COLOR, color))
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, NULL, 0,
                           "the picture has no R, G, B to denoise");
    struct fewray_denoise_layer beauty = {0};
    struct fewray_denoise_layer *layers = calloc((size_t)name_count + 1, sizeof *layers);
    int status = layers ? FEWRAY_OK
                        : fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                                      "no memory for the denoised picture");
    /* The frame's own planes are all the memory that the pictures need. */
    if (!status)
        status = take_planes(frame, rgb, 3, &beauty, error);
    if (!status)
        status = take_layers(frame, names, name_count, layers, &in.layer_count, error);
    if (!status) {
        const struct kpn_output out = {{color[0], color[1], color[2]}, 1, frame->width};
        in.color = beauty.in;
        in.layers = layers;
        status = denoiser_run_to(denoiser, &in, &out, stats, error);
        if (!status && history)
            status = join_history(history, motion, &in, color, layers, error);
    }
    if (status && beauty.in.channel[0])
        give_back(frame, &beauty);
    for (int k = 0; status && k < in.layer_count; k++)
        give_back(frame, &layers[k]);
    free(layers);
    return status;
}

int fewray_denoise_frame_layers(struct fewray_denoiser *denoiser, struct fewray_frame *frame,
                                const char *const *names, int name_count,
                                struct fewray_denoise_stats *stats, struct fewray_error *error) {
    return fewray_denoise_frame_after(denoiser, NULL, NULL, frame, names, name_count, stats, error);
}

int fewray_denoise_frame(struct fewray_denoiser *denoiser, struct fewray_frame *frame,
                         struct fewray_denoise_stats *stats, struct fewray_error *error) {
    return fewray_denoise_frame_layers(denoiser, frame, NULL, 0, stats, error);
}
