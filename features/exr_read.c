/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR files into frames, through OpenEXRCore (the C API of OpenEXR 3.1 and later). */
#include "features/features_private.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "features/exr_file.h"
#include "features/zip.h"

/* Where the chunks (blocks of scanlines, or tiles) of the part lie in the frame. */
struct chunk_grid {
    exr_const_context_t exr;
    int part;
    const struct fewray_frame *frame;
    float *const *planes; /* one a channel, in the file's order */
    bool tiled, zip;
    int min_y;                     /* of the data window */
    int chunk_width, chunk_height; /* pixels; those at the right and bottom edges may be smaller */
    int chunk_columns, chunk_rows;
};

/* Adds a plane for each channel; planes[] has room for all. What an earlier part already has (the
 * other eye's picture, say) gets no plane. */
static int add_channels(const exr_attr_chlist_t *channels, const char *part_name, const char *path,
                        struct fewray_frame *frame, float **planes, struct fewray_error *error) {
    for (int c = 0; c < channels->num_channels; c++) {
        const exr_attr_chlist_entry_t *channel = &channels->entries[c];
        char name[FEWRAY_NAME_MAX];
        if (channel->x_sampling != 1 || channel->y_sampling != 1)
            return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                               "channel %s is subsampled, store it at full resolution",
                               channel->name.str);
        if (!exr_plane_name(part_name, channel->name.str, name))
            return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                               "the channel name '%.80s' is empty or longer than %d bytes",
                               channel->name.str, FEWRAY_NAME_MAX - 1);
        if (fewray_frame_plane(frame, name))
            continue;
        planes[c] = fewray_frame_add(frame, name);
        if (!planes[c])
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0,
                               "out of memory for %d channels of %d x %d pixels",
                               channels->num_channels, frame->width, frame->height);
    }
    return FEWRAY_OK;
}

static exr_result_t plan_chunks(struct chunk_grid *grid) {
    const int width = grid->frame->width, height = grid->frame->height;
    exr_result_t code;
    if (grid->tiled) {
        code = exr_get_tile_sizes(grid->exr, grid->part, 0, 0, &grid->chunk_width,
                                  &grid->chunk_height);
    } else {
        grid->chunk_width = width;
        code = exr_get_scanlines_per_chunk(grid->exr, grid->part, &grid->chunk_height);
    }
    if (code != EXR_ERR_SUCCESS)
        return code;
    if (grid->chunk_width < 1 || grid->chunk_height < 1)
        return EXR_ERR_INVALID_ATTR;
    grid->chunk_columns = (width - 1) / grid->chunk_width + 1;
    grid->chunk_rows = (height - 1) / grid->chunk_height + 1;
    return EXR_ERR_SUCCESS;
}

/* Decodes the chunk at (column, row) of the grid into the planes. decode is used again by the
 * thread's next chunk. */
static exr_result_t read_chunk(const struct chunk_grid *grid, int column, int row,
                               exr_decode_pipeline_t *decode, struct zip_worker *zip) {
    const int x = column * grid->chunk_width, y = row * grid->chunk_height;
    const int width = grid->frame->width, height = grid->frame->height;
    const bool first = decode->channels == NULL;
    exr_chunk_info_t chunk;
    exr_result_t code =
        grid->tiled ? exr_read_tile_chunk_info(grid->exr, grid->part, column, row, 0, 0, &chunk)
                    : exr_read_scanline_chunk_info(grid->exr, grid->part, grid->min_y + y, &chunk);
    if (code != EXR_ERR_SUCCESS)
        return code;
    if (chunk.width < 1 || chunk.height < 1 || chunk.width > width - x || chunk.height > height - y)
        return EXR_ERR_CORRUPT_CHUNK;
    code = first ? exr_decoding_initialize(grid->exr, grid->part, &chunk, decode)
                 : exr_decoding_update(grid->exr, grid->part, &chunk, decode);
    if (code != EXR_ERR_SUCCESS)
        return code;
    for (int c = 0; c < decode->channel_count; c++) {
        exr_coding_channel_info_t *channel = &decode->channels[c];
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = width * (int)sizeof(float);
        channel->decode_to_ptr = (uint8_t *)(grid->planes[c] + (size_t)y * (size_t)width + x);
    }
    if (first)
        code = exr_decoding_choose_default_routines(grid->exr, grid->part, decode);
    if (first && grid->zip) {
        decode->decompress_fn = exr_unzip;
        decode->decoding_user_data = zip;
    }
    return code == EXR_ERR_SUCCESS ? exr_decoding_run(grid->exr, grid->part, decode) : code;
}

