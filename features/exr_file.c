/* SPDX-License-Identifier: Apache-2.0 */
/* EXR files as a whole: opened, made, and what goes wrong with them. */
#include "features/exr_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "features/zip.h"

/* Without a handler the library prints to stderr. */
static void hear_complaint(exr_const_context_t exr, exr_result_t code, const char *text) {
    void *data = NULL;
    (void)code;
    if (exr_get_user_data(exr, &data) != EXR_ERR_SUCCESS || !data)
        return;
    struct exr_complaint *complaint = data;
#pragma omp critical(fewray_exr_complaint)
    if (!complaint->text[0])
        snprintf(complaint->text, sizeof complaint->text, "%s", text);
}

int exr_file_fail(struct fewray_error *error, const char *path, exr_result_t code,
                  const struct exr_complaint *complaint) {
    const char *text = complaint->text[0] ? complaint->text : exr_get_default_error_message(code);
    if (code == EXR_ERR_OUT_OF_MEMORY)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    if (code == EXR_ERR_FEATURE_NOT_IMPLEMENTED)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0, "unsupported EXR file: %s",
                           text);
    return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                       "damaged, cut off or not an EXR file: %s", text);
}

int exr_file_open(const char *path, struct exr_complaint *complaint, exr_context_t *out,
                  uint64_t *size, struct fewray_error *error) {
    *out = NULL;
    const int status = file_check_readable(path, size, error);
    if (status != FEWRAY_OK)
        return status;
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = hear_complaint;
    settings.user_data = complaint;
    /* Without this flag, blocks that a cut-off file lacks are searched for instead of reported. */
    settings.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    const exr_result_t code = exr_start_read(out, path, &settings);
    return code == EXR_ERR_SUCCESS ? FEWRAY_OK : exr_file_fail(error, path, code, complaint);
}

bool exr_plane_name(const char *part_name, const char *channel, char name[FEWRAY_NAME_MAX]) {
    const bool layered = !part_name || !part_name[0] || strchr(channel, '.');
    const int length = layered ? snprintf(name, FEWRAY_NAME_MAX, "%s", channel)
                               : snprintf(name, FEWRAY_NAME_MAX, "%s.%s", part_name, channel);
    return channel[0] && length < FEWRAY_NAME_MAX;
}

bool exr_compression_works(exr_compression_t compression) {
    switch (compression) {
    case EXR_COMPRESSION_NONE:
    case EXR_COMPRESSION_RLE:
    case EXR_COMPRESSION_ZIPS:
    case EXR_COMPRESSION_ZIP:
    case EXR_COMPRESSION_PIZ:
    case EXR_COMPRESSION_PXR24:
        return true;
    default:
        return false;
    }
}

/* Blocks as long as their raw data are raw. */
exr_result_t exr_unzip(exr_decode_pipeline_t *decode) {
    if (decode->chunk.packed_size == decode->chunk.unpacked_size)
        return EXR_ERR_SUCCESS;
    switch (zip_unpack(decode->decoding_user_data, decode->packed_buffer, decode->chunk.packed_size,
                       decode->unpacked_buffer, decode->chunk.unpacked_size)) {
    case ZIP_OK:
        return EXR_ERR_SUCCESS;
    case ZIP_NO_MEMORY:
        return EXR_ERR_OUT_OF_MEMORY;
    default:
        return EXR_ERR_CORRUPT_CHUNK;
    }
}

/* --- writing */

/* What the library's callbacks need to know. */
struct sink {
    int fd;
    int write_errno; /* 0 while all goes well */
};

/* The library would print to stderr. What it says can't be kept: it may hold its lock here, which
 * the way to our own data would wait for without end. */
static void ignore_complaint(exr_const_context_t exr, exr_result_t code, const char *text) {
    (void)exr, (void)code, (void)text;
}

static int64_t write_bytes(exr_const_context_t exr, void *user_data, const void *bytes,
                           uint64_t size, uint64_t offset, exr_stream_error_func_ptr_t complain) {
    struct sink *sink = user_data;
    (void)exr, (void)complain;
    if (file_write_all(sink->fd, bytes, (size_t)size, (int64_t)offset))
        return (int64_t)size;
    sink->write_errno = errno;
    return -1;
}

int exr_file_write(const char *path, exr_result_t (*fill)(exr_context_t exr, void *user),
                   void *user, struct fewray_error *error) {
    struct sink sink = {.fd = -1};
    char *temporary = NULL;
    int status = sink.fd = file_create_temporary(path, &temporary, error);
    if (sink.fd < 0)
        return status;
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = ignore_complaint;
    settings.user_data = &sink;
    settings.write_fn = write_bytes;
    exr_context_t exr = NULL;
    exr_result_t code = exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &settings);
    if (code == EXR_ERR_SUCCESS)
        code = fill(exr, user);
    const exr_result_t finished = exr ? exr_finish(&exr) : EXR_ERR_SUCCESS;
    if (code == EXR_ERR_SUCCESS)
        code = finished;
    if (close(sink.fd) != 0 && !sink.write_errno)
        sink.write_errno = errno;
    if (code == EXR_ERR_SUCCESS && !sink.write_errno) {
        status = fewray_commit_file(temporary, path, error);
    } else {
        fewray_discard_file(temporary);
        status = code == EXR_ERR_OUT_OF_MEMORY ? FEWRAY_ERROR_MEMORY : FEWRAY_ERROR_IO;
        fewray_fail(error, status, path, 0, "can't write the file: %s",
                    sink.write_errno ? strerror(sink.write_errno)
                                     : exr_get_default_error_message(code));
    }
    free(temporary);
    return status;
}
