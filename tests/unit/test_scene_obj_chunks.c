/* SPDX-License-Identifier: Apache-2.0 */
/* OBJ files of many chunks: any number of threads reads the same, and tells the same first error.
 */

#include "guide/scene/mesh_data.h"
#include "scene_scratch.h"

enum { ROWS = 12000, LONGEST_ROW = 400 };

struct text {
    char *data;
    size_t size;
    int lines;
};

static void put(struct text *text, const char *line) {
    size_t length = strlen(line);
    memcpy(text->data + text->size, line, length + 1);
    text->size += length;
    for (; *line; line++)
        text->lines += *line == '\n';
}

/* ROWS times two vertices, a uv, a normal, a quad and a triangle that refer to this row and the one
 * before, by numbers of both signs, with hidden line ends; about 2 MB. */
static struct text make_strip(void) {
    struct text text = {.data = malloc(ROWS * LONGEST_ROW)};
    char row[LONGEST_ROW];
    assert_non_null(text.data);
    for (int i = 0; i < ROWS; i++) {
        snprintf(row, sizeof(row), "v %d 0 0.25\nv %d 1 \\\n0.5\nvt %.6f 0.125\nvn 0 %d 1\r\n", i,
                 i, (double)i / ROWS, i % 7);
        put(&text, row);
        if (i == 0)
            continue;
        snprintf(row, sizeof(row),
                 "# row %d \\\nf %d/%d/%d -3/-2/-1 \\\n -1/-1/-1 \\\r\n-2/-1/-1 \\\n\n"
                 "f -4/-2/-1 -3/-2/-1 %d/%d/%d\n",
                 i, 2 * i - 1, i, i + 1, 2 * i + 2, i + 1, i + 1);
        put(&text, row);
    }
    return text;
}

static int parse(const struct text *text, int threads, struct mesh_data *mesh,
                 struct fewray_error *error) {
    int status = 0;
    memset(error, 0, sizeof(*error));
    if (threads == 0)
        return mesh_parse_obj("strip.obj", text->data, text->size, mesh, error);
#pragma omp parallel num_threads(threads)
#pragma omp single
    status = mesh_parse_obj("strip.obj", text->data, text->size, mesh, error);
    return status;
}

static void test_any_number_of_threads_reads_the_same(void **state) {
    struct text text = make_strip();
    struct mesh_data alone;
    struct fewray_error error;
    (void)state;
    assert_int_equal(parse(&text, 0, &alone, &error), FEWRAY_OK);
    assert_int_equal(alone.triangle_count, 3 * (ROWS - 1));
    for (int threads = 1; threads <= 8; threads *= 2) {
        struct mesh_data mesh;
        assert_int_equal(parse(&text, threads, &mesh, &error), FEWRAY_OK);
        assert_int_equal(mesh.vertex_count, alone.vertex_count);
        assert_int_equal(mesh.triangle_count, alone.triangle_count);
        assert_memory_equal(mesh.positions, alone.positions, 12 * (size_t)mesh.vertex_count);
        assert_memory_equal(mesh.normals, alone.normals, 12 * (size_t)mesh.vertex_count);
        assert_memory_equal(mesh.uvs, alone.uvs, 8 * (size_t)mesh.vertex_count);
        assert_memory_equal(mesh.indices, alone.indices, 12 * (size_t)mesh.triangle_count);
        mesh_data_free(&mesh);
    }
    mesh_data_free(&alone);
    free(text.data);
}

static void test_every_row_is_what_the_file_says(void **state) {
    static const float ys[] = {0, 1, 1, 0, 1, 0, 0, 1, 1}; /* of the three triangles' corners */
    static const int columns[] = {-1, -1, 0, -1, 0, 0, -1, -1, 0};
    struct text text = make_strip();
    struct mesh_data mesh;
    struct fewray_error error;
    (void)state;
    assert_int_equal(parse(&text, 4, &mesh, &error), FEWRAY_OK);
    for (int row = 1; row < ROWS; row++)
        for (int i = 0; i < 9; i++) {
            const uint32_t vertex = mesh.indices[9 * (size_t)(row - 1) + (size_t)i];
            const float *p = mesh.positions + 3 * (size_t)vertex;
            assert_true(p[0] == (float)(row + columns[i]) && p[1] == ys[i]);
            assert_true(p[2] == (ys[i] == 1 ? 0.5f : 0.25f));
            assert_true(mesh.normals[3 * (size_t)vertex + 1] == (float)(row % 7));
        }
    /* Each row's four corners, once. */
    assert_int_equal(mesh.vertex_count, 4 * (ROWS - 1));
    mesh_data_free(&mesh);
    free(text.data);
}

static void test_the_first_of_several_errors_is_told(void **state) {
    struct text text = make_strip();
    (void)state;
    put(&text, "v 1 2 x\n");
    const int line = text.lines;
    for (int i = 0; i < 4; i++) {
        struct text more = make_strip();
        text.data = realloc(text.data, text.size + more.size + 1);
        assert_non_null(text.data);
        put(&text, more.data);
        free(more.data);
    }
    text.data = realloc(text.data, text.size + 64);
    assert_non_null(text.data);
    put(&text, "f 1 2 999999999\n");
    for (int threads = 0; threads <= 4; threads += 2) {
        struct mesh_data mesh;
        struct fewray_error error;
        assert_int_equal(parse(&text, threads, &mesh, &error), FEWRAY_ERROR_FORMAT);
        assert_int_equal(error.line, line);
        assert_non_null(strstr(error.what, "malformed"));
        assert_null(mesh.positions);
    }
    free(text.data);
}

/* No line's end can be cut at: one chunk. And a file that ends within a hidden line's end. */
static void test_a_face_of_hidden_line_ends_stays_whole(void **state) {
    const int corners = 200000;
    struct text text = {.data = malloc((size_t)corners * 8 + 64)};
    (void)state;
    assert_non_null(text.data);
    put(&text, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf ");
    for (int i = 0; i < corners; i++)
        put(&text, i % 2 ? "-1 \\\n" : "1 \\\r\n");
    for (int threads = 0; threads <= 4; threads += 2) {
        struct mesh_data mesh;
        struct fewray_error error;
        assert_int_equal(parse(&text, threads, &mesh, &error), FEWRAY_OK);
        assert_int_equal(mesh.triangle_count, corners - 2);
        assert_int_equal(mesh.vertex_count, 2);
        mesh_data_free(&mesh);
    }
    free(text.data);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any_number_of_threads_reads_the_same),
        cmocka_unit_test(test_every_row_is_what_the_file_says),
        cmocka_unit_test(test_the_first_of_several_errors_is_told),
        cmocka_unit_test(test_a_face_of_hidden_line_ends_stays_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
