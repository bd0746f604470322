/* SPDX-License-Identifier: Apache-2.0 */
/* A scene file as a tree of elements, by expat. */

#include "guide/scene/xml.h"

#include <errno.h>
#include <expat.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/defines.h"
#include "guide/scene/memory.h"

#define MAX_DEPTH   64
#define CHUNK_BYTES 65536

struct reader {
    XML_Parser parser;
    const char *path;
    struct xml_document *document;
    struct xml_node *current;
    int depth;
    struct defines defines;
    struct fewray_error *error;
    int status; /* of the first failure; the parser is stopped then */
};

static int line_of(const struct reader *reader) {
    return (int)XML_GetCurrentLineNumber(reader->parser);
}

static void stop(struct reader *reader, int status) {
    reader->status = status;
    XML_StopParser(reader->parser, XML_FALSE);
}

static void stop_without_memory(struct reader *reader) {
    stop(reader, fewray_fail(reader->error, FEWRAY_ERROR_MEMORY, reader->path, line_of(reader),
                             "out of memory"));
}

static bool add_id(struct reader *reader, const char *id, struct xml_node *node) {
    struct xml_document *document = reader->document;
    size_t capacity = (size_t)document->id_capacity;
    if (!array_reserve((void **)&document->ids, &capacity, (size_t)document->id_count + 1,
                       sizeof(*document->ids)))
        return false;
    document->id_capacity = (int)capacity;
    document->ids[document->id_count++] = (struct xml_id){id, node};
    return true;
}

/* Copies the attributes, with $name replaced. */
static bool read_attributes(struct reader *reader, struct xml_node *node, const char **pairs) {
    int count = 0;
    while (pairs[2 * count])
        count++;
    void **blocks = &reader->document->blocks;
    node->attributes = blocks_allocate(blocks, (size_t)count * sizeof(*node->attributes));
    if (count && !node->attributes) {
        stop_without_memory(reader);
        return false;
    }
    for (int i = 0; i < count; i++) {
        struct xml_attribute *attribute = &node->attributes[i];
        attribute->name = blocks_copy(blocks, pairs[2 * i], strlen(pairs[2 * i]));
        attribute->value = defines_expand(&reader->defines, pairs[2 * i + 1], blocks, reader->path,
                                          node->line, reader->error);
        if (!attribute->value) {
            stop(reader, FEWRAY_ERROR_FORMAT);
            return false;
        }
        if (!attribute->name) {
            stop_without_memory(reader);
            return false;
        }
        node->attribute_count = i + 1;
    }
    return true;
}

static void add_default(struct reader *reader, const struct xml_node *node) {
    const char *name = xml_attribute(node, "name"), *value = xml_attribute(node, "value");
    if (!name || !*name || !value)
        stop(reader, fewray_fail(reader->error, FEWRAY_ERROR_FORMAT, reader->path, node->line,
                                 "<default> needs a name and a value"));
    else if (!defines_add_default(&reader->defines, name, value))
        stop_without_memory(reader);
}

static void link_child(struct xml_node *parent, struct xml_node *child) {
    child->parent = parent;
    if (parent->last_child)
        parent->last_child->next = child;
    else
        parent->first_child = child;
    parent->last_child = child;
}

static void start_element(void *user, const char *tag, const char **pairs) {
    struct reader *reader = user;
    if (reader->status)
        return;
    if (++reader->depth > MAX_DEPTH) {
        stop(reader, fewray_fail(reader->error, FEWRAY_ERROR_FORMAT, reader->path, line_of(reader),
                                 "elements are nested deeper than %d", MAX_DEPTH));
        return;
    }
    struct xml_node *node = blocks_allocate(&reader->document->blocks, sizeof(*node));
    if (!node) {
        stop_without_memory(reader);
        return;
    }
    node->line = line_of(reader);
    node->index = -1;
    node->tag = blocks_copy(&reader->document->blocks, tag, strlen(tag));
    if (!node->tag) {
        stop_without_memory(reader);
        return;
    }
    if (!read_attributes(reader, node, pairs))
        return;
    if (reader->current)
        link_child(reader->current, node);
    else
        reader->document->root = node;
    reader->current = node;

    const char *id = xml_attribute(node, "id");
    if (!strcmp(tag, "default"))
        add_default(reader, node);
    else if (id && strcmp(tag, "ref") && !add_id(reader, id, node))
        stop_without_memory(reader);
}

static void end_element(void *user, const char *tag) {
    struct reader *reader = user;
    (void)tag;
    if (reader->status)
        return;
    reader->depth--;
    reader->current = reader->current->parent;
}

