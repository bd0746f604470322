/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_MITSUBA_TABLE_H
#define FEWRAY_TESTS_MITSUBA_TABLE_H

/* A table of tests/data/mitsuba, written by a script in tests/mitsuba, with its textures in a
 * temporary folder. */

#include "tests/unit/check.h"

#include <jansson.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "fewray/features.h"
#include "guide/trace/world.h"

struct mitsuba_table {
    json_t *root, *configurations;
    char folder[64];
};

static inline double table_number(const json_t *array, size_t i) {
    return json_number_value(json_array_get(array, i));
}

static inline struct vec3 table_vector(const json_t *array, size_t i) {
    return vec((float)table_number(array, i), (float)table_number(array, i + 1),
               (float)table_number(array, i + 2));
}

static inline const char *table_string(const json_t *entry, const char *key) {
    return json_string_value(json_object_get(entry, key));
}

static inline const char *case_name(const json_t *entry) {
    return table_string(entry, "name");
}

static inline bool is_near(double value, double expected, double size) {
    return fabs(value - expected) <= 2e-3 * fabs(size) + 2e-5;
}

static inline bool is_near_color(struct vec3 value, struct vec3 expected) {
    float size = max_component(expected);
    return is_near(value.x, expected.x, size) && is_near(value.y, expected.y, size) &&
           is_near(value.z, expected.z, size);
}

static inline void table_write_texture(const char *path, const json_t *texture) {
    const json_t *rgb = json_object_get(texture, "rgb");
    int width = (int)json_integer_value(json_object_get(texture, "width"));
    int height = (int)json_integer_value(json_object_get(texture, "height"));
    uint8_t bytes[1024];
    assert_true(json_array_size(rgb) <= sizeof(bytes));
    for (size_t i = 0; i < json_array_size(rgb); i++)
        bytes[i] = (uint8_t)table_number(rgb, i);
    assert_int_equal(fewray_image_write_png(path, width, height, bytes, NULL), 0);
}

static inline void table_open(struct mitsuba_table *table, const char *file) {
    json_error_t error;
    table->root = json_load_file(file, 0, &error);
    if (!table->root)
        fail_msg("%s: %s", file, error.text);
    table->configurations = json_object_get(table->root, "configurations");
    strcpy(table->folder, "/tmp/fewray-mitsuba-XXXXXX");
    assert_non_null(mkdtemp(table->folder));
    const char *name;
    json_t *texture;
    json_object_foreach(json_object_get(table->root, "textures"), name, texture) {
        char path[128];
        snprintf(path, sizeof(path), "%s/%s", table->folder, name);
        table_write_texture(path, texture);
    }
}

static inline void table_close(struct mitsuba_table *table) {
    char path[128];
    const char *name;
    json_t *texture;
    json_object_foreach(json_object_get(table->root, "textures"), name, texture) {
        snprintf(path, sizeof(path), "%s/%s", table->folder, name);
        unlink(path);
    }
    snprintf(path, sizeof(path), "%s/scene.xml", table->folder);
    unlink(path);
    rmdir(table->folder);
    json_decref(table->root);
}

/* Starts a scene beside the textures, of a sensor; its elements are to start in line 2. */
static inline FILE *table_begin_scene(const struct mitsuba_table *table) {
    char path[128];
    snprintf(path, sizeof(path), "%s/scene.xml", table->folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "<scene version='3.0.0'><sensor type='perspective'><film type='hdrfilm'/>"
                  "</sensor>\n");
    return file;
}

static inline void table_end_scene(const struct mitsuba_table *table, FILE *file,
                                   struct fewray_scene **scene, struct fewray_world **world) {
    char path[128];
    struct fewray_error error = {0};
    snprintf(path, sizeof(path), "%s/scene.xml", table->folder);
    fprintf(file, "</scene>\n");
    assert_int_equal(fclose(file), 0);
    if (fewray_scene_load(path, NULL, scene, &error) ||
        fewray_world_create(*scene, 1, world, &error))
        fail_msg("line %d: %s", error.line, error.what);
}

#endif
