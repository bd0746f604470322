/* SPDX-License-Identifier: Apache-2.0 */
/* Frames: the named float planes of one picture. */
#include "features/features_private.h"

#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 };

/* calloc rather than aligned_alloc and memset: big blocks are zeroed by the system page by page
 * when they are first touched, so that a damaged file that announces a huge picture costs nothing.
 * The block's address is kept just before the aligned data. */
static void *plane_create(size_t bytes) {
    char *block = calloc(1, bytes + 2 * ALIGNMENT);
    if (!block)
        return NULL;
    char *data = block + ALIGNMENT + (ALIGNMENT - (uintptr_t)block % ALIGNMENT) % ALIGNMENT;
    memcpy(data - sizeof block, &block, sizeof block);
    return data;
}

static void plane_destroy(void *data) {
    char *block;
    if (!data)
        return;
    memcpy(&block, (char *)data - sizeof block, sizeof block);
    free(block);
}

int fewray_frame_create(int width, int height, struct fewray_frame **out,
                        struct fewray_error *error) {
    *out = NULL;
    if (!features_size_ok(width, height))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "a picture of %d x %d pixels is impossible, at most %lld pixels are",
                           width, height, (long long)FEATURES_MAX_PIXELS);
    struct fewray_frame *frame = calloc(1, sizeof *frame);
    if (!frame)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "out of memory");
    frame->width = width;
    frame->height = height;
    *out = frame;
    return FEWRAY_OK;
}

void fewray_frame_destroy(struct fewray_frame **frame) {
    if (!*frame)
        return;
    for (size_t i = 0; i < (*frame)->plane_count; i++) {
        plane_destroy((*frame)->planes[i].data);
        plane_destroy((*frame)->planes[i].half);
    }
    free((*frame)->planes);
    for (size_t i = 0; i < (*frame)->attribute_count; i++)
        free((*frame)->attributes[i].text);
    free((*frame)->attributes);
    free(*frame);
    *frame = NULL;
}

static struct fewray_plane *find(const struct fewray_frame *frame, const char *name) {
    for (size_t i = 0; i < frame->plane_count; i++)
        if (strcmp(frame->planes[i].name, name) == 0)
            return &frame->planes[i];
    return NULL;
}

float *fewray_frame_plane(const struct fewray_frame *frame, const char *name) {
    const struct fewray_plane *plane = find(frame, name);
    return plane ? plane->data : NULL;
}

float *fewray_frame_add(struct fewray_frame *frame, const char *name) {
    const struct fewray_plane *known = find(frame, name);
    const size_t length = strlen(name);
    if (known || length == 0 || length >= FEWRAY_NAME_MAX ||
        frame->plane_count >= FEATURES_MAX_CHANNELS)
        return known ? known->data : NULL;
    struct fewray_plane *planes =
        realloc(frame->planes, (frame->plane_count + 1) * sizeof *frame->planes);
    if (!planes)
        return NULL;
    frame->planes = planes;
    float *data = plane_create((size_t)frame->width * (size_t)frame->height * sizeof *data);
    if (!data)
        return NULL;
    struct fewray_plane *plane = &planes[frame->plane_count++];
    memset(plane, 0, sizeof *plane);
    memcpy(plane->name, name, length);
    plane->data = data;
    return data;
}

void fewray_frame_remove(struct fewray_frame *frame, const char *name) {
    struct fewray_plane *plane = find(frame, name);
    if (!plane)
        return;
    plane_destroy(plane->data);
    plane_destroy(plane->half);
    frame->plane_count--;
    memmove(plane, plane + 1, (size_t)(frame->planes + frame->plane_count - plane) * sizeof *plane);
}

static struct fewray_attribute *find_attribute(const struct fewray_frame *frame, const char *name) {
    for (size_t i = 0; i < frame->attribute_count; i++)
        if (!strcmp(frame->attributes[i].name, name))
            return &frame->attributes[i];
    return NULL;
}

const char *fewray_frame_attribute(const struct fewray_frame *frame, const char *name) {
    const struct fewray_attribute *attribute = find_attribute(frame, name);
    return attribute ? attribute->text : NULL;
}

