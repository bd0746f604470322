/* SPDX-License-Identifier: Apache-2.0 */
/* Elements that change how a scene is read: <include>, <path> and <alias>; and where its files
 * lie. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "guide/scene/memory.h"
#include "guide/scene/xml_reader.h"

#define MAX_INCLUDES 16
/* Files that include each other twice are exponentially many. */
#define MAX_INCLUDED_FILES 1000

bool xml_is_directive(const char *tag) {
    return !strcmp(tag, "include") || !strcmp(tag, "path") || !strcmp(tag, "alias");
}

/* folder/filename, malloc'd; filename alone where it is absolute. */
static char *join(const char *folder, size_t folder_length, const char *filename) {
    size_t length = strlen(filename);
    if (filename[0] == '/')
        folder_length = 0;
    char *path = malloc(folder_length + length + 2);
    if (!path)
        return NULL;
    memcpy(path, folder, folder_length);
    if (folder_length && folder[folder_length - 1] != '/')
        path[folder_length++] = '/';
    memcpy(path + folder_length, filename, length + 1);
    return path;
}

/* As Mitsuba: the last <path> comes first, the scene's own folder last. */
char *xml_find_file(const struct xml_document *document, const char *filename) {
    const char *slash = strrchr(document->path, '/');
    size_t length = slash ? (size_t)(slash - document->path) + 1 : 0;
    for (const struct xml_folder *folder = document->folders; folder; folder = folder->next) {
        char *path = join(folder->path, strlen(folder->path), filename);
        if (!path || !access(path, F_OK))
            return path;
        free(path);
    }
    return join(document->path, length, filename);
}

/* Whether the file at path is being read already. */
static bool is_open(const struct xml_source *source, const char *path) {
    for (; source; source = source->outer)
        if (!strcmp(source->path, path))
            return true;
    return false;
}

static void include(struct xml_reader *reader, const struct xml_node *node) {
    const char *filename = xml_attribute(node, "filename");
    if (!filename || !*filename) {
        xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "<include> has no filename");
        return;
    }
    if (!reader->current) {
        xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "<include> must stand within <scene>");
        return;
    }
    if (reader->include_depth == MAX_INCLUDES) {
        xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "files are included deeper than %d",
                        MAX_INCLUDES);
        return;
    }
    if (++reader->include_count > MAX_INCLUDED_FILES) {
        xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "more than %d files are included",
                        MAX_INCLUDED_FILES);
        return;
    }
    char *path = xml_find_file(reader->document, filename);
    if (!path) {
        xml_reader_stop_without_memory(reader);
    } else if (is_open(reader->source, path)) {
        xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "%s includes itself", path);
    } else if (access(path, R_OK)) {
        xml_reader_stop(reader, FEWRAY_ERROR_IO, "included file %s is not there", path);
    } else {
        reader->include_depth++;
        if (xml_reader_read(reader, path))
            XML_StopParser(reader->source->parser, XML_FALSE);
        reader->include_depth--;
    }
    free(path);
}

/* A folder in which files are looked for, relative to the scene's own. */
static void add_folder(struct xml_reader *reader, const struct xml_node *node) {
    const char *value = xml_attribute(node, "value");
    struct xml_document *document = reader->document;
    struct stat info;
    if (!value || !*value || !reader->current || reader->current != document->root) {
        xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "%s",
                        value && *value ? "<path> must stand within <scene>"
                                        : "<path> has no value");
        return;
    }
    char *path = xml_find_file(document, value);
    struct xml_folder *folder = blocks_allocate(&document->blocks, sizeof(*folder));
    char *copy = path ? blocks_copy(&document->blocks, path, strlen(path)) : NULL;
    if (!folder || !copy)
        xml_reader_stop_without_memory(reader);
    else if (stat(path, &info) || !S_ISDIR(info.st_mode))
        xml_reader_stop(reader, FEWRAY_ERROR_IO, "<path>: there is no folder %s", path);
    free(path);
    if (reader->status)
        return;
    folder->path = copy;
    folder->next = document->folders;
    document->folders = folder;
}

/* Another id for what has one already. */
static void add_alias(struct xml_reader *reader, const struct xml_node *node) {
    const char *id = xml_attribute(node, "id"), *as = xml_attribute(node, "as");
    const struct xml_document *document = reader->document;
    if (!id || !as || !*as) {
        xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "<alias> needs id and as");
        return;
    }
    for (int i = document->id_count - 1; i >= 0; i--)
        if (!strcmp(document->ids[i].id, id)) {
            if (!xml_reader_add_id(reader, as, document->ids[i].node))
                xml_reader_stop_without_memory(reader);
            return;
        }
    xml_reader_stop(reader, FEWRAY_ERROR_FORMAT, "<alias>: nothing above has the id '%s'", id);
}

void xml_obey_directive(struct xml_reader *reader, const struct xml_node *node) {
    if (!strcmp(node->tag, "include"))
        include(reader, node);
    else if (!strcmp(node->tag, "path"))
        add_folder(reader, node);
    else
        add_alias(reader, node);
}
