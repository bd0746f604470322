/* SPDX-License-Identifier: Apache-2.0 */
/* OBJ and PLY files: what they hold arrives, and damage is refused. */

#include "guide/scene/mesh_data.h"
#include "scene_scratch.h"

static int parse_obj(const char *text, struct mesh_data *mesh, struct fewray_error *error) {
    memset(error, 0, sizeof(*error));
    return mesh_parse_obj("mesh.obj", text, strlen(text), mesh, error);
}

static void test_obj_shares_equal_corners(void **state) {
    struct mesh_data mesh;
    struct fewray_error error;
    (void)state;
    assert_int_equal(
        parse_obj("# a square\nmtllib x.mtl\nv 0 0 0\nv 1 0 0 # x\nv 1 1 0\nv 0 1 0\r\n"
                  "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\ng top\n"
                  "f 1/1 2/2 3/3 4/4\nf -4/-4 -2/-2 -3/-1\n",
                  &mesh, &error),
        FEWRAY_OK);
    assert_int_equal(mesh.triangle_count, 3);
    /* Vertex 2 occurs with two uvs, the others with one. */
    assert_int_equal(mesh.vertex_count, 5);
    assert_null(mesh.normals);
    const uint32_t fan[] = {0, 1, 2, 0, 2, 3, 0, 2, 4};
    assert_memory_equal(mesh.indices, fan, sizeof(fan));
    assert_near(mesh.uvs[2 * 4 + 1], 1, 0);
    mesh_data_free(&mesh);
}

static void test_obj_reads_normals_and_long_lines(void **state) {
    struct mesh_data mesh;
    struct fewray_error error;
    (void)state;
    assert_int_equal(parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 2\nvn nan 0 1\n"
                               "f 1//1 \\\n 2//1 3//2",
                               &mesh, &error),
                     FEWRAY_OK);
    assert_non_null(mesh.normals);
    assert_null(mesh.uvs);
    assert_near(mesh.normals[2], 2, 0);
    mesh_data_free(&mesh);
}

static void test_damaged_obj_is_refused(void **state) {
    static const struct {
        const char *text;
        int line;
        const char *what;
    } cases[] = {
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", 4, "4 is out of range"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", 4, "-4 is out of range"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", 4, "0 is out of range"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2 3\n", 4, "out of range"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", 4, "fewer than three"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n", 4, "index is missing"},
        {"v 0 0 0\nv 1 0\n", 2, "missing"},
        {"v 0 0 0\nv 1 0 abc\n", 2, "malformed"},
        {"v 0 0 0\nv nan 0 0\n", 2, "not finite"},
        {"v 0 0 0\nv 1e99 0 0\n", 2, "not finite"},
        {"v 0 0 0\n", 0, "no faces"},
        {"f 1 2 3\nv 0 0 0\n", 1, "out of range"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++) {
        struct mesh_data mesh;
        struct fewray_error error;
        assert_int_equal(parse_obj(cases[i].text, &mesh, &error), FEWRAY_ERROR_FORMAT);
        assert_int_equal(error.line, cases[i].line);
        if (!strstr(error.what, cases[i].what))
            fail_msg("'%s' lacks '%s'", error.what, cases[i].what);
        assert_null(mesh.positions);
    }
}

static void test_broken_bytes_of_obj_are_refused_or_read(void **state) {
    static const char *const good = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1.5e0 1 0\nvt 0 1\nvt 1 .5\n"
                                    "vn 0 0 1\nf 1/1/1 2/2/1 3/1/1\nf 2/2/1 -1/1/1 3/2/1 1/1/1\n";
    char text[256];
    (void)state;
    for (size_t i = 0; i < 8 * strlen(good); i++) {
        struct mesh_data mesh;
        struct fewray_error error;
        strcpy(text, good);
        text[i / 8] = (char)(text[i / 8] ^ (1 << i % 8));
        int status = parse_obj(text, &mesh, &error);
        for (size_t t = 0; !status && t < 3 * (size_t)mesh.triangle_count; t++)
            assert_true(mesh.indices[t] < mesh.vertex_count);
        mesh_data_free(&mesh);
    }
}

/* --- PLY */

#define PLY_HEADER                                                                                 \
    "ply\nformat binary_little_endian 1.0\ncomment made by a test\n"                               \
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"                     \
    "property uchar red\nproperty double u\nproperty float v\n"                                    \
    "element face 2\nproperty list uchar int vertex_indices\nproperty short flags\nend_header\n"

struct bytes {
    char data[4096];
    size_t size;
};

static void put(struct bytes *bytes, const void *from, size_t size) {
    memcpy(bytes->data + bytes->size, from, size);
    bytes->size += size;
}

/* A square as one quad and one triangle; the properties are mixed on purpose. */
static struct bytes make_ply(void) {
    struct bytes bytes = {.size = 0};
    put(&bytes, PLY_HEADER, strlen(PLY_HEADER));
    for (int i = 0; i < 4; i++) {
        float p[3] = {(float)(i % 2), (float)(i / 2), 0}, v = (float)i / 8;
        double u = i;
        put(&bytes, p, sizeof(p));
        put(&bytes, "r", 1);
        put(&bytes, &u, sizeof(u));
        put(&bytes, &v, sizeof(v));
    }
    const int32_t quad[] = {0, 1, 3, 2}, triangle[] = {2, 1, 0};
    put(&bytes, "\4", 1);
    put(&bytes, quad, sizeof(quad));
    put(&bytes, "\0\0", 2);
    put(&bytes, "\3", 1);
    put(&bytes, triangle, sizeof(triangle));
    put(&bytes, "\0\0", 2);
    return bytes;
}

