/* SPDX-License-Identifier: Apache-2.0 */
/* The blocks of a part of which some channels change: decoded in the types of the file, the new
 * pixels put in, and encoded as they were. */
#include "features/exr_rewrite.h"

#include <stdlib.h>
#include <string.h>

#include "features/zip.h"

/* A channel of a part that changes. */
struct channel {
    exr_pixel_type_t type, source_type;
    int source_index;  /* in the source's part; -1: it is new */
    const float *data; /* NULL: the source's pixels */
};

/* A part that changes, and how its blocks lie. */
struct part {
    struct rewriting *work;
    exr_context_t out;
    int index, channel_count;
    struct channel *channels; /* in the order of the written file */
    exr_storage_t storage;
    exr_compression_t compression;
    exr_attr_box2i_t window;
    int chunk_width, chunk_height, columns, rows;
};

/* A thread's block. */
struct chunk {
    exr_decode_pipeline_t decode;
    struct zip_worker unzip, zip;
    uint8_t *raw, *spare;
    const uint8_t *packed;
    size_t raw_size, packed_size;
    int column, row, width, height;
};

static size_t type_size(exr_pixel_type_t type) {
    return type == EXR_PIXEL_HALF ? sizeof(uint16_t) : sizeof(float);
}

/* Matches the channels of the written part with the source's and with the changes. */
static exr_result_t plan_part(struct part *part) {
    struct rewriting *work = part->work;
    const exr_attr_chlist_t *from = NULL, *to = NULL;
    exr_result_t code = exr_get_channels(work->source, part->index, &from);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_channels(part->out, part->index, &to);
    if (code != EXR_ERR_SUCCESS)
        return code;
    part->channel_count = to->num_channels;
    if (!(part->channels = calloc((size_t)to->num_channels, sizeof *part->channels)))
        return EXR_ERR_OUT_OF_MEMORY;
    for (int c = 0; c < to->num_channels; c++) {
        struct channel *channel = &part->channels[c];
        *channel = (struct channel){.type = to->entries[c].pixel_type, .source_index = -1};
        for (int s = 0; s < from->num_channels; s++)
            if (!strcmp(from->entries[s].name.str, to->entries[c].name.str)) {
                channel->source_index = s;
                channel->source_type = from->entries[s].pixel_type;
            }
        int change = exr_rewriting_find(work, part->index, to->entries[c].name.str);
        for (int i = 0; channel->source_index < 0 && i < work->change_count; i++)
            if (work->owner[i] < 0 && !strcmp(work->changes[i].name, to->entries[c].name.str))
                change = i;
        if (change >= 0)
            channel->data = work->changes[change].data;
    }
    exr_get_storage(work->source, part->index, &part->storage);
    exr_get_compression(work->source, part->index, &part->compression);
    exr_get_data_window(work->source, part->index, &part->window);
    part->chunk_width = work->width;
    code = part->storage == EXR_STORAGE_TILED
               ? exr_get_tile_sizes(work->source, part->index, 0, 0, &part->chunk_width,
                                    &part->chunk_height)
               : exr_get_scanlines_per_chunk(work->source, part->index, &part->chunk_height);
    if (code != EXR_ERR_SUCCESS || part->chunk_width < 1 || part->chunk_height < 1)
        return code == EXR_ERR_SUCCESS ? EXR_ERR_INVALID_ATTR : code;
    /* A tile may be larger than the picture. */
    part->chunk_width = part->chunk_width < work->width ? part->chunk_width : work->width;
    part->chunk_height = part->chunk_height < work->height ? part->chunk_height : work->height;
    part->columns = (work->width - 1) / part->chunk_width + 1;
    part->rows = (work->height - 1) / part->chunk_height + 1;
    return EXR_ERR_SUCCESS;
}

static size_t line_bytes(const struct part *part, int width, int before) {
    size_t bytes = 0;
    for (int c = 0; c < before; c++)
        bytes += type_size(part->channels[c].type) * (size_t)width;
    return bytes;
}

/* Reads the source's block to the places of the channels in raw; those that aren't wanted to spare.
 */
