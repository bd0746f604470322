/* SPDX-License-Identifier: Apache-2.0 */
/* Mitsuba's serialized meshes: what they hold arrives, and damage is refused. */

#include <zlib.h>

#include "guide/scene/mesh_data.h"
#include "scene_scratch.h"

enum { NORMALS = 0x1, UVS = 0x2, COLORS = 0x8, SINGLE = 0x1000, DOUBLE = 0x2000 };

struct bytes {
    unsigned char data[8192];
    size_t size;
};

static void put(struct bytes *bytes, const void *from, size_t size) {
    memcpy(bytes->data + bytes->size, from, size);
    bytes->size += size;
}

static void put_number(struct bytes *bytes, uint64_t value, int count) {
    for (int i = 0; i < count; i++)
        bytes->data[bytes->size++] = (unsigned char)(value >> 8 * i);
}

static void put_floats(struct bytes *bytes, unsigned flags, int count, double first) {
    for (int i = 0; i < count; i++) {
        double value = first + i;
        float single = (float)value;
        if (flags & DOUBLE)
            put(bytes, &value, sizeof(value));
        else
            put(bytes, &single, sizeof(single));
    }
}

/* A mesh of four vertices and two triangles, whose numbers count upwards; before compression. */
static struct bytes make_content(int version, unsigned flags, double first) {
    struct bytes plain = {.size = 0};
    put_number(&plain, flags, 4);
    if (version == 4)
        put(&plain, "name", 5);
    put_number(&plain, 4, 8);
    put_number(&plain, 2, 8);
    put_floats(&plain, flags, 12, first);
    if (flags & NORMALS)
        put_floats(&plain, flags, 12, 1);
    if (flags & UVS)
        put_floats(&plain, flags, 8, 100);
    if (flags & COLORS)
        put_floats(&plain, flags, 12, 200);
    for (unsigned i = 0; i < 6; i++)
        put_number(&plain, (const unsigned char[]){0, 1, 2, 2, 1, 3}[i], 4);
    return plain;
}

static void add_mesh(struct bytes *file, int version, const struct bytes *content) {
    uLongf size = sizeof(file->data) - file->size - 4;
    put_number(file, 0x041c, 2);
    put_number(file, (uint64_t)version, 2);
    assert_int_equal(compress(file->data + file->size, &size, content->data, content->size), Z_OK);
    file->size += size;
}

/* Two meshes of the version, and the table. */
static struct bytes make_file(int version, unsigned flags) {
    struct bytes file = {.size = 0};
    struct bytes first = make_content(version, SINGLE, 0),
                 second = make_content(version, flags, 50);
    int entry = version == 4 ? 8 : 4;
    add_mesh(&file, version, &first);
    size_t offset = file.size;
    add_mesh(&file, version, &second);
    put_number(&file, 0, entry);
    put_number(&file, offset, entry);
    put_number(&file, 2, 4);
    return file;
}

static int read_file(const struct bytes *file, size_t size, int index, struct mesh_data *mesh,
                     struct fewray_error *error) {
    memset(error, 0, sizeof(*error));
    return mesh_read_serialized(scratch_write("m.serialized", file->data, size), index, mesh,
                                error);
}

static void test_both_versions_and_precisions(void **state) {
    (void)state;
    for (int version = 3; version <= 4; version++)
        for (unsigned precision = SINGLE; precision <= DOUBLE; precision *= 2)
            for (unsigned parts = 0; parts < 16; parts++) {
                struct mesh_data mesh;
                struct fewray_error error;
                unsigned flags = precision | (parts & (NORMALS | UVS | COLORS));
                struct bytes file = make_file(version, flags);
                assert_int_equal(read_file(&file, file.size, 1, &mesh, &error), FEWRAY_OK);
                assert_int_equal(mesh.vertex_count, 4);
                assert_int_equal(mesh.triangle_count, 2);
                assert_near(mesh.positions[0], 50, 0);
                assert_near(mesh.positions[11], 61, 0);
                assert_int_equal(mesh.normals != NULL, (flags & NORMALS) != 0);
                assert_int_equal(mesh.uvs != NULL, (flags & UVS) != 0);
                if (mesh.normals)
                    assert_near(mesh.normals[11], 12, 0);
                if (mesh.uvs)
                    assert_near(mesh.uvs[7], 107, 0);
                const uint32_t expected[] = {0, 1, 2, 2, 1, 3};
                assert_memory_equal(mesh.indices, expected, sizeof(expected));
                mesh_data_free(&mesh);
                assert_int_equal(read_file(&file, file.size, 0, &mesh, &error), FEWRAY_OK);
                assert_near(mesh.positions[11], 11, 0);
                mesh_data_free(&mesh);
                assert_true(read_file(&file, file.size, 2, &mesh, &error) < 0);
                assert_non_null(strstr(error.what, "shape_index = 2"));
            }
}

