/* SPDX-License-Identifier: Apache-2.0 */
/* The MTL files of an OBJ file, before assimp reads them: it waits for pipes, reads devices without
 * end, and crashes where a map stands before the first material (5.2.4). */

#define _GNU_SOURCE /* memmem */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "guide/scene/assimp/import.h"
#include "guide/scene/file_bytes.h"

#define NAME_BYTES 500

static bool ends_line(char c) {
    return c == '\n' || c == '\r';
}

/* Whether nothing but comments stands before the first newmtl. */
static bool starts_with_a_material(const char *c, const char *end) {
    while (c < end) {
        while (c < end && (ends_line(*c) || *c == ' ' || *c == '\t'))
            c++;
        if (c < end && *c != '#')
            return end - c > 6 && !memcmp(c, "newmtl", 6);
        while (c < end && !ends_line(*c))
            c++;
    }
    return true;
}

/* A file that isn't there is no failure. */
static int check_file(struct import *import, const char *path) {
    struct file_bytes file;
    if (access(path, R_OK))
        return FEWRAY_OK;
    int status = file_check_regular(path, import->error);
    if (!status)
        status = file_read(path, &file, import->error);
    if (status)
        return status == FEWRAY_ERROR_FORMAT ? FEWRAY_OK : status; /* empty: nothing to trip over */
    if (!starts_with_a_material(file.data, file.data + file.size))
        status = fewray_fail(import->error, FEWRAY_ERROR_FORMAT, path, 0,
                             "something stands before the first newmtl");
    file_free(&file);
    return status;
}

/* A name that the OBJ gives, of so many bytes. */
static int check_named(struct import *import, const char *name, size_t length) {
    char text[NAME_BYTES + 1], path[4096];
    const char *slash = strrchr(import->path, '/');
    int folder = slash && name[0] != '/' ? (int)(slash - import->path) + 1 : 0;
    if (length > NAME_BYTES || memchr(name, '\\', length))
        return import_fail(import, FEWRAY_ERROR_UNSUPPORTED,
                           "the name of its material file is too long or has a backslash");
    memcpy(text, name, length);
    text[length] = 0;
    snprintf(path, sizeof(path), "%.*s%s", folder, import->path, text);
    if (access(path, R_OK)) /* assimp would take grey for its materials */
        return import_warn(import, "its material file %s can't be read", text);
    return check_file(import, path);
}

/* assimp takes NAME.mtl beside NAME.obj where the file that is named isn't there. */
static int check_fallback(struct import *import) {
    char path[4096];
    const size_t length = strlen(import->path);
    if (length < 4 || length >= sizeof(path))
        return FEWRAY_OK;
    memcpy(path, import->path, length - 3);
    memcpy(path + length - 3, "mtl", 4);
    return check_file(import, path);
}

int import_check_mtl(struct import *import) {
    static const char word[] = "mtllib";
    const size_t word_length = sizeof(word) - 1;
    struct file_bytes file;
    int status = file_read(import->path, &file, import->error);
    if (status)
        return status;
    const char *c = file.data, *end = c + file.size;
    while (!status && (c = memmem(c, (size_t)(end - c), word, word_length))) {
        c += word_length;
        while (c < end && (*c == ' ' || *c == '\t'))
            c++;
        const char *name = c;
        while (c < end && !ends_line(*c))
            c++;
        if (c > name)
            status = check_named(import, name, (size_t)(c - name));
    }
    file_free(&file);
    return status ? status : check_fallback(import);
}