static void character_data(void *user, const char *text, int length) {
    struct reader *reader = user;
    for (int i = 0; i < length && !reader->status; i++)
        if (!strchr(" \t\r\n", text[i]))
            stop(reader, fewray_fail(reader->error, FEWRAY_ERROR_FORMAT, reader->path,
                                     line_of(reader), "text between the elements: '%.*s'",
                                     length - i > 40 ? 40 : length - i, text + i));
}

/* Entities can double in size at each level; no scene needs them. */
static void entity_declaration(void *user, const char *name, int is_parameter, const char *value,
                               int value_length, const char *base, const char *system_id,
                               const char *public_id, const char *notation) {
    struct reader *reader = user;
    (void)is_parameter, (void)value, (void)value_length, (void)base, (void)system_id;
    (void)public_id, (void)notation;
    if (!reader->status)
        stop(reader, fewray_fail(reader->error, FEWRAY_ERROR_FORMAT, reader->path, line_of(reader),
                                 "entity declaration '%s': entities are not allowed", name));
}

static int parse_stream(struct reader *reader, FILE *file) {
    for (bool last = false; !last;) {
        void *buffer = XML_GetBuffer(reader->parser, CHUNK_BYTES);
        if (!buffer)
            return fewray_fail(reader->error, FEWRAY_ERROR_MEMORY, reader->path, 0,
                               "out of memory");
        size_t size = fread(buffer, 1, CHUNK_BYTES, file);
        if (ferror(file))
            return fewray_fail(reader->error, FEWRAY_ERROR_IO, reader->path, 0, "can't read: %s",
                               strerror(errno));
        last = size < CHUNK_BYTES;
        if (XML_ParseBuffer(reader->parser, (int)size, last) != XML_STATUS_OK)
            return reader->status ? reader->status
                                  : fewray_fail(reader->error, FEWRAY_ERROR_FORMAT, reader->path,
                                                line_of(reader), "not well-formed XML: %s",
                                                XML_ErrorString(XML_GetErrorCode(reader->parser)));
    }
    return reader->status;
}

static int compare_ids(const void *a, const void *b) {
    const struct xml_id *x = a, *y = b;
    int order = strcmp(x->id, y->id);
    return order ? order : (x->node->line > y->node->line) - (x->node->line < y->node->line);
}

/* Sorts the ids, and refuses two of the same name. */
static int sort_ids(struct reader *reader) {
    struct xml_document *document = reader->document;
    const struct xml_id *first = NULL, *second = NULL;
    if (document->id_count)
        qsort(document->ids, (size_t)document->id_count, sizeof(*document->ids), compare_ids);
    for (int i = 1; i < document->id_count; i++) {
        const struct xml_id *a = &document->ids[i - 1], *b = &document->ids[i];
        if (!strcmp(a->id, b->id) && (!second || b->node->line < second->node->line)) {
            first = a;
            second = b;
        }
    }
    if (second)
        return fewray_fail(reader->error, FEWRAY_ERROR_FORMAT, reader->path, second->node->line,
                           "id '%s' was given before, in line %d", second->id, first->node->line);
    return FEWRAY_OK;
}

static int read_document(struct reader *reader, FILE *file) {
    reader->parser = XML_ParserCreate(NULL);
    if (!reader->parser)
        return fewray_fail(reader->error, FEWRAY_ERROR_MEMORY, reader->path, 0, "out of memory");
    XML_SetUserData(reader->parser, reader);
    XML_SetElementHandler(reader->parser, start_element, end_element);
    XML_SetCharacterDataHandler(reader->parser, character_data);
    XML_SetEntityDeclHandler(reader->parser, entity_declaration);
    int status = parse_stream(reader, file);
    if (status)
        return status;
    const char *unused = defines_unused(&reader->defines);
    if (unused)
        return fewray_fail(reader->error, FEWRAY_ERROR_ARGUMENT, reader->path, 0,
                           "-D %s: the file has no $%s", unused, unused);
    return sort_ids(reader);
}

int xml_read(const char *path, const char *const *defines, int define_count,
             struct xml_document **out, struct fewray_error *error) {
    struct reader reader = {.path = path, .error = error};
    FILE *file = NULL;
    *out = NULL;
    int status = defines_init(&reader.defines, defines, define_count, error);
    if (status)
        goto done;
    reader.document = calloc(1, sizeof(*reader.document));
    if (!reader.document) {
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
        goto done;
    }
    file = fopen(path, "rb");
    if (!file) {
        status = fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't open the scene: %s",
                             strerror(errno));
        goto done;
    }
    status = read_document(&reader, file);
done:
    if (file)
        fclose(file);
    if (reader.parser)
        XML_ParserFree(reader.parser);
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
