/* SPDX-License-Identifier: Apache-2.0 */
/* Frames into OpenEXR files, through OpenEXRCore: one scanline part, ZIP (blocks of 16 lines). */
#include "features/features_private.h"

#include <errno.h>
#include <openexr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "EXR files are little-endian");

/* zlib's level: 6 takes up to twice the time for files that are 1 to 5 % smaller. */
enum { ZIP_LEVEL = 4 };

/* What the library's callbacks need to know. */
struct sink {
    int fd;
    int write_errno; /* 0 while all goes well */
    char said[256];  /* the library's first complaint */
};

static void hear_complaint(exr_const_context_t exr, exr_result_t code, const char *text) {
    void *data = NULL;
    (void)code;
    if (exr_get_user_data(exr, &data) != EXR_ERR_SUCCESS || !data)
        return;
    struct sink *sink = data;
#pragma omp critical(fewray_exr_complaint)
    if (!sink->said[0])
        snprintf(sink->said, sizeof sink->said, "%s", text);
}

static int64_t write_bytes(exr_const_context_t exr, void *user_data, const void *bytes,
                           uint64_t size, uint64_t offset, exr_stream_error_func_ptr_t complain) {
    struct sink *sink = user_data;
    if (file_write_all(sink->fd, bytes, (size_t)size, (int64_t)offset))
        return (int64_t)size;
    sink->write_errno = errno;
    complain(exr, EXR_ERR_WRITE_IO, "%s", strerror(errno));
    return -1;
}

/* Replaces the library's conversion, which turns what half can't hold into infinity. */
static exr_result_t pack(exr_encode_pipeline_t *encode) {
    char *to = encode->packed_buffer;
    for (int y = 0; y < encode->chunk.height; y++)
        for (int c = 0; c < encode->channel_count; c++) {
            const exr_coding_channel_info_t *channel = &encode->channels[c];
            const void *line = channel->encode_from_ptr + (ptrdiff_t)y * channel->user_line_stride;
            const size_t width = (size_t)channel->width;
            if (channel->user_data_type == channel->data_type)
                memcpy(to, line, width * (size_t)channel->bytes_per_element);
            else if (channel->data_type == EXR_PIXEL_HALF)
                half_from_floats(line, (uint16_t *)(void *)to, width);
            else
                half_to_floats(line, (float *)(void *)to, width);
            to += width * (size_t)channel->bytes_per_element;
        }
    encode->packed_bytes = (uint64_t)(to - (char *)encode->packed_buffer);
    return EXR_ERR_SUCCESS;
}

/* The pipeline ends at the compressed block, neither waiting for its turn nor writing: blocks are
 * written by one thread at a time, in order. */
static exr_result_t leave_to_caller(exr_encode_pipeline_t *encode) {
    (void)encode;
    return EXR_ERR_SUCCESS;
}

/* A block as long as its raw data is read as raw, but OpenEXRCore 3.1 leaves one compressed that
 * zlib makes exactly so long: without this it would read back as noise. */
static void store_raw_where_no_shorter(exr_encode_pipeline_t *encode) {
    if (encode->compressed_bytes != encode->packed_bytes ||
        encode->compressed_buffer == encode->packed_buffer)
        return;
    memcpy(encode->compressed_buffer, encode->packed_buffer, (size_t)encode->packed_bytes);
}

/* Compresses the block of scanlines that starts at y. encode is used again by the thread's next. */
static exr_result_t encode_block(exr_context_t exr, const struct fewray_frame *frame, int y,
                                 const struct fewray_plane *const *planes,
                                 exr_encode_pipeline_t *encode) {
    const bool first = encode->channels == NULL;
    exr_chunk_info_t chunk;
    exr_result_t code = exr_write_scanline_chunk_info(exr, 0, y, &chunk);
    if (code == EXR_ERR_SUCCESS)
        code = first ? exr_encoding_initialize(exr, 0, &chunk, encode)
                     : exr_encoding_update(exr, 0, &chunk, encode);
    if (code != EXR_ERR_SUCCESS)
        return code;
    for (int c = 0; c < encode->channel_count; c++) {
        exr_coding_channel_info_t *channel = &encode->channels[c];
        const struct fewray_plane *plane = planes[c];
        const int bytes = plane->half ? (int)sizeof *plane->half : (int)sizeof *plane->data;
        const uint8_t *values =
            plane->half ? (const uint8_t *)plane->half : (const uint8_t *)plane->data;
        channel->user_data_type = plane->half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = (int16_t)bytes;
        channel->user_pixel_stride = bytes;
        channel->user_line_stride = frame->width * bytes;
        channel->encode_from_ptr = values + (size_t)y * (size_t)channel->user_line_stride;
    }
    if (first) {
        code = exr_encoding_choose_default_routines(exr, 0, encode);
        encode->convert_and_pack_fn = pack;
        encode->yield_until_ready_fn = leave_to_caller;
        encode->write_fn = leave_to_caller;
    }
    if (code == EXR_ERR_SUCCESS)
        code = exr_encoding_run(exr, 0, encode);
    if (code == EXR_ERR_SUCCESS)
        store_raw_where_no_shorter(encode);
    return code;
}