/* Chunks are independent of each other: each thread takes whole ones. */
static exr_result_t read_chunks(const struct chunk_grid *grid) {
    const int64_t count = (int64_t)grid->chunk_columns * grid->chunk_rows;
    const size_t values =
        grid->frame->plane_count * (size_t)grid->frame->width * (size_t)grid->frame->height;
    exr_result_t result = EXR_ERR_SUCCESS;
#pragma omp parallel if (values > FEATURES_PARALLEL_FILE_MIN)
    {
        exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
        struct zip_worker zip = {.compressor = NULL};
#pragma omp for schedule(dynamic, 1)
        for (int64_t i = 0; i < count; i++) {
            exr_result_t known;
#pragma omp atomic read
            known = result;
            if (known != EXR_ERR_SUCCESS)
                continue;
            const exr_result_t code = read_chunk(grid, (int)(i % grid->chunk_columns),
                                                 (int)(i / grid->chunk_columns), &decode, &zip);
            if (code != EXR_ERR_SUCCESS) {
#pragma omp atomic write
                result = code;
            }
        }
        exr_decoding_destroy(grid->exr, &decode);
        zip_worker_clear(&zip);
    }
    return result;
}

/* What the header says of a part, checked before anything is allocated from it. */
struct part {
    int index;
    const char *name; /* NULL where the file has one part: it's no layer's name then */
    exr_storage_t storage;
    exr_compression_t compression;
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *channels;
    int width, height;
};

static int read_header(exr_const_context_t exr, const char *path,
                       const struct exr_complaint *complaint, struct part *part,
                       struct fewray_error *error) {
    exr_result_t code = exr_get_storage(exr, part->index, &part->storage);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_data_window(exr, part->index, &part->window);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_channels(exr, part->index, &part->channels);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_compression(exr, part->index, &part->compression);
    if (code != EXR_ERR_SUCCESS)
        return exr_file_fail(error, path, code, complaint);
    if (part->storage != EXR_STORAGE_SCANLINE && part->storage != EXR_STORAGE_TILED)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                           "deep pictures aren't supported, flatten it first");
    const int64_t width = (int64_t)part->window.max.x - part->window.min.x + 1;
    const int64_t height = (int64_t)part->window.max.y - part->window.min.y + 1;
    if (!features_size_ok(width, height))
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                           "a data window of %lld x %lld pixels is impossible", (long long)width,
                           (long long)height);
    part->width = (int)width;
    part->height = (int)height;
    const int channels = part->channels->num_channels;
    if (channels < 1 || channels > FEATURES_MAX_CHANNELS)
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0, "%d channels; 1 to %d are possible",
                           channels, FEATURES_MAX_CHANNELS);
    return FEWRAY_OK;
}

/* OpenEXRCore would write to NULL for a channel that isn't wanted: such ones share a spare plane,
 * which the caller frees. */
static int spare_plane(const struct fewray_frame *frame, float **planes, int count, float **spare,
                       const char *path, struct fewray_error *error) {
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    for (int c = 0; c < count; c++) {
        if (planes[c])
            continue;
        if (!*spare && !(*spare = malloc(pixels * sizeof(float))))
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
        planes[c] = *spare;
    }
    return FEWRAY_OK;
}

