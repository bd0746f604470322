/* SPDX-License-Identifier: Apache-2.0 */
/* A copy of an EXR file in which some channels have new pixels. All else goes over bit for bit:
 * parts without a change as the blocks they are, other channels in the types they have. */
#include "features/exr_rewrite.h"

#include <stdlib.h>
#include <string.h>

/* --- which channels of which part */

static const char *part_name(exr_const_context_t exr, int part) {
    const char *name = NULL;
    int count = 0;
    if (exr_get_count(exr, &count) != EXR_ERR_SUCCESS || count < 2 ||
        exr_get_name(exr, part, &name) != EXR_ERR_SUCCESS)
        return NULL;
    return name;
}

/* The change of that name, or -1. */
static int find_name(const struct rewriting *work, int part, const char *channel) {
    char name[FEWRAY_NAME_MAX];
    if (!exr_plane_name(part_name(work->source, part), channel, name))
        return -1;
    for (int i = 0; i < work->change_count; i++)
        if (!strcmp(work->changes[i].name, name))
            return i;
    return -1;
}

int exr_rewriting_find(const struct rewriting *work, int part, const char *channel) {
    const int change = find_name(work, part, channel);
    return change >= 0 && work->owner[change] == part ? change : -1;
}

/* Whether fewray_frame_read_exr() takes the part's channels for planes. */
static bool part_is_read(const struct rewriting *work, int part) {
    exr_storage_t storage;
    exr_compression_t compression;
    exr_attr_box2i_t window, first;
    return exr_get_storage(work->source, part, &storage) == EXR_ERR_SUCCESS &&
           (storage == EXR_STORAGE_SCANLINE || storage == EXR_STORAGE_TILED) &&
           exr_get_compression(work->source, part, &compression) == EXR_ERR_SUCCESS &&
           exr_compression_works(compression) &&
           exr_get_data_window(work->source, part, &window) == EXR_ERR_SUCCESS &&
           exr_get_data_window(work->source, 0, &first) == EXR_ERR_SUCCESS &&
           !memcmp(&window, &first, sizeof window);
}

/* Finds the part of each change: the first that has it, as the reader does. That of the first
 * change gets what is new. */
static void find_owners(struct rewriting *work) {
    int count = 0;
    exr_get_count(work->source, &count);
    for (int i = 0; i < work->change_count; i++)
        work->owner[i] = -1;
    for (int part = 0; part < count; part++) {
        const exr_attr_chlist_t *list = NULL;
        if (!part_is_read(work, part) ||
            exr_get_channels(work->source, part, &list) != EXR_ERR_SUCCESS)
            continue;
        for (int c = 0; c < list->num_channels; c++) {
            const int change = find_name(work, part, list->entries[c].name.str);
            if (change >= 0 && work->owner[change] < 0)
                work->owner[change] = part;
        }
    }
    work->home = work->owner[0] < 0 ? 0 : work->owner[0];
}

/* Whether anything in the part is new. */
static bool part_changes(const struct rewriting *work, int part) {
    bool changes = part == work->home;
    for (int i = 0; i < work->change_count; i++)
        changes |= work->owner[i] == part;
    return changes;
}

/* --- headers */

/* Channels of a changed part; the library sorts them by name. The new ones are of the type that the
 * first changed one has. */
