/* SPDX-License-Identifier: Apache-2.0 */
/* A scene file as a tree of elements, by expat. */

#include "guide/scene/xml.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/file_bytes.h"
#include "guide/scene/memory.h"
#include "guide/scene/number.h"
#include "guide/scene/xml_reader.h"

#define MAX_DEPTH   64
#define CHUNK_BYTES 65536

static int line_of(const struct xml_reader *reader) {
#if XML_MAJOR_VERSION * 1000 + XML_MINOR_VERSION >= 2009 /* which deprecates the other one */
    return (int)XML_GetCurrentLineNumber64(reader->source->parser);
#else
    return (int)XML_GetCurrentLineNumber(reader->source->parser);
#endif
}

static void stop(struct xml_reader *reader, int status) {
    reader->status = status;
    XML_StopParser(reader->source->parser, XML_FALSE);
}

void xml_reader_stop(struct xml_reader *reader, enum fewray_status status, const char *format,
                     ...) {
    char text[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    stop(reader,
         fewray_fail(reader->error, status, reader->source->path, line_of(reader), "%s", text));
}

void xml_reader_stop_without_memory(struct xml_reader *reader) {
    xml_reader_stop(reader, FEWRAY_ERROR_MEMORY, "out of memory");
}

bool xml_reader_add_id(struct xml_reader *reader, const char *id, struct xml_node *node) {
    struct xml_document *document = reader->document;
    size_t capacity = (size_t)document->id_capacity;
    if (!array_reserve((void **)&document->ids, &capacity, (size_t)document->id_count + 1,
                       sizeof(*document->ids)))
        return false;
    document->id_capacity = (int)capacity;
    document->ids[document->id_count] =
        (struct xml_id){id, node, reader->source->path, line_of(reader), document->id_count};
    document->id_count++;
    return true;
}

/* Copies the attributes, with $name replaced. */
static bool read_attributes(struct xml_reader *reader, struct xml_node *node, const char **pairs) {
    int count = 0;
    while (pairs[2 * count])
        count++;
    void **blocks = &reader->document->blocks;
    node->attributes = blocks_allocate(blocks, (size_t)count * sizeof(*node->attributes));
    if (count && !node->attributes) {
        xml_reader_stop_without_memory(reader);
        return false;
    }
    for (int i = 0; i < count; i++) {
        struct xml_attribute *attribute = &node->attributes[i];
        attribute->name = blocks_copy(blocks, pairs[2 * i], strlen(pairs[2 * i]));
        attribute->value = defines_expand(&reader->defines, pairs[2 * i + 1], blocks, node->file,
                                          node->line, reader->error);
        if (!attribute->value) {
            stop(reader, FEWRAY_ERROR_FORMAT);
            return false;
        }
        if (!attribute->name) {
            xml_reader_stop_without_memory(reader);
            return false;
        }
        node->attribute_count = i + 1;
    }
    return true;
}

static void add_default(struct xml_reader *reader, const struct xml_node *node) {
    const char *name = xml_attribute(node, "name"), *value = xml_attribute(node, "value");
    if (!name || !*name || !value)
        xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "<default> needs a name and a value");
    else if (!defines_add_default(&reader->defines, name, value))
        xml_reader_stop_without_memory(reader);
}

static void link_child(struct xml_node *parent, struct xml_node *child) {
    child->parent = parent;
    if (parent->last_child)
        parent->last_child->next = child;
    else
        parent->first_child = child;
    parent->last_child = child;
}

/* The node of an element, not linked so far; NULL: stopped. */
static struct xml_node *make_node(struct xml_reader *reader, const char *tag, const char **pairs) {
    struct xml_node *node = blocks_allocate(&reader->document->blocks, sizeof(*node));
    if (!node) {
        xml_reader_stop_without_memory(reader);
        return NULL;
    }
    node->line = line_of(reader);
    node->file = reader->source->path;
    node->index = -1;
    node->tag = blocks_copy(&reader->document->blocks, tag, strlen(tag));
    if (!node->tag) {
        xml_reader_stop_without_memory(reader);
        return NULL;
    }
    return read_attributes(reader, node, pairs) ? node : NULL;
}

