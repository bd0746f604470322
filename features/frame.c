/* SPDX-License-Identifier: Apache-2.0 */
/* Frames: the named float planes of one picture. */
#include "features/features_private.h"

#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 };

/* calloc rather than aligned_alloc and memset: big blocks are zeroed by the system page by page
 * when they are first touched, so that a damaged file that announces a huge picture costs nothing.
 * The block's address is kept just before the aligned data. */
static float *plane_create(size_t values) {
    char *block = calloc(1, values * sizeof(float) + 2 * ALIGNMENT);
    if (!block)
        return NULL;
    char *data = block + ALIGNMENT + (ALIGNMENT - (uintptr_t)block % ALIGNMENT) % ALIGNMENT;
    memcpy(data - sizeof block, &block, sizeof block);
    return (float *)(void *)data;
}

static void plane_destroy(float *data) {
    char *block;
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
    for (size_t i = 0; i < (*frame)->plane_count; i++)
        plane_destroy((*frame)->planes[i].data);
    free((*frame)->planes);
    free(*frame);
    *frame = NULL;
}

float *fewray_frame_plane(const struct fewray_frame *frame, const char *name) {
    for (size_t i = 0; i < frame->plane_count; i++)
        if (strcmp(frame->planes[i].name, name) == 0)
            return frame->planes[i].data;
    return NULL;
}

float *fewray_frame_add(struct fewray_frame *frame, const char *name) {
    float *data = fewray_frame_plane(frame, name);
    const size_t length = strlen(name);
    if (data || length == 0 || length >= FEWRAY_NAME_MAX ||
        frame->plane_count >= FEATURES_MAX_CHANNELS)
        return data;
    struct fewray_plane *planes =
        realloc(frame->planes, (frame->plane_count + 1) * sizeof *frame->planes);
    if (!planes)
        return NULL;
    frame->planes = planes;
    data = plane_create((size_t)frame->width * (size_t)frame->height);
    if (!data)
        return NULL;
    struct fewray_plane *plane = &planes[frame->plane_count++];
    memset(plane, 0, sizeof *plane);
    memcpy(plane->name, name, length);
    plane->data = data;
    return data;
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