static void check_refused(const struct bytes *file, size_t size, int index, const char *what) {
    struct mesh_data mesh;
    struct fewray_error error;
    assert_true(read_file(file, size, index, &mesh, &error) < 0);
    if (what && !strstr(error.what, what))
        fail_msg("'%s' lacks '%s'", error.what, what);
    assert_null(mesh.positions);
    assert_null(mesh.indices);
}

static void test_cut_anywhere_is_refused(void **state) {
    struct bytes file = make_file(4, SINGLE | NORMALS | UVS);
    (void)state;
    for (size_t size = 0; size < file.size; size++)
        check_refused(&file, size, 1, NULL);
}

static void test_damage_is_refused_or_read(void **state) {
    struct bytes good = make_file(4, DOUBLE | NORMALS);
    (void)state;
    for (size_t i = 0; i < good.size; i++) {
        struct bytes file = good;
        struct mesh_data mesh;
        struct fewray_error error;
        file.data[i] = (unsigned char)(file.data[i] ^ (1 << i % 8));
        int status = read_file(&file, file.size, 1, &mesh, &error);
        for (size_t t = 0; !status && t < 3 * (size_t)mesh.triangle_count; t++)
            assert_true(mesh.indices[t] < mesh.vertex_count);
        mesh_data_free(&mesh);
    }
}

/* A file of one mesh with this content. */
static struct bytes wrap(const struct bytes *content) {
    struct bytes file = {.size = 0};
    add_mesh(&file, 4, content);
    put_number(&file, 0, 8);
    put_number(&file, 1, 4);
    return file;
}

static void test_hostile_contents(void **state) {
    const size_t counts = 4 + 5, positions = counts + 16, indices = positions + 48;
    struct bytes content, file;
    (void)state;
    /* Counts that would take all memory. */
    for (int bits = 20; bits < 64; bits += 3)
        for (size_t which = 0; which < 16; which += 8) {
            content = make_content(4, SINGLE, 0);
            content.data[counts + which + (size_t)bits / 8] |= (unsigned char)(1 << bits % 8);
            file = wrap(&content);
            check_refused(&file, file.size, 0, bits >= 30 ? "too large" : "truncated");
        }
    content = make_content(4, SINGLE, 0);
    content.data[indices] = 4;
    file = wrap(&content);
    check_refused(&file, file.size, 0, "out of range");
    content = make_content(4, SINGLE, 0);
    memset(content.data + positions, 0xff, 4);
    file = wrap(&content);
    check_refused(&file, file.size, 0, "not finite");
    content = make_content(4, SINGLE | DOUBLE, 0);
    file = wrap(&content);
    check_refused(&file, file.size, 0, "precision");
    content = make_content(4, SINGLE, 0);
    content.size = indices + 3;
    file = wrap(&content);
    check_refused(&file, file.size, 0, "truncated");
    /* A name without an end. */
    memset(content.data, 'x', sizeof(content.data));
    content.size = sizeof(content.data);
    file = wrap(&content);
    check_refused(&file, file.size, 0, "truncated");
}

static void test_hostile_tables(void **state) {
    struct bytes file = make_file(4, SINGLE);
    (void)state;
    memset(file.data + file.size - 4, 0xff, 4);
    check_refused(&file, file.size, 0, "table");
    file = make_file(4, SINGLE);
    memset(file.data + file.size - 12, 0xff, 8);
    check_refused(&file, file.size, 1, "table");
    file = make_file(4, SINGLE);
    file.data[2] = 5;
    check_refused(&file, file.size, 0, "version 5");
    file.data[0] = 'p';
    check_refused(&file, file.size, 0, "not a file");
}

static void test_scene_names_the_mesh_by_its_index(void **state) {
    struct bytes file = make_file(3, SINGLE);
    (void)state;
    scratch_write("m.serialized", file.data, file.size);
#define MESH(index)                                                                                \
    "<shape type='serialized'><string name='filename' value='m.serialized'/>"                      \
    "<integer name='shape_index' value='" index "'/></shape>"
    struct fewray_scene *scene = scratch_scene(
        "<shape type='serialized'><string name='filename' value='m.serialized'/></shape>" MESH("1")
            MESH("1"));
    assert_int_equal(scene->mesh_count, 3);
    assert_near(scene->meshes[0].positions[0], 0, 0);
    assert_near(scene->meshes[1].positions[0], 50, 0);
    assert_near(scene->meshes[2].positions[0], 50, 0);
    fewray_scene_destroy(&scene);
    struct fewray_error error;
    assert_true(scratch_load("\n" MESH("2"), &scene, &error) < 0);
    assert_non_null(strstr(error.what, "shape_index = 2"));
    assert_non_null(strstr(error.what, "scene.xml:3"));
    assert_true(scratch_load(MESH("-1"), &scene, &error) < 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_both_versions_and_precisions),
        cmocka_unit_test(test_cut_anywhere_is_refused),
        cmocka_unit_test(test_damage_is_refused_or_read),
        cmocka_unit_test(test_hostile_contents),
        cmocka_unit_test(test_hostile_tables),
        cmocka_unit_test(test_scene_names_the_mesh_by_its_index),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