/* Adds the pixels of a part to the frame. */
static int read_pixels(exr_const_context_t exr, const struct part *part, const char *path,
                       const struct exr_complaint *complaint, struct fewray_frame *frame,
                       struct fewray_error *error) {
    if (frame->plane_count + (size_t)part->channels->num_channels > FEATURES_MAX_CHANNELS)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0, "more than %d channels",
                           FEATURES_MAX_CHANNELS);
    const int count = part->channels->num_channels;
    float *spare = NULL, **planes = calloc((size_t)count, sizeof *planes);
    if (!planes)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    int status = add_channels(part->channels, part->name, path, frame, planes, error);
    if (status == FEWRAY_OK)
        status = spare_plane(frame, planes, count, &spare, path, error);
    if (status == FEWRAY_OK) {
        struct chunk_grid grid = {.exr = exr,
                                  .part = part->index,
                                  .frame = frame,
                                  .planes = planes,
                                  .tiled = part->storage == EXR_STORAGE_TILED,
                                  .zip = part->compression == EXR_COMPRESSION_ZIP ||
                                         part->compression == EXR_COMPRESSION_ZIPS,
                                  .min_y = part->window.min.y};
        exr_result_t code = plan_chunks(&grid);
        if (code == EXR_ERR_SUCCESS)
            code = read_chunks(&grid);
        if (code != EXR_ERR_SUCCESS)
            status = exr_file_fail(error, path, code, complaint);
    }
    free(spare);
    free(planes);
    return status;
}

/* Bytes of the part's raw pixels. */
static double raw_bytes(const struct part *part) {
    double pixel = 0;
    for (int c = 0; c < part->channels->num_channels; c++)
        pixel += part->channels->entries[c].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
    return pixel * part->width * part->height;
}

/* Raw bytes that one byte of the file may hold at most. */
static double greatest_ratio(exr_compression_t compression) {
    /* DWA: blocks of 64 half floats as one, deflated. */
    return exr_compression_works(compression) ? FEATURES_MAX_RATIO : 64 * FEATURES_MAX_RATIO;
}

/* Refuses a part that can't be in what is left of the file, and one that would fill the memory,
 * before anything is allocated for it. *left: bytes of the file that no part has claimed yet. */
static int check_size(exr_const_context_t exr, const struct part *part, const char *path,
                      double *left, struct fewray_error *error) {
    int32_t chunks = 0;
    char what[96];
    const double bytes = raw_bytes(part) / greatest_ratio(part->compression);
    /* A chunk takes 8 bytes of the table of offsets, and 8 bytes of its own at least. */
    if (exr_get_chunk_count(exr, part->index, &chunks) != EXR_ERR_SUCCESS || bytes > *left ||
        chunks * 16.0 > *left)
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                           "damaged or cut off: the file can't hold %d x %d pixels of %d channels",
                           part->width, part->height, part->channels->num_channels);
    *left -= bytes;
    snprintf(what, sizeof what, "a picture of %d x %d pixels with %d channels", part->width,
             part->height, part->channels->num_channels);
    return fewray_memory_check(
        path, what, 4.0 * part->width * part->height * part->channels->num_channels, error);
}

static bool same_window(const struct part *a, const struct part *b) {
    return a->window.min.x == b->window.min.x && a->window.min.y == b->window.min.y &&
           a->width == b->width && a->height == b->height;
}

/* The header's texts that are ours. */
static int read_attributes(exr_const_context_t exr, const char *path, struct fewray_frame *frame,
                           struct fewray_error *error) {
    int count = 0;
    exr_get_attribute_count(exr, 0, &count);
    for (int i = 0; i < count; i++) {
        const exr_attribute_t *attribute = NULL;
        if (exr_get_attribute_by_index(exr, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute) !=
                EXR_ERR_SUCCESS ||
            attribute->type != EXR_ATTR_STRING || strncmp(attribute->name, "fewray.", 7) ||
            strlen(attribute->name) >= FEWRAY_NAME_MAX || !attribute->string->str)
            continue;
        if (!fewray_frame_set_attribute(frame, attribute->name, attribute->string->str))
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    }
    return FEWRAY_OK;
}

