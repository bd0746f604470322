/* SPDX-License-Identifier: Apache-2.0 */
/* Frames into OpenEXR files, through OpenEXRCore: one scanline part, ZIP (blocks of 16 lines). */
#include "features/features_private.h"

#include <stdlib.h>
#include <string.h>

#include "features/exr_file.h"
#include "features/zip.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "EXR files are little-endian");

/* What is written. */
struct picture {
    const struct fewray_frame *frame;
    const struct fewray_plane **planes; /* (plane_count), in the order of the file's channels */
    bool float32;
    int lines; /* of a block */
};

/* A thread's block of scanlines: its raw data, as the file has it, and what compresses it. */
struct block {
    struct zip_worker zip;
    uint8_t *raw;
    const uint8_t *packed; /* raw, or in zip */
    size_t packed_size;
};

/* One line of a channel; half floats are clamped to what they hold. Returns the bytes written. */
static size_t put_line(const struct fewray_plane *plane, size_t first, size_t width, bool float32,
                       uint8_t *to) {
    if (!plane->half && float32)
        memcpy(to, plane->data + first, width * sizeof(float));
    else if (!plane->half)
        half_from_floats(plane->data + first, (uint16_t *)(void *)to, width);
    else if (float32)
        half_to_floats(plane->half + first, (float *)(void *)to, width);
    else
        memcpy(to, plane->half + first, width * sizeof(uint16_t));
    return width * (float32 ? sizeof(float) : sizeof(uint16_t));
}

/* Compresses lines y0 <= y < y1, channel by channel in each. */
static exr_result_t encode_block(const struct picture *picture, int y0, int y1,
                                 struct block *block) {
    const struct fewray_frame *frame = picture->frame;
    const size_t width = (size_t)frame->width;
    size_t size = 0;
    if (!block->raw)
        block->raw = malloc(frame->plane_count * width * (size_t)picture->lines * sizeof(float));
    if (!block->raw)
        return EXR_ERR_OUT_OF_MEMORY;
    for (int y = y0; y < y1; y++)
        for (size_t c = 0; c < frame->plane_count; c++)
            size += put_line(picture->planes[c], (size_t)y * width, width, picture->float32,
                             block->raw + size);
    return zip_pack(&block->zip, block->raw, size, &block->packed, &block->packed_size)
               ? EXR_ERR_SUCCESS
               : EXR_ERR_OUT_OF_MEMORY;
}

/* Blocks are compressed by all threads and written by one at a time, in order, so that the file is
 * the same with any number of them. */
static exr_result_t write_blocks(exr_context_t exr, struct picture *picture) {
    const struct fewray_frame *frame = picture->frame;
    const size_t values = frame->plane_count * (size_t)frame->width * (size_t)frame->height;
    exr_result_t result = exr_get_scanlines_per_chunk(exr, 0, &picture->lines);
    if (result != EXR_ERR_SUCCESS)
        return result;
    const int lines = picture->lines;
#pragma omp parallel if (values > FEATURES_PARALLEL_FILE_MIN)
    {
        struct block block = {.raw = NULL};
#pragma omp for ordered schedule(static, 1)
        for (int y = 0; y < frame->height; y += lines) {
            const int end = y + lines < frame->height ? y + lines : frame->height;
            const exr_result_t code = encode_block(picture, y, end, &block);
#pragma omp ordered
            {
                if (result == EXR_ERR_SUCCESS)
                    result = code;
                if (result == EXR_ERR_SUCCESS)
                    result = exr_write_scanline_chunk(exr, 0, y, block.packed, block.packed_size);
            }
        }
        zip_worker_clear(&block.zip);
        free(block.raw);
    }
    return result;
}

static exr_result_t declare_part(exr_context_t exr, const struct fewray_frame *frame,
                                 bool float32) {
    const exr_attr_chromaticities_t rec709 = {0.64f, 0.33f, 0.3f,    0.6f,
                                              0.15f, 0.06f, 0.3127f, 0.329f};
    int part;
    exr_result_t code = exr_set_longname_support(exr, 1);
    if (code == EXR_ERR_SUCCESS)
        code = exr_add_part(exr, "fewray", EXR_STORAGE_SCANLINE, &part);
    if (code == EXR_ERR_SUCCESS)
        code = exr_initialize_required_attr_simple(exr, 0, frame->width, frame->height,
                                                   EXR_COMPRESSION_ZIP);
    for (size_t i = 0; code == EXR_ERR_SUCCESS && i < frame->plane_count; i++)
        code = exr_add_channel(exr, 0, frame->planes[i].name,
                               float32 ? EXR_PIXEL_FLOAT : EXR_PIXEL_HALF,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    if (code == EXR_ERR_SUCCESS)
        code = exr_attr_set_chromaticities(exr, 0, "chromaticities", &rec709);
    if (code == EXR_ERR_SUCCESS)
        code = exr_attr_set_string(exr, 0, "software", "fewray " FEWRAY_VERSION);
    for (size_t i = 0; code == EXR_ERR_SUCCESS && i < frame->attribute_count; i++)
        code = exr_attr_set_string(exr, 0, frame->attributes[i].name, frame->attributes[i].text);
    return code == EXR_ERR_SUCCESS ? exr_write_header(exr) : code;
}

/* The library sorts the file's channels by name. */
static exr_result_t sort_planes(exr_const_context_t exr, struct picture *picture) {
    const struct fewray_frame *frame = picture->frame;
    const exr_attr_chlist_t *channels;
    const exr_result_t code = exr_get_channels(exr, 0, &channels);
    for (int c = 0; code == EXR_ERR_SUCCESS && c < channels->num_channels; c++)
        for (size_t i = 0; i < frame->plane_count; i++)
            if (!strcmp(frame->planes[i].name, channels->entries[c].name.str))
                picture->planes[c] = &frame->planes[i];
    return code;
}

static exr_result_t write_picture(exr_context_t exr, void *user) {
    struct picture *picture = user;
    exr_result_t code = declare_part(exr, picture->frame, picture->float32);
    if (code == EXR_ERR_SUCCESS)
        code = sort_planes(exr, picture);
    return code == EXR_ERR_SUCCESS ? write_blocks(exr, picture) : code;
}

int fewray_frame_write_exr(const struct fewray_frame *frame, const char *path, bool float32,
                           struct fewray_error *error) {
    if (frame->plane_count < 1)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, path, 0, "the picture has no channels");
    struct picture picture = {.frame = frame, .float32 = float32};
    picture.planes = calloc(frame->plane_count, sizeof *picture.planes);
    if (!picture.planes)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    const int status = exr_file_write(path, write_picture, &picture, error);
    free(picture.planes);
    return status;
}