static exr_result_t write_blocks(exr_context_t exr, const struct fewray_frame *frame,
                                 const struct fewray_plane *const *planes) {
    const size_t values = frame->plane_count * (size_t)frame->width * (size_t)frame->height;
    int lines;
    exr_result_t result = exr_get_scanlines_per_chunk(exr, 0, &lines);
    if (result != EXR_ERR_SUCCESS)
        return result;
#pragma omp parallel if (values > FEATURES_PARALLEL_MIN)
    {
        exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
#pragma omp for ordered schedule(static, 1)
        for (int y = 0; y < frame->height; y += lines) {
            const exr_result_t code = encode_block(exr, frame, y, planes, &encode);
#pragma omp ordered
            {
                if (result == EXR_ERR_SUCCESS)
                    result = code;
                if (result == EXR_ERR_SUCCESS)
                    result = exr_write_scanline_chunk(exr, 0, y, encode.compressed_buffer,
                                                      encode.compressed_bytes);
            }
        }
        exr_encoding_destroy(exr, &encode);
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
    return code == EXR_ERR_SUCCESS ? exr_write_header(exr) : code;
}

/* The frame's planes in the order of the file's channels, which the library sorts by name. */
static exr_result_t sort_planes(exr_const_context_t exr, const struct fewray_frame *frame,
                                const struct fewray_plane **planes) {
    const exr_attr_chlist_t *channels;
    const exr_result_t code = exr_get_channels(exr, 0, &channels);
    for (int c = 0; code == EXR_ERR_SUCCESS && c < channels->num_channels; c++)
        for (size_t i = 0; i < frame->plane_count; i++)
            if (!strcmp(frame->planes[i].name, channels->entries[c].name.str))
                planes[c] = &frame->planes[i];
    return code;
}

static exr_result_t write_frame(const struct fewray_frame *frame, const char *path, bool float32,
                                const struct fewray_plane **planes, struct sink *sink) {
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = hear_complaint;
    settings.user_data = sink;
    settings.write_fn = write_bytes;
    settings.zip_level = ZIP_LEVEL;
    exr_context_t exr = NULL;
    exr_result_t code = exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &settings);
    if (code == EXR_ERR_SUCCESS)
        code = declare_part(exr, frame, float32);
    if (code == EXR_ERR_SUCCESS)
        code = sort_planes(exr, frame, planes);
    if (code == EXR_ERR_SUCCESS)
        code = write_blocks(exr, frame, planes);
    const exr_result_t finished = exr ? exr_finish(&exr) : EXR_ERR_SUCCESS;
    return code == EXR_ERR_SUCCESS ? finished : code;
}

int fewray_frame_write_exr(const struct fewray_frame *frame, const char *path, bool float32,
                           struct fewray_error *error) {
    if (frame->plane_count < 1)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, path, 0, "the picture has no channels");
    const struct fewray_plane **planes = calloc(frame->plane_count, sizeof *planes);
    if (!planes)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    struct sink sink = {.fd = -1};
    char *temporary = NULL;
    int status = sink.fd = file_create_temporary(path, &temporary, error);
    if (sink.fd >= 0) {
        const exr_result_t code = write_frame(frame, path, float32, planes, &sink);
        if (close(sink.fd) != 0 && !sink.write_errno)
            sink.write_errno = errno;
        if (code == EXR_ERR_SUCCESS && !sink.write_errno) {
            status = fewray_commit_file(temporary, path, error);
        } else {
            unlink(temporary);
            status = code == EXR_ERR_OUT_OF_MEMORY ? FEWRAY_ERROR_MEMORY : FEWRAY_ERROR_IO;
            fewray_fail(error, status, path, 0, "can't write the file: %s",
                        sink.write_errno ? strerror(sink.write_errno)
                        : sink.said[0]   ? sink.said
                                         : exr_get_default_error_message(code));
        }
    }
    free(temporary);
    free(planes);
    return status;
}
