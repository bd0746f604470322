/* SPDX-License-Identifier: Apache-2.0 */
/* The header of a PLY file. */

#include "guide/scene/ply_header.h"

#include <string.h>

#include "guide/scene/number.h"

#define MAX_WORDS 6
#define MAX_LINE  256

struct header_reader {
    const char *path, *data;
    size_t size, position;
    int line;
    char text[MAX_LINE]; /* the current line, cut into words */
    char *words[MAX_WORDS];
    int word_count;
    struct fewray_error *error;
};

static int fail(const struct header_reader *reader, const char *what) {
    return fewray_fail(reader->error, FEWRAY_ERROR_FORMAT, reader->path, reader->line, "%s", what);
}

/* Takes the next line apart; surplus words are dropped. */
static int next_line(struct header_reader *reader) {
    const char *start = reader->data + reader->position;
    size_t left = reader->size - reader->position;
    const char *end = memchr(start, '\n', left);
    reader->line++;
    reader->word_count = 0;
    if (!end)
        return fail(reader, "the PLY header is truncated");
    size_t length = (size_t)(end - start);
    reader->position += length + 1;
    if (length >= MAX_LINE)
        length = MAX_LINE - 1;
    memcpy(reader->text, start, length);
    reader->text[length] = 0;
    char *rest = NULL;
    for (char *word = strtok_r(reader->text, " \t\r", &rest);
         word && reader->word_count < MAX_WORDS; word = strtok_r(NULL, " \t\r", &rest))
        reader->words[reader->word_count++] = word;
    return FEWRAY_OK;
}

static bool word_is(const struct header_reader *reader, int index, const char *text) {
    return index < reader->word_count && !strcmp(reader->words[index], text);
}

static enum ply_type type_of(const char *word) {
    static const struct {
        const char *name;
        enum ply_type type;
    } types[] = {
        {"char", PLY_INT8},      {"int8", PLY_INT8},     {"uchar", PLY_UINT8},
        {"uint8", PLY_UINT8},    {"short", PLY_INT16},   {"int16", PLY_INT16},
        {"ushort", PLY_UINT16},  {"uint16", PLY_UINT16}, {"int", PLY_INT32},
        {"int32", PLY_INT32},    {"uint", PLY_UINT32},   {"uint32", PLY_UINT32},
        {"float", PLY_FLOAT},    {"float32", PLY_FLOAT}, {"double", PLY_DOUBLE},
        {"float64", PLY_DOUBLE},
    };
    for (size_t i = 0; i < sizeof(types) / sizeof(*types); i++)
        if (!strcmp(word, types[i].name))
            return types[i].type;
    return PLY_NONE;
}

size_t ply_type_size(enum ply_type type) {
    static const size_t sizes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[type];
}

static int read_format(struct header_reader *reader, struct ply_header *out) {
    out->ascii = word_is(reader, 1, "ascii");
    if (word_is(reader, 1, "binary_big_endian"))
        return fewray_fail(reader->error, FEWRAY_ERROR_UNSUPPORTED, reader->path, reader->line,
                           "big-endian PLY is not supported yet: convert it to little endian");
    if (!out->ascii && !word_is(reader, 1, "binary_little_endian"))
        return fail(reader, "unknown PLY format");
    return FEWRAY_OK;
}

static int read_element(struct header_reader *reader, struct ply_header *out) {
    int64_t count = 0;
    const char *text = reader->word_count == 3 ? reader->words[2] : "";
    if (!number_read_integer(&text, &count) || *text || count < 0)
        return fail(reader, "a PLY element needs a name and a count");
    if (out->element_count == PLY_MAX_ELEMENTS || strlen(reader->words[1]) > 31)
        return fail(reader, "too many or too long PLY elements");
    struct ply_element *element = &out->elements[out->element_count++];
    strcpy(element->name, reader->words[1]);
    element->count = (uint64_t)count;
    return FEWRAY_OK;
}

static int read_property(struct header_reader *reader, struct ply_header *out) {
    struct ply_element *element =
        out->element_count ? &out->elements[out->element_count - 1] : NULL;
    bool list = word_is(reader, 1, "list");
    if (!element || reader->word_count != (list ? 5 : 3))
        return fail(reader, "a malformed PLY property");
    const char *name = reader->words[list ? 4 : 2];
    if (element->property_count == PLY_MAX_PROPERTIES || strlen(name) > 31)
        return fail(reader, "too many or too long PLY properties");
    struct ply_property *property = &element->properties[element->property_count++];
    strcpy(property->name, name);
    property->type = type_of(reader->words[list ? 3 : 1]);
    property->count_type = list ? type_of(reader->words[2]) : PLY_NONE;
    if (!property->type || (list && !property->count_type) || property->count_type >= PLY_FLOAT)
        return fail(reader, "an unknown PLY property type");
    element->has_list |= list;
    element->stride += ply_type_size(property->type);
    return FEWRAY_OK;
}

int ply_read_header(const char *path, const char *data, size_t size, struct ply_header *out,
                    struct fewray_error *error) {
    struct header_reader reader = {.path = path, .data = data, .size = size, .error = error};
    bool has_format = false;
    memset(out, 0, sizeof(*out));
    int status = next_line(&reader);
    if (status || !word_is(&reader, 0, "ply"))
        return fail(&reader, "not a PLY file");
    for (;;) {
        status = next_line(&reader);
        if (status)
            return status;
        if (word_is(&reader, 0, "end_header"))
            break;
        if (word_is(&reader, 0, "format")) {
            status = read_format(&reader, out);
            has_format = true;
        } else if (word_is(&reader, 0, "element")) {
            status = read_element(&reader, out);
        } else if (word_is(&reader, 0, "property")) {
            status = read_property(&reader, out);
        } else if (reader.word_count && !word_is(&reader, 0, "comment") &&
                   !word_is(&reader, 0, "obj_info")) {
            status = fail(&reader, "an unknown line in the PLY header");
        }
        if (status)
            return status;
    }
    if (!has_format)
        return fail(&reader, "the PLY header names no format");
    out->size = reader.position;
    out->lines = reader.line;
    return FEWRAY_OK;
}

int ply_find_property(const struct ply_element *element, const char *const *names) {
    for (int i = 0; i < element->property_count; i++)
        for (const char *const *name = names; *name; name++)
            if (!strcmp(element->properties[i].name, *name))
                return i;
    return -1;
}