/* The <scene> of an included file stands for its children. Older versions have other names. */
static void open_included_scene(struct xml_reader *reader, const struct xml_node *node) {
    const char *version = xml_attribute(node, "version");
    double number = 0;
    reader->source->bare = true;
    if (!version || !number_read(&version, &number) || number < 3)
        xml_reader_stop(reader, FEWRAY_ERROR_UNSUPPORTED,
                        "an included <scene> needs version 3: only Mitsuba 3 scenes are supported");
}

static void add_node(struct xml_reader *reader, struct xml_node *node) {
    const char *id = xml_attribute(node, "id");
    if (reader->current)
        link_child(reader->current, node);
    else
        reader->document->root = node;
    reader->current = node;
    if (!strcmp(node->tag, "default"))
        add_default(reader, node);
    else if (id && strcmp(node->tag, "ref") && !xml_reader_add_id(reader, id, node))
        xml_reader_stop_without_memory(reader);
}

static void start_element(void *user, const char *tag, const char **pairs) {
    struct xml_reader *reader = user;
    if (reader->status)
        return;
    if (reader->in_directive) {
        xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "<%s> stands where nothing can", tag);
        return;
    }
    reader->source->depth++;
    if (++reader->depth > MAX_DEPTH) {
        xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "elements are nested deeper than %d",
                        MAX_DEPTH);
        return;
    }
    struct xml_node *node = make_node(reader, tag, pairs);
    if (!node)
        return;
    if (reader->source->included && reader->source->depth == 1 && !strcmp(tag, "scene")) {
        open_included_scene(reader, node);
    } else if (xml_is_directive(tag)) {
        xml_obey_directive(reader, node);
        reader->in_directive = true;
    } else {
        add_node(reader, node);
    }
}

static void end_element(void *user, const char *tag) {
    struct xml_reader *reader = user;
    (void)tag;
    if (reader->status)
        return;
    bool bare = reader->source->depth == 1 && reader->source->bare;
    reader->depth--;
    reader->source->depth--;
    if (!reader->in_directive && !bare)
        reader->current = reader->current->parent;
    reader->in_directive = false;
}

static void character_data(void *user, const char *text, int length) {
    struct xml_reader *reader = user;
    for (int i = 0; i < length && !reader->status; i++)
        if (!strchr(" \t\r\n", text[i]))
            xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "text between the elements: '%.*s'",
                            length - i > 40 ? 40 : length - i, text + i);
}

/* Entities can double in size at each level; no scene needs them. */
static void entity_declaration(void *user, const char *name, int is_parameter, const char *value,
                               int value_length, const char *base, const char *system_id,
                               const char *public_id, const char *notation) {
    struct xml_reader *reader = user;
    (void)is_parameter, (void)value, (void)value_length, (void)base, (void)system_id;
    (void)public_id, (void)notation;
    if (!reader->status)
        xml_reader_stop(reader, FEWRAY_ERROR_FORMAT,
                        "entity declaration '%s': entities are not allowed", name);
}