/* Checks all parts, of which only the first must be one that can be read. */
static int check_parts(exr_const_context_t exr, const char *path,
                       const struct exr_complaint *complaint, int count, double left,
                       struct part *first, struct fewray_error *error) {
    int status = read_header(exr, path, complaint, first, error);
    if (status == FEWRAY_OK)
        status = check_size(exr, first, path, &left, error);
    for (int i = 1; i < count && status == FEWRAY_OK; i++) {
        struct part part = {.index = i};
        if (read_header(exr, path, complaint, &part, NULL) == FEWRAY_OK)
            status = check_size(exr, &part, path, &left, error);
    }
    return status;
}

/* The first part gives the frame its size; parts of another size and those that can't be read at
 * all, a deep one say, are no layers of the same picture. */
static int read_layers(exr_const_context_t exr, const char *path,
                       const struct exr_complaint *complaint, int count, const struct part *first,
                       struct fewray_frame *frame, struct fewray_error *error) {
    int status = FEWRAY_OK;
    for (int i = 0; i < count && status == FEWRAY_OK; i++) {
        struct part part = {.index = i};
        if (read_header(exr, path, complaint, &part, NULL) != FEWRAY_OK ||
            !exr_compression_works(part.compression) || !same_window(&part, first))
            continue;
        if (count > 1 && exr_get_name(exr, i, &part.name) != EXR_ERR_SUCCESS)
            part.name = NULL;
        status = read_pixels(exr, &part, path, complaint, frame, error);
    }
    return status;
}

static int read_parts(exr_const_context_t exr, const char *path,
                      const struct exr_complaint *complaint, uint64_t file_size, enum exr_wish wish,
                      struct fewray_frame **out, struct fewray_error *error) {
    int count = 0, samples = 0;
    exr_result_t code = exr_get_count(exr, &count);
    if (code != EXR_ERR_SUCCESS)
        return exr_file_fail(error, path, code, complaint);
    struct part first = {.index = 0};
    int status = check_parts(exr, path, complaint, count, (double)file_size, &first, error);
    if (status != FEWRAY_OK)
        return status;
    if (!exr_compression_works(first.compression))
        return wish == EXR_PIXELS_OR_FOREIGN
                   ? EXR_IS_FOREIGN
                   : fewray_fail(
                         error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                         "B44 and DWA compression aren't supported, store it with ZIP or PIZ");
    status = fewray_frame_create(first.width, first.height, out, error);
    if (status == FEWRAY_OK)
        status = read_attributes(exr, path, *out, error);
    if (status == FEWRAY_OK && wish != EXR_HEADER)
        status = read_layers(exr, path, complaint, count, &first, *out, error);
    if (status == FEWRAY_OK &&
        exr_attr_get_int(exr, 0, "samplesPerPixel", &samples) == EXR_ERR_SUCCESS && samples > 0)
        (*out)->spp = samples;
    return status;
}

int exr_read(const char *path, enum exr_wish wish, struct fewray_frame **out,
             struct fewray_error *error) {
    *out = NULL;
    uint64_t size = 0;
    struct exr_complaint complaint = {{0}};
    exr_context_t exr = NULL;
    int status = exr_file_open(path, &complaint, &exr, &size, error);
    if (status == FEWRAY_OK)
        status = read_parts(exr, path, &complaint, size, wish, out, error);
    /* The library takes what stands before a broken attribute for the whole header. */
    if (status == EXR_IS_FOREIGN && complaint.text[0])
        status = exr_file_fail(error, path, EXR_ERR_CORRUPT_CHUNK, &complaint);
    if (exr)
        exr_finish(&exr);
    if (status != FEWRAY_OK)
        fewray_frame_destroy(out);
    return status;
}

int fewray_frame_read_exr(const char *path, struct fewray_frame **out, struct fewray_error *error) {
    return exr_read(path, EXR_PIXELS, out, error);
}

int fewray_frame_read_exr_header(const char *path, struct fewray_frame **out,
                                 struct fewray_error *error) {
    return exr_read(path, EXR_HEADER, out, error);
}
