/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_SCENE_SCRATCH_H
#define FEWRAY_TESTS_SCENE_SCRATCH_H

/* A temporary folder with small files, for the tests of the scene loader. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "guide/scene/scene.h"

static char scratch_folder[64];

static inline int scratch_create(void **state) {
    (void)state;
    strcpy(scratch_folder, "/tmp/fewray-scene-XXXXXX");
    return mkdtemp(scratch_folder) ? 0 : -1;
}

static inline int scratch_remove(void **state) {
    char path[512];
    struct dirent *entry;
    DIR *folder = opendir(scratch_folder);
    (void)state;
    while (folder && (entry = readdir(folder))) {
        snprintf(path, sizeof(path), "%s/%s", scratch_folder, entry->d_name);
        unlink(path);
    }
    if (folder)
        closedir(folder);
    return rmdir(scratch_folder);
}

/* The path of a file in the folder; valid until the next call but three. */
static inline const char *scratch_path(const char *name) {
    static char paths[4][256];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, 256, "%s/%s", scratch_folder, name);
    return path;
}

static inline const char *scratch_write(const char *name, const void *bytes, size_t size) {
    const char *path = scratch_path(name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    return path;
}

static inline const char *scratch_text(const char *name, const char *text) {
    return scratch_write(name, text, strlen(text));
}

#define SENSOR "<sensor type='perspective'><film type='hdrfilm'/></sensor>"

/* Writes a scene of a sensor and the body, which starts in line 2, and loads it. */
static inline int scratch_load_as(const char *body, bool lenient, struct fewray_scene **out,
                                  struct fewray_error *error) {
    static char text[65536];
    const struct fewray_scene_options options = {.lenient = lenient};
    snprintf(text, sizeof(text), "<scene version='3.0.0'>" SENSOR "\n%s\n</scene>\n", body);
    memset(error, 0, sizeof(*error));
    return fewray_scene_load(scratch_text("scene.xml", text), &options, out, error);
}

static inline int scratch_load(const char *body, struct fewray_scene **out,
                               struct fewray_error *error) {
    return scratch_load_as(body, false, out, error);
}

/* The same, but it must work. */
static inline struct fewray_scene *scratch_scene_as(const char *body, bool lenient) {
    struct fewray_scene *scene = NULL;
    struct fewray_error error;
    if (scratch_load_as(body, lenient, &scene, &error))
        fail_msg("line %d: %s", error.line, error.what);
    return scene;
}

static inline struct fewray_scene *scratch_scene(const char *body) {
    return scratch_scene_as(body, false);
}

static inline bool same_files(const char *a, const char *b) {
    FILE *files[2] = {fopen(a, "rb"), fopen(b, "rb")};
    int bytes[2];
    assert_true(files[0] && files[1]);
    do
        for (int k = 0; k < 2; k++)
            bytes[k] = fgetc(files[k]);
    while (bytes[0] == bytes[1] && bytes[0] != EOF);
    fclose(files[0]);
    fclose(files[1]);
    return bytes[0] == bytes[1];
}

static inline void assert_near(double a, double b, double tolerance) {
    if (!(a - b <= tolerance && b - a <= tolerance))
        fail_msg("%.9g is not %.9g", a, b);
}

#endif
