/* SPDX-License-Identifier: Apache-2.0 */
/* Errors, warnings and references while a scene is read. */

#include "guide/scene/loader.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/memory.h"
#include "guide/scene/plugins.h"

#define TEXT_BYTES 512
/* More than anybody reads; each is compared with all before it. */
#define WARNINGS_MAX 1000

int loader_fail(struct loader *loader, enum fewray_status status, const struct xml_node *node,
                const char *format, ...) {
    char text[TEXT_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    return fewray_fail(loader->error, status, node && node->file ? node->file : loader->path,
                       node ? node->line : 0, "%s", text);
}

int loader_fail_memory(struct loader *loader) {
    return fewray_fail(loader->error, FEWRAY_ERROR_MEMORY, loader->path, 0, "out of memory");
}

/* Whether a warning ends in this text: "FILE:LINE: text". */
static bool has_warning(const struct fewray_scene *scene, const char *text) {
    size_t length = strlen(text);
    for (int i = 0; i < scene->warning_count; i++) {
        const char *warning = scene->warnings[i];
        size_t warning_length = strlen(warning);
        if (warning_length > length + 2 && !strcmp(warning + warning_length - length, text) &&
            !strncmp(warning + warning_length - length - 2, ": ", 2))
            return true;
    }
    return false;
}

int loader_warn(struct loader *loader, const struct xml_node *node, const char *format, ...) {
    struct fewray_scene *scene = loader->scene;
    char text[TEXT_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    if (scene->warning_count > WARNINGS_MAX || has_warning(scene, text))
        return FEWRAY_OK;
    if (scene->warning_count == WARNINGS_MAX)
        snprintf(text, sizeof(text), "there are more warnings, which are not shown");
    const char *file = node->file ? node->file : loader->path;
    size_t size = strlen(file) + strlen(text) + 32;
    char *line = malloc(size);
    if (!line || !array_reserve((void **)&scene->warnings, &loader->warning_capacity,
                                (size_t)scene->warning_count + 1, sizeof(*scene->warnings))) {
        free(line);
        return loader_fail_memory(loader);
    }
    snprintf(line, size, "%s:%d: %s", file, node->line, text);
    for (char *c = line; *c; c++)
        if (*c == '\n' || *c == '\r')
            *c = ' ';
    scene->warnings[scene->warning_count++] = line;
    return FEWRAY_OK;
}

char *loader_find_file(struct loader *loader, const char *filename) {
    return xml_find_file(loader->document, filename);
}

int loader_resolve(struct loader *loader, struct xml_node *child, struct xml_node **object) {
    enum element_kind kind = element_kind(child->tag);
    *object = kind == ELEMENT_OBJECT ? child : NULL;
    if (kind != ELEMENT_REFERENCE)
        return FEWRAY_OK;
    const char *id = xml_attribute(child, "id");
    *object = xml_find_id(loader->document, id);
    if (!*object || element_kind((*object)->tag) != ELEMENT_OBJECT)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, child, "nothing has the id '%s'", id);
    return FEWRAY_OK;
}

const char *loader_describe(const struct xml_node *object, char text[128]) {
    const char *type = xml_attribute(object, "type"), *id = xml_attribute(object, "id");
    if (id)
        snprintf(text, 128, "%s '%s' (id '%.64s')", object->tag, type, id);
    else
        snprintf(text, 128, "%s '%s'", object->tag, type);
    return text;
}