static exr_result_t add_channels(const struct rewriting *work, exr_context_t out, int part) {
    const exr_attr_chlist_t *list = NULL;
    exr_pixel_type_t type = EXR_PIXEL_HALF;
    exr_result_t code = exr_get_channels(work->source, part, &list);
    for (int c = 0; code == EXR_ERR_SUCCESS && c < list->num_channels; c++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[c];
        const int change = exr_rewriting_find(work, part, entry->name.str);
        const bool changes = change >= 0;
        exr_pixel_type_t kept = entry->pixel_type;
        if (changes && (work->float32 || kept == EXR_PIXEL_UINT))
            kept = EXR_PIXEL_FLOAT;
        if (changes && (change == 0 || kept == EXR_PIXEL_FLOAT))
            type = kept;
        code = exr_add_channel(
            out, part, entry->name.str, kept,
            entry->p_linear ? EXR_PERCEPTUALLY_LINEAR : EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
    for (int i = 0; code == EXR_ERR_SUCCESS && part == work->home && i < work->change_count; i++)
        if (work->owner[i] < 0)
            code = exr_add_channel(out, part, work->changes[i].name, type,
                                   EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    return code;
}

/* The attributes that the library must have, before it copies all others. */
static exr_result_t declare_part(const struct rewriting *work, exr_context_t out, int part) {
    exr_storage_t storage;
    exr_compression_t compression;
    exr_lineorder_t order;
    exr_attr_box2i_t data, display;
    exr_attr_v2f_t centre;
    float aspect = 1, width = 1;
    const char *name = NULL;
    int added;
    exr_const_context_t in = work->source;
    exr_get_name(in, part, &name);
    exr_get_pixel_aspect_ratio(in, part, &aspect);
    memset(&centre, 0, sizeof centre);
    exr_get_screen_window_center(in, part, &centre);
    exr_get_screen_window_width(in, part, &width);
    exr_result_t code = exr_get_storage(in, part, &storage);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_compression(in, part, &compression);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_lineorder(in, part, &order);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_data_window(in, part, &data);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_display_window(in, part, &display);
    if (code != EXR_ERR_SUCCESS)
        return code;
    const bool changes = part_changes(work, part);
    if (changes && order == EXR_LINEORDER_DECREASING_Y)
        order = EXR_LINEORDER_INCREASING_Y;
    code = exr_add_part(out, name, storage, &added);
    if (code == EXR_ERR_SUCCESS)
        code = exr_initialize_required_attr(out, part, &display, &data, aspect, &centre, width,
                                            order, compression);
    if (code == EXR_ERR_SUCCESS && storage == EXR_STORAGE_TILED) {
        uint32_t x, y;
        exr_tile_level_mode_t levels;
        exr_tile_round_mode_t rounding;
        code = exr_get_tile_descriptor(in, part, &x, &y, &levels, &rounding);
        if (code == EXR_ERR_SUCCESS) /* smaller pictures of the noisy one are of no use */
            code = exr_set_tile_descriptor(out, part, x, y, changes ? EXR_TILE_ONE_LEVEL : levels,
                                           rounding);
    }
    if (code == EXR_ERR_SUCCESS && changes)
        code = add_channels(work, out, part);
    return code == EXR_ERR_SUCCESS ? exr_copy_unset_attributes(out, part, in, part) : code;
}

/* --- parts as they are */

struct copying {
    struct rewriting *work;
    exr_context_t out;
    int part;
    uint8_t *bytes;
    uint64_t size;
};

/* Reads the block that info tells of. */
static exr_result_t read_block(struct copying *copying, const exr_chunk_info_t *info) {
    if (info->packed_size > copying->work->source_size)
        return EXR_ERR_CORRUPT_CHUNK;
    if (info->packed_size > copying->size) {
        free(copying->bytes);
        copying->size = info->packed_size;
        if (!(copying->bytes = malloc(copying->size))) {
            copying->size = 0;
            return EXR_ERR_OUT_OF_MEMORY;
        }
    }
    return exr_read_chunk(copying->work->source, copying->part, info, copying->bytes);
}

static exr_result_t copy_lines(struct copying *copying) {
    const exr_const_context_t in = copying->work->source;
    exr_attr_box2i_t window;
    exr_lineorder_t order;
    int32_t lines, count;
    exr_result_t code = exr_get_data_window(in, copying->part, &window);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_scanlines_per_chunk(in, copying->part, &lines);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_lineorder(in, copying->part, &order);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_chunk_count(in, copying->part, &count);
    for (int i = 0; code == EXR_ERR_SUCCESS && i < count; i++) {
        const int k = order == EXR_LINEORDER_DECREASING_Y ? count - 1 - i : i;
        const int y = window.min.y + k * lines;
        exr_chunk_info_t info;
        code = exr_read_scanline_chunk_info(in, copying->part, y, &info);
        if (code == EXR_ERR_SUCCESS)
            code = read_block(copying, &info);
        copying->work->fault = code;
        if (code == EXR_ERR_SUCCESS)
            code = exr_write_scanline_chunk(copying->out, copying->part, y, copying->bytes,
                                            info.packed_size);
    }
    return code;
}

static exr_result_t copy_level(struct copying *copying, int level_x, int level_y) {
    const exr_const_context_t in = copying->work->source;
    int32_t tile_width, tile_height, width, height;
    exr_result_t code =
        exr_get_tile_sizes(in, copying->part, level_x, level_y, &tile_width, &tile_height);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_level_sizes(in, copying->part, level_x, level_y, &width, &height);
    for (int y = 0; code == EXR_ERR_SUCCESS && y * tile_height < height; y++)
        for (int x = 0; code == EXR_ERR_SUCCESS && x * tile_width < width; x++) {
            exr_chunk_info_t info;
            code = exr_read_tile_chunk_info(in, copying->part, x, y, level_x, level_y, &info);
            if (code == EXR_ERR_SUCCESS)
                code = read_block(copying, &info);
            copying->work->fault = code;
            if (code == EXR_ERR_SUCCESS)
                code = exr_write_tile_chunk(copying->out, copying->part, x, y, level_x, level_y,
                                            copying->bytes, info.packed_size);
        }
    return code;
}

static exr_result_t copy_part(struct copying *copying) {
    const exr_const_context_t in = copying->work->source;
    exr_storage_t storage;
    uint32_t width, height;
    exr_tile_level_mode_t mode;
    exr_tile_round_mode_t rounding;
    int32_t levels_x, levels_y;
    exr_result_t code = exr_get_storage(in, copying->part, &storage);
    if (code != EXR_ERR_SUCCESS || storage == EXR_STORAGE_SCANLINE)
        return code == EXR_ERR_SUCCESS ? copy_lines(copying) : code;
    code = exr_get_tile_descriptor(in, copying->part, &width, &height, &mode, &rounding);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_tile_levels(in, copying->part, &levels_x, &levels_y);
    for (int y = 0; code == EXR_ERR_SUCCESS && y < levels_y; y++)
        for (int x = 0; code == EXR_ERR_SUCCESS && x < levels_x; x++)
            if (mode == EXR_TILE_RIPMAP_LEVELS || x == y)
                code = copy_level(copying, x, y);
    return code;
}

/* --- the whole */

static exr_result_t write_all(exr_context_t out, void *user) {
    struct rewriting *work = user;
    int count = 0;
    exr_result_t code = exr_get_count(work->source, &count);
    if (code == EXR_ERR_SUCCESS)
        code = exr_set_longname_support(out, 1);
    for (int part = 0; code == EXR_ERR_SUCCESS && part < count; part++)
        code = declare_part(work, out, part);
    if (code == EXR_ERR_SUCCESS)
        code = exr_write_header(out);
    for (int part = 0; code == EXR_ERR_SUCCESS && part < count; part++) {
        struct copying copying = {.work = work, .out = out, .part = part};
        code = part_changes(work, part) ? exr_rewrite_part(work, out, part) : copy_part(&copying);
        free(copying.bytes);
    }
    return code;
}

/* Deep pixels have no place in a flat picture; who has a file with some keeps them by leaving that
 * part in a file of its own. */
static int refuse_deep_parts(exr_const_context_t exr, const char *path,
                             struct fewray_error *error) {
    int count = 0;
    exr_get_count(exr, &count);
    for (int part = 0; part < count; part++) {
        exr_storage_t storage;
        if (exr_get_storage(exr, part, &storage) == EXR_ERR_SUCCESS &&
            (storage == EXR_STORAGE_DEEP_SCANLINE || storage == EXR_STORAGE_DEEP_TILED))
            return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                               "part %d is deep, which isn't supported: flatten it or leave it out",
                               part);
    }
    return FEWRAY_OK;
}

int fewray_exr_rewrite(const char *source, const struct fewray_exr_change *changes, int count,
                       bool float32, const char *path, struct fewray_error *error) {
    struct rewriting work = {.changes = changes, .change_count = count, .float32 = float32};
    struct exr_complaint complaint = {{0}};
    exr_attr_box2i_t window;
    if (count < 1)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, path, 0, "no channel changes");
    int status = exr_file_open(source, &complaint, &work.source, &work.source_size, error);
    if (status == FEWRAY_OK)
        status = refuse_deep_parts(work.source, source, error);
    if (status == FEWRAY_OK && !(work.owner = calloc((size_t)count, sizeof *work.owner)))
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    if (status == FEWRAY_OK && exr_get_data_window(work.source, 0, &window) != EXR_ERR_SUCCESS)
        status = exr_file_fail(error, source, EXR_ERR_INVALID_ATTR, &complaint);
    if (status == FEWRAY_OK) {
        work.width = window.max.x - window.min.x + 1;
        work.height = window.max.y - window.min.y + 1;
        find_owners(&work);
        status = exr_file_write(path, write_all, &work, error);
        if (status != FEWRAY_OK && work.fault != EXR_ERR_SUCCESS)
            status = exr_file_fail(error, source, work.fault, &complaint);
    }
    free(work.owner);
    if (work.source)
        exr_finish(&work.source);
    return status;
}