static int read_ply(const void *bytes, size_t size, struct mesh_data *mesh,
                    struct fewray_error *error) {
    memset(error, 0, sizeof(*error));
    return mesh_read_ply(scratch_write("mesh.ply", bytes, size), mesh, error);
}

static void test_binary_ply_of_any_layout(void **state) {
    struct bytes bytes = make_ply();
    struct mesh_data mesh;
    struct fewray_error error;
    (void)state;
    assert_int_equal(read_ply(bytes.data, bytes.size, &mesh, &error), FEWRAY_OK);
    const uint32_t expected[] = {0, 1, 3, 0, 3, 2, 2, 1, 0};
    assert_int_equal(mesh.vertex_count, 4);
    assert_int_equal(mesh.triangle_count, 3);
    assert_memory_equal(mesh.indices, expected, sizeof(expected));
    assert_near(mesh.positions[3 * 3 + 1], 1, 0);
    assert_near(mesh.uvs[2 * 3], 3, 0);
    assert_near(mesh.uvs[2 * 3 + 1], 0.375, 0);
    assert_null(mesh.normals);
    mesh_data_free(&mesh);
}

static void test_ply_cut_anywhere_is_refused(void **state) {
    struct bytes bytes = make_ply();
    (void)state;
    for (size_t size = 0; size < bytes.size; size++) {
        struct mesh_data mesh;
        struct fewray_error error;
        /* The last two bytes are the last face's flags. */
        assert_true(read_ply(bytes.data, size, &mesh, &error) < 0);
        assert_true(error.what[0] != 0);
        assert_null(mesh.positions);
        assert_null(mesh.indices);
    }
}

static void test_damaged_ply_is_refused_or_read(void **state) {
    struct bytes good = make_ply();
    (void)state;
    for (size_t i = 0; i < good.size; i++) {
        struct bytes bytes = good;
        struct mesh_data mesh;
        struct fewray_error error;
        bytes.data[i] = (char)(bytes.data[i] ^ 0x85);
        int status = read_ply(bytes.data, bytes.size, &mesh, &error);
        for (size_t t = 0; !status && t < 3 * (size_t)mesh.triangle_count; t++)
            assert_true(mesh.indices[t] < mesh.vertex_count);
        mesh_data_free(&mesh);
    }
}

static void test_ascii_ply(void **state) {
    static const char *const text =
        "ply\r\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
        "element face 1\nproperty list uchar int vertex_index\nend_header\n"
        "0 0 0 0 0 1\n1 0 0 0 nan 1\n0 1 0 0 0 1\n3 0 1 2";
    struct mesh_data mesh;
    struct fewray_error error;
    (void)state;
    assert_int_equal(read_ply(text, strlen(text), &mesh, &error), FEWRAY_OK);
    assert_int_equal(mesh.triangle_count, 1);
    assert_non_null(mesh.normals);
    mesh_data_free(&mesh);
    assert_true(read_ply(text, strlen(text) - 1, &mesh, &error) < 0);
    assert_non_null(strstr(error.what, "truncated"));
}

static void test_ply_with_false_counts_takes_no_memory(void **state) {
    static const char *const texts[] = {
        "ply\nformat ascii 1.0\nelement vertex 900000000000\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n",
        "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n0 0 0\n",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nelement face 999999999\nproperty list uchar int vertex_indices\n"
        "end_header\n0 0 0\n3 0 0 0\n",
        "ply\nformat binary_big_endian 1.0\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty floot x\nend_header\n",
        "plx\n",
    };
    (void)state;
    for (size_t i = 0; i < sizeof(texts) / sizeof(*texts); i++) {
        struct mesh_data mesh;
        struct fewray_error error;
        assert_true(read_ply(texts[i], strlen(texts[i]), &mesh, &error) < 0);
        assert_null(mesh.positions);
    }
}

static void test_smooth_normals_weigh_by_angle(void **state) {
    struct mesh_data mesh;
    struct fewray_error error;
    (void)state;
    /* Mitsuba 3.9 gives these normals to the same file. */
    const float expected[] = {0, 0.8022930f, 0.5969310f, 0, 0.8130100f, 0.5822490f,
                              0, 0,          1,          0, 0.9578260f, -0.2873480f};
    const int order[] = {0, 1, 2, 3};
    assert_int_equal(
        parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0.3 1\nf 1 2 3\nf 1 4 2\n", &mesh, &error),
        FEWRAY_OK);
    float *normals = mesh_smooth_normals(&mesh);
    assert_non_null(normals);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 3; j++)
            assert_near(normals[3 * order[i] + j], expected[3 * i + j], 1e-5);
    free(normals);
    mesh_data_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_obj_shares_equal_corners),
        cmocka_unit_test(test_obj_reads_normals_and_long_lines),
        cmocka_unit_test(test_damaged_obj_is_refused),
        cmocka_unit_test(test_broken_bytes_of_obj_are_refused_or_read),
        cmocka_unit_test(test_binary_ply_of_any_layout),
        cmocka_unit_test(test_ply_cut_anywhere_is_refused),
        cmocka_unit_test(test_damaged_ply_is_refused_or_read),
        cmocka_unit_test(test_ascii_ply),
        cmocka_unit_test(test_ply_with_false_counts_takes_no_memory),
        cmocka_unit_test(test_smooth_normals_weigh_by_angle),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