static int parse_stream(struct xml_reader *reader, FILE *file) {
    XML_Parser parser = reader->source->parser;
    const char *path = reader->source->path;
    for (bool last = false; !last;) {
        void *buffer = XML_GetBuffer(parser, CHUNK_BYTES);
        if (!buffer)
            return fewray_fail(reader->error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
        size_t size = fread(buffer, 1, CHUNK_BYTES, file);
        if (ferror(file))
            return fewray_fail(reader->error, FEWRAY_ERROR_IO, path, 0, "can't read: %s",
                               strerror(errno));
        last = size < CHUNK_BYTES;
        const bool parsed = XML_ParseBuffer(parser, (int)size, last) == XML_STATUS_OK;
        if (!parsed && !reader->status && XML_GetErrorCode(parser) == XML_ERROR_NO_MEMORY)
            return fewray_fail(reader->error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
        if (!parsed)
            return reader->status ? reader->status
                                  : fewray_fail(reader->error, FEWRAY_ERROR_FORMAT, path,
                                                line_of(reader), "not well-formed XML: %s",
                                                XML_ErrorString(XML_GetErrorCode(parser)));
    }
    return reader->status;
}

int xml_reader_read(struct xml_reader *reader, const char *path) {
    struct xml_source *outer = reader->source;
    struct xml_source source = {.outer = outer, .included = outer != NULL};
    FILE *file = NULL;
    source.path = blocks_copy(&reader->document->blocks, path, strlen(path));
    source.parser = XML_ParserCreate(NULL);
    int status = FEWRAY_OK;
    if (!source.path || !source.parser)
        status = fewray_fail(reader->error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    else if ((status = file_check_regular(path, reader->error)))
        ;
    else if (!(file = fopen(path, "rb")))
        status = fewray_fail(reader->error, FEWRAY_ERROR_IO, path, 0, "can't open the scene: %s",
                             strerror(errno));
    if (!status) {
        if (!outer)
            reader->document->path = source.path;
        XML_SetUserData(source.parser, reader);
        XML_SetElementHandler(source.parser, start_element, end_element);
        XML_SetCharacterDataHandler(source.parser, character_data);
        XML_SetEntityDeclHandler(source.parser, entity_declaration);
        reader->source = &source;
        status = parse_stream(reader, file);
        reader->source = outer;
    }
    if (file)
        fclose(file);
    if (source.parser)
        XML_ParserFree(source.parser);
    if (status)
        reader->status = status;
    return status;
}

static int compare_ids(const void *a, const void *b) {
    const struct xml_id *x = a, *y = b;
    int order = strcmp(x->id, y->id);
    return order ? order : (x->order > y->order) - (x->order < y->order);
}

/* Sorts the ids, and refuses two of the same name. */
static int sort_ids(struct xml_reader *reader) {
    struct xml_document *document = reader->document;
    const struct xml_id *first = NULL, *second = NULL;
    if (document->id_count)
        qsort(document->ids, (size_t)document->id_count, sizeof(*document->ids), compare_ids);
    for (int i = 1; i < document->id_count; i++) {
        const struct xml_id *a = &document->ids[i - 1], *b = &document->ids[i];
        if (!strcmp(a->id, b->id) && (!second || b->order < second->order)) {
            first = a;
            second = b;
        }
    }
    if (second)
        return fewray_fail(reader->error, FEWRAY_ERROR_FORMAT, second->file, second->line,
                           "id '%s' was given before, in line %d%s%s", second->id, first->line,
                           first->file == second->file ? "" : " of ",
                           first->file == second->file ? "" : first->file);
    return FEWRAY_OK;
}

static int read_document(struct xml_reader *reader, const char *path) {
    int status = xml_reader_read(reader, path);
    if (status)
        return status;
    const char *unused = defines_unused(&reader->defines);
    if (unused)
        return fewray_fail(reader->error, FEWRAY_ERROR_ARGUMENT, path, 0,
                           "-D %s: the file has no $%s", unused, unused);
    return sort_ids(reader);
}

int xml_read(const char *path, const struct fewray_scene_options *options,
             struct xml_document **out, struct fewray_error *error) {
    struct xml_reader reader = {.error = error};
    *out = NULL;
    int status = defines_init(&reader.defines, options->defines, options->define_count, error);
    if (!status && options->frame && !defines_add_default(&reader.defines, "frame", options->frame))
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    if (!status) {
        reader.document = calloc(1, sizeof(*reader.document));
        status = reader.document
                     ? read_document(&reader, path)
                     : fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    }
    if (!status)
        reader.document->uses_frame = defines_default_used(&reader.defines, "frame");
    defines_free(&reader.defines);
    if (status)
        xml_destroy(&reader.document);
    *out = reader.document;
    return status;
}

void xml_destroy(struct xml_document **document) {
    if (!*document)
        return;
    free((*document)->ids);
    blocks_free(&(*document)->blocks);
    free(*document);
    *document = NULL;
}

const char *xml_attribute(const struct xml_node *node, const char *name) {
    for (int i = 0; i < node->attribute_count; i++)
        if (!strcmp(node->attributes[i].name, name))
            return node->attributes[i].value;
    return NULL;
}

static int compare_id(const void *key, const void *item) {
    return strcmp(key, ((const struct xml_id *)item)->id);
}

struct xml_node *xml_find_id(const struct xml_document *document, const char *id) {
    if (!document->id_count)
        return NULL;
    const struct xml_id *found =
        bsearch(id, document->ids, (size_t)document->id_count, sizeof(*document->ids), compare_id);
    return found ? found->node : NULL;
}