bool fewray_frame_set_attribute(struct fewray_frame *frame, const char *name, const char *text) {
    struct fewray_attribute *attribute = find_attribute(frame, name);
    const size_t length = strlen(name);
    char *copy = length > 0 && length < FEWRAY_NAME_MAX ? strdup(text) : NULL;
    if (!copy)
        return false;
    if (!attribute) {
        struct fewray_attribute *all =
            realloc(frame->attributes, (frame->attribute_count + 1) * sizeof *all);
        if (!all) {
            free(copy);
            return false;
        }
        frame->attributes = all;
        attribute = &all[frame->attribute_count++];
        memset(attribute, 0, sizeof *attribute);
        memcpy(attribute->name, name, length);
    }
    free(attribute->text);
    attribute->text = copy;
    return true;
}

bool fewray_frame_add_layer(struct fewray_frame *frame, enum fewray_layer layer, float *planes[3]) {
    int count;
    const char *const *names = fewray_layer_channels(layer, &count);
    planes[0] = planes[1] = planes[2] = NULL;
    for (int c = 0; c < count; c++)
        if (!(planes[c] = fewray_frame_add(frame, names[c])))
            return false;
    return true;
}

bool fewray_frame_layer(const struct fewray_frame *frame, enum fewray_layer layer,
                        float *planes[3]) {
    int count;
    const char *const *names = fewray_layer_channels(layer, &count);
    float *found[3] = {NULL, NULL, NULL};
    planes[0] = planes[1] = planes[2] = NULL;
    for (int c = 0; c < count; c++)
        if (!(found[c] = fewray_frame_plane(frame, names[c])))
            return false;
    memcpy(planes, found, sizeof found);
    return true;
}

/* --- compact planes */

static bool bits_equal(const float *values, const uint16_t *halves, size_t count) {
    uint32_t differing = 0;
    for (size_t i = 0; i < count; i++) {
        const float value = fewray_half_value(halves[i]);
        uint32_t a, b;
        memcpy(&a, &value, sizeof a);
        memcpy(&b, &values[i], sizeof b);
        differing |= a ^ b;
    }
    return differing == 0;
}

/* Whether halves hold all values exactly; if not, what was written to them is void. */
static bool convert(const float *values, uint16_t *halves, int width, int height) {
    bool exact = true;
#pragma omp parallel for schedule(static) if ((size_t)width * (size_t)height >                     \
                                              FEATURES_PARALLEL_MIN)
    for (int y = 0; y < height; y++) {
        bool still;
#pragma omp atomic read
        still = exact;
        if (!still)
            continue;
        const size_t start = (size_t)y * (size_t)width;
        half_from_floats(values + start, halves + start, (size_t)width);
        if (!bits_equal(values + start, halves + start, (size_t)width)) {
#pragma omp atomic write
            exact = false;
        }
    }
    return exact;
}

void fewray_frame_compact(struct fewray_frame *frame) {
    for (int layer = FEWRAY_VARIANCE; layer < FEWRAY_LAYER_COUNT; layer++) {
        int count;
        const char *const *names = fewray_layer_channels((enum fewray_layer)layer, &count);
        uint16_t *halves[3] = {NULL, NULL, NULL};
        bool exact = true;
        for (int c = 0; c < count && exact; c++) {
            const float *data = fewray_frame_plane(frame, names[c]);
            if (data)
                halves[c] =
                    plane_create((size_t)frame->width * (size_t)frame->height * sizeof *halves[c]);
            exact = halves[c] && convert(data, halves[c], frame->width, frame->height);
        }
        for (int c = 0; c < count; c++) {
            if (!exact) {
                plane_destroy(halves[c]);
                continue;
            }
            struct fewray_plane *plane = find(frame, names[c]);
            plane_destroy(plane->data);
            plane->data = NULL;
            plane->half = halves[c];
        }
    }
}

bool fewray_frame_compact_layer(const struct fewray_frame *frame, enum fewray_layer layer,
                                const uint16_t *planes[3]) {
    int count;
    const char *const *names = fewray_layer_channels(layer, &count);
    planes[0] = planes[1] = planes[2] = NULL;
    for (int c = 0; c < count; c++) {
        const struct fewray_plane *plane = find(frame, names[c]);
        if (!plane || !plane->half) {
            planes[0] = planes[1] = planes[2] = NULL;
            return false;
        }
        planes[c] = plane->half;
    }
    return true;
}
