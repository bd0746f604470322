/* SPDX-License-Identifier: Apache-2.0 */
/* The headers of EXR files as text: parts, channels, attributes. */
#include "features/exr_file.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { TEXT_MAX = 4000 };

static const char *const COMPRESSIONS[] = {"none",  "RLE", "ZIPS", "ZIP",  "PIZ",
                                           "PXR24", "B44", "B44A", "DWAA", "DWAB"};

/* --- values */

struct text {
    char bytes[TEXT_MAX + 1];
    size_t used;
};

__attribute__((format(printf, 2, 3))) static void put(struct text *text, const char *format, ...) {
    va_list list;
    va_start(list, format);
    const size_t room = sizeof text->bytes - text->used;
    const int length = vsnprintf(text->bytes + text->used, room, format, list);
    va_end(list);
    if (length > 0)
        text->used += (size_t)length < room ? (size_t)length : room - 1;
}

static void put_floats(struct text *text, const float *values, int count) {
    for (int i = 0; i < count; i++)
        put(text, "%s%.7g", i ? " " : "", (double)values[i]);
}

static void put_doubles(struct text *text, const double *values, int count) {
    for (int i = 0; i < count; i++)
        put(text, "%s%.15g", i ? " " : "", values[i]);
}

static void put_ints(struct text *text, const int32_t *values, int count) {
    for (int i = 0; i < count; i++)
        put(text, "%s%d", i ? " " : "", values[i]);
}

static void put_string(struct text *text, const exr_attr_string_t *string) {
    if (string->str)
        put(text, "%.*s", string->length < TEXT_MAX ? string->length : TEXT_MAX, string->str);
}

static void put_strings(struct text *text, const exr_attr_string_vector_t *list) {
    for (int i = 0; i < list->n_strings; i++) {
        put(text, i ? ", " : "");
        put_string(text, &list->strings[i]);
    }
}

/* SMPTE 12M: two decimal digits each for frame, seconds, minutes, hours, between flags. */
static void put_timecode(struct text *text, const exr_attr_timecode_t *code) {
    const uint32_t bits = code->time_and_flags;
    put(text, "%u%u:%u%u:%u%u:%u%u", bits >> 28 & 3, bits >> 24 & 15, bits >> 20 & 7,
        bits >> 16 & 15, bits >> 12 & 7, bits >> 8 & 15, bits >> 4 & 3, bits & 15);
}

static void put_value(struct text *text, const exr_attribute_t *attribute) {
    switch (attribute->type) {
    case EXR_ATTR_STRING:
        put_string(text, attribute->string);
        break;
    case EXR_ATTR_STRING_VECTOR:
        put_strings(text, attribute->stringvector);
        break;
    case EXR_ATTR_INT:
        put(text, "%d", attribute->i);
        break;
    case EXR_ATTR_FLOAT:
        put(text, "%.7g", (double)attribute->f);
        break;
    case EXR_ATTR_DOUBLE:
        put(text, "%.15g", attribute->d);
        break;
    case EXR_ATTR_RATIONAL:
        put(text, "%d/%u", attribute->rational->num, attribute->rational->denom);
        break;
    case EXR_ATTR_CHROMATICITIES:
        put_floats(text, &attribute->chromaticities->red_x, 8);
        break;
    case EXR_ATTR_M33F:
        put_floats(text, attribute->m33f->m, 9);
        break;
    case EXR_ATTR_M44F:
        put_floats(text, attribute->m44f->m, 16);
        break;
    case EXR_ATTR_M33D:
        put_doubles(text, attribute->m33d->m, 9);
        break;
    case EXR_ATTR_M44D:
        put_doubles(text, attribute->m44d->m, 16);
        break;
    case EXR_ATTR_V2F:
        put_floats(text, &attribute->v2f->x, 2);
        break;
    case EXR_ATTR_V3F:
        put_floats(text, &attribute->v3f->x, 3);
        break;
    case EXR_ATTR_V2I:
        put_ints(text, &attribute->v2i->x, 2);
        break;
    case EXR_ATTR_V3I:
        put_ints(text, &attribute->v3i->x, 3);
        break;
    case EXR_ATTR_BOX2I:
        put_ints(text, &attribute->box2i->min.x, 4);
        break;
    case EXR_ATTR_TIMECODE:
        put_timecode(text, attribute->timecode);
        break;
    default:
        put(text, "(%s)", attribute->type_name);
    }
}

/* --- parts */

/* A copy of a type's name: the library's own ends with the file. */
static const char *type_name(const exr_attribute_t *attribute) {
    static const char *const known[] = {
        "string", "stringvector", "int",    "float",      "double",   "rational", "chromaticities",
        "m33f",   "m44f",         "m33d",   "m44d",       "v2f",      "v3f",      "v2d",
        "v3d",    "v2i",          "v3i",    "box2i",      "timecode", "keycode",  "preview",
        "box2f",  "lineOrder",    "envmap", "floatvector"};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (!strcmp(known[i], attribute->type_name))
            return known[i];
    return "another type";
}