static exr_result_t decode_chunk(const struct part *part, struct chunk *chunk) {
    const exr_const_context_t in = part->work->source;
    exr_decode_pipeline_t *decode = &chunk->decode;
    const bool first = decode->channels == NULL;
    exr_chunk_info_t info;
    exr_result_t code =
        part->storage == EXR_STORAGE_TILED
            ? exr_read_tile_chunk_info(in, part->index, chunk->column, chunk->row, 0, 0, &info)
            : exr_read_scanline_chunk_info(
                  in, part->index, part->window.min.y + chunk->row * part->chunk_height, &info);
    if (code != EXR_ERR_SUCCESS)
        return code;
    if (info.width != chunk->width || info.height != chunk->height)
        return EXR_ERR_CORRUPT_CHUNK;
    code = first ? exr_decoding_initialize(in, part->index, &info, decode)
                 : exr_decoding_update(in, part->index, &info, decode);
    if (code != EXR_ERR_SUCCESS)
        return code;
    const size_t line = line_bytes(part, chunk->width, part->channel_count);
    for (int c = 0; c < part->channel_count; c++) {
        const struct channel *channel = &part->channels[c];
        if (channel->source_index < 0)
            continue;
        exr_coding_channel_info_t *to = &decode->channels[channel->source_index];
        to->user_data_type = (uint16_t)channel->source_type;
        to->user_bytes_per_element = (int16_t)type_size(channel->source_type);
        to->user_pixel_stride = to->user_bytes_per_element;
        to->user_line_stride =
            channel->data ? chunk->width * to->user_bytes_per_element : (int32_t)line;
        to->decode_to_ptr =
            channel->data ? chunk->spare : chunk->raw + line_bytes(part, chunk->width, c);
    }
    if (first)
        code = exr_decoding_choose_default_routines(in, part->index, decode);
    if (first &&
        (part->compression == EXR_COMPRESSION_ZIP || part->compression == EXR_COMPRESSION_ZIPS)) {
        decode->decompress_fn = exr_unzip;
        decode->decoding_user_data = &chunk->unzip;
    }
    return code == EXR_ERR_SUCCESS ? exr_decoding_run(in, part->index, decode) : code;
}

/* Puts the new pixels into raw. */
static void put_changes(const struct part *part, const struct chunk *chunk) {
    const size_t line = line_bytes(part, chunk->width, part->channel_count);
    for (int c = 0; c < part->channel_count; c++) {
        const struct channel *channel = &part->channels[c];
        const size_t start = line_bytes(part, chunk->width, c);
        for (int y = 0; channel->data && y < chunk->height; y++) {
            uint8_t *to = chunk->raw + start + (size_t)y * line;
            const float *from =
                channel->data +
                (size_t)(chunk->row * part->chunk_height + y) * (size_t)part->work->width +
                chunk->column * part->chunk_width;
            if (channel->type == EXR_PIXEL_HALF)
                half_from_floats(from, (uint16_t *)(void *)to, (size_t)chunk->width);
            else
                memcpy(to, from, (size_t)chunk->width * sizeof *from);
        }
    }
}

static exr_result_t make_chunk(const struct part *part, struct chunk *chunk) {
    const size_t pixels = (size_t)part->chunk_width * (size_t)part->chunk_height;
    if (!chunk->raw)
        chunk->raw = calloc(1, line_bytes(part, part->chunk_width, part->channel_count) *
                                   (size_t)part->chunk_height);
    if (!chunk->spare)
        chunk->spare = malloc(pixels * sizeof(float));
    if (!chunk->raw || !chunk->spare)
        return EXR_ERR_OUT_OF_MEMORY;
    const int right = part->work->width - chunk->column * part->chunk_width;
    const int below = part->work->height - chunk->row * part->chunk_height;
    chunk->width = right < part->chunk_width ? right : part->chunk_width;
    chunk->height = below < part->chunk_height ? below : part->chunk_height;
    chunk->raw_size = line_bytes(part, chunk->width, part->channel_count) * (size_t)chunk->height;
    const exr_result_t code = decode_chunk(part, chunk);
    if (code != EXR_ERR_SUCCESS) {
#pragma omp atomic write
        part->work->fault = code;
        return code;
    }
    put_changes(part, chunk);
    if (part->compression != EXR_COMPRESSION_ZIP && part->compression != EXR_COMPRESSION_ZIPS)
        return EXR_ERR_SUCCESS;
    return zip_pack(&chunk->zip, chunk->raw, chunk->raw_size, &chunk->packed, &chunk->packed_size)
               ? EXR_ERR_SUCCESS
               : EXR_ERR_OUT_OF_MEMORY;
}