/* Told by the part's own fields. */
static bool is_structural(const char *name) {
    static const char *const names[] = {"channels",   "compression", "dataWindow", "displayWindow",
                                        "lineOrder",  "name",        "type",       "tiles",
                                        "chunkCount", "version"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (!strcmp(names[i], name))
            return true;
    return false;
}

static bool read_channels(exr_const_context_t exr, int index, struct fewray_exr_part *part) {
    static const char *const types[] = {"uint", "half", "float"};
    const exr_attr_chlist_t *list = NULL;
    if (exr_get_channels(exr, index, &list) != EXR_ERR_SUCCESS || list->num_channels < 1)
        return true;
    part->channels = calloc((size_t)list->num_channels, sizeof *part->channels);
    for (int c = 0; part->channels && c < list->num_channels; c++) {
        const unsigned type = (unsigned)list->entries[c].pixel_type;
        part->channels[c].type = type < 3 ? types[type] : "unknown";
        if (!(part->channels[c].name = strdup(list->entries[c].name.str)))
            return false;
        part->channel_count++;
    }
    return part->channels != NULL;
}

static bool read_attributes(exr_const_context_t exr, int index, struct fewray_exr_part *part) {
    int count = 0;
    exr_get_attribute_count(exr, index, &count);
    struct text *text = malloc(sizeof *text);
    part->attributes = calloc((size_t)count + 1, sizeof *part->attributes);
    bool good = text && part->attributes;
    for (int i = 0; good && i < count; i++) {
        const exr_attribute_t *attribute = NULL;
        if (exr_get_attribute_by_index(exr, index, EXR_ATTR_LIST_FILE_ORDER, i, &attribute) !=
                EXR_ERR_SUCCESS ||
            is_structural(attribute->name))
            continue;
        struct fewray_exr_attribute *to = &part->attributes[part->attribute_count];
        text->used = 0;
        text->bytes[0] = 0;
        put_value(text, attribute);
        to->type = type_name(attribute);
        to->name = strdup(attribute->name);
        to->text = strdup(text->bytes);
        part->attribute_count++;
        good = to->name && to->text;
    }
    free(text);
    return good;
}

static void copy_window(const exr_attr_box2i_t *from, int to[4]) {
    to[0] = from->min.x;
    to[1] = from->min.y;
    to[2] = from->max.x;
    to[3] = from->max.y;
}

static bool read_part(exr_const_context_t exr, int index, struct fewray_exr_part *part) {
    const char *name = NULL;
    exr_storage_t storage = EXR_STORAGE_SCANLINE;
    exr_compression_t compression = EXR_COMPRESSION_NONE;
    exr_attr_box2i_t window;
    exr_get_name(exr, index, &name);
    exr_get_storage(exr, index, &storage);
    exr_get_compression(exr, index, &compression);
    part->tiled = storage == EXR_STORAGE_TILED || storage == EXR_STORAGE_DEEP_TILED;
    part->deep = storage == EXR_STORAGE_DEEP_SCANLINE || storage == EXR_STORAGE_DEEP_TILED;
    part->compression = (size_t)compression < sizeof COMPRESSIONS / sizeof *COMPRESSIONS
                            ? COMPRESSIONS[compression]
                            : "unknown";
    if (exr_get_data_window(exr, index, &window) == EXR_ERR_SUCCESS)
        copy_window(&window, part->data_window);
    if (exr_get_display_window(exr, index, &window) == EXR_ERR_SUCCESS)
        copy_window(&window, part->display_window);
    part->name = strdup(name ? name : "");
    return part->name && read_channels(exr, index, part) && read_attributes(exr, index, part);
}

int fewray_exr_header_read(const char *path, struct fewray_exr_header **out,
                           struct fewray_error *error) {
    struct exr_complaint complaint = {{0}};
    exr_context_t exr = NULL;
    uint64_t size;
    int count = 0;
    *out = NULL;
    int status = exr_file_open(path, &complaint, &exr, &size, error);
    if (status == FEWRAY_OK) {
        exr_get_count(exr, &count);
        struct fewray_exr_header *header = *out = calloc(1, sizeof **out);
        bool good = header && (header->parts = calloc((size_t)count + 1, sizeof *header->parts));
        for (int i = 0; good && i < count; i++)
            good = read_part(exr, header->part_count++, &header->parts[i]);
        if (!good)
            status = fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    }
    if (exr)
        exr_finish(&exr);
    if (status != FEWRAY_OK)
        fewray_exr_header_destroy(out);
    return status;
}

void fewray_exr_header_destroy(struct fewray_exr_header **header) {
    for (int i = 0; *header && i < (*header)->part_count; i++) {
        struct fewray_exr_part *part = &(*header)->parts[i];
        for (int c = 0; c < part->channel_count; c++)
            free(part->channels[c].name);
        for (int a = 0; a < part->attribute_count; a++) {
            free(part->attributes[a].name);
            free(part->attributes[a].text);
        }
        free(part->channels);
        free(part->attributes);
        free(part->name);
    }
    if (*header)
        free((*header)->parts);
    free(*header);
    *header = NULL;
}