/* Compresses a block by the library. */
static exr_result_t encode_chunk(const struct part *part, const struct chunk *chunk,
                                 const exr_chunk_info_t *info) {
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    const size_t line = line_bytes(part, chunk->width, part->channel_count);
    exr_result_t code = exr_encoding_initialize(part->out, part->index, info, &encode);
    for (int c = 0; code == EXR_ERR_SUCCESS && c < part->channel_count; c++) {
        exr_coding_channel_info_t *from = &encode.channels[c];
        from->user_data_type = (uint16_t)part->channels[c].type;
        from->user_bytes_per_element = (int16_t)type_size(part->channels[c].type);
        from->user_pixel_stride = from->user_bytes_per_element;
        from->user_line_stride = (int32_t)line;
        from->encode_from_ptr = chunk->raw + line_bytes(part, chunk->width, c);
    }
    if (code == EXR_ERR_SUCCESS)
        code = exr_encoding_choose_default_routines(part->out, part->index, &encode);
    if (code == EXR_ERR_SUCCESS)
        code = exr_encoding_run(part->out, part->index, &encode);
    exr_encoding_destroy(part->out, &encode);
    return code;
}

static exr_result_t write_chunk(const struct part *part, const struct chunk *chunk) {
    const int y = part->window.min.y + chunk->row * part->chunk_height;
    const bool tiled = part->storage == EXR_STORAGE_TILED;
    exr_chunk_info_t info;
    if (chunk->packed)
        return tiled ? exr_write_tile_chunk(part->out, part->index, chunk->column, chunk->row, 0, 0,
                                            chunk->packed, chunk->packed_size)
                     : exr_write_scanline_chunk(part->out, part->index, y, chunk->packed,
                                                chunk->packed_size);
    const exr_result_t code = tiled
                                  ? exr_write_tile_chunk_info(part->out, part->index, chunk->column,
                                                              chunk->row, 0, 0, &info)
                                  : exr_write_scanline_chunk_info(part->out, part->index, y, &info);
    return code == EXR_ERR_SUCCESS ? encode_chunk(part, chunk, &info) : code;
}

/* Blocks are made by all threads and written in order. */
static exr_result_t rewrite_chunks(struct part *part) {
    const int count = part->columns * part->rows;
    const size_t values =
        (size_t)part->channel_count * (size_t)part->work->width * (size_t)part->work->height;
    exr_result_t result = EXR_ERR_SUCCESS;
#pragma omp parallel if (values > FEATURES_PARALLEL_FILE_MIN)
    {
        struct chunk chunk = {.decode = EXR_DECODE_PIPELINE_INITIALIZER};
#pragma omp for ordered schedule(static, 1)
        for (int i = 0; i < count; i++) {
            chunk.column = i % part->columns;
            chunk.row = i / part->columns;
            const exr_result_t code = make_chunk(part, &chunk);
#pragma omp ordered
            {
                if (result == EXR_ERR_SUCCESS)
                    result = code;
                if (result == EXR_ERR_SUCCESS)
                    result = write_chunk(part, &chunk);
            }
        }
        exr_decoding_destroy(part->work->source, &chunk.decode);
        zip_worker_clear(&chunk.unzip);
        zip_worker_clear(&chunk.zip);
        free(chunk.raw);
        free(chunk.spare);
    }
    return result;
}

exr_result_t exr_rewrite_part(struct rewriting *work, exr_context_t out, int index) {
    struct part part = {.work = work, .out = out, .index = index};
    exr_result_t code = plan_part(&part);
    if (code == EXR_ERR_SUCCESS)
        code = rewrite_chunks(&part);
    free(part.channels);
    return code;
}
