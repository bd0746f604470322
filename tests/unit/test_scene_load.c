/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes arrive as they are written, by Mitsuba's rules. */

#include "scene_scratch.h"

static struct vec3 emission_of(const struct fewray_scene *scene, int mesh) {
    assert_true(scene->meshes[mesh].emission >= 0);
    return scene->textures[scene->meshes[mesh].emission].color0;
}

static struct vec3 corner(const struct mesh *mesh, uint32_t triangle, int i) {
    const float *p = mesh->positions + 3 * (size_t)mesh->indices[3 * triangle + (uint32_t)i];
    return vec(p[0], p[1], p[2]);
}

static struct vec3 face_normal(const struct mesh *mesh, uint32_t triangle) {
    struct vec3 p = corner(mesh, triangle, 0);
    return normalize(cross(sub(corner(mesh, triangle, 1), p), sub(corner(mesh, triangle, 2), p)));
}

static double mesh_area(const struct mesh *mesh) {
    double area = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        struct vec3 p = corner(mesh, t, 0);
        area += length(cross(sub(corner(mesh, t, 1), p), sub(corner(mesh, t, 2), p))) / 2;
    }
    return area;
}

static void test_data_scene(void **state) {
    struct fewray_scene *scene = NULL;
    struct fewray_error error = {0};
    (void)state;
    if (fewray_scene_load(TEST_DATA "/scene/box.xml", NULL, &scene, &error))
        fail_msg("%s:%d: %s", error.file, error.line, error.what);
    struct fewray_scene_summary summary = fewray_scene_summarize(scene);
    assert_int_equal(summary.width, 40);
    assert_int_equal(summary.height, 30);
    assert_int_equal(summary.max_depth, 6);
    assert_int_equal(summary.sample_count, 16);
    assert_int_equal(summary.meshes, 4);
    assert_int_equal(summary.triangles, 2 + 12 + 12 + 12);
    assert_int_equal(summary.emitters, 2);
    assert_int_equal(summary.materials, 3);
    assert_int_equal(summary.textures, 1);
    assert_int_equal(summary.warning_count, 0);
    assert_near(scene->camera.fov_x, 40 * 3.14159265 / 180, 1e-6);
    /* One file, two transforms: two meshes. */
    assert_string_equal(scene->meshes[2].id, "pyramid.obj");
    assert_near(scene->meshes[3].positions[0] - scene->meshes[2].positions[0], 3, 1e-6);
    assert_int_equal(scene->meshes[2].bsdf, scene->meshes[3].bsdf);
    assert_null(scene->meshes[2].normals);
    assert_non_null(scene->meshes[3].normals);
    assert_near(emission_of(scene, 0).y, 4.5, 1e-6);
    fewray_scene_destroy(&scene);
    assert_null(scene);
}

static void test_any_number_of_threads_loads_the_same(void **state) {
    struct fewray_scene *scenes[2] = {NULL, NULL};
    struct fewray_error error;
    (void)state;
    for (int i = 0; i < 2; i++) {
        const struct fewray_scene_options options = {.threads = 1 + 3 * i};
        assert_int_equal(
            fewray_scene_load(TEST_DATA "/scene/box.xml", &options, &scenes[i], &error), FEWRAY_OK);
    }
    for (int m = 0; m < scenes[0]->mesh_count; m++) {
        const struct mesh *a = &scenes[0]->meshes[m], *b = &scenes[1]->meshes[m];
        assert_int_equal(a->vertex_count, b->vertex_count);
        assert_memory_equal(a->positions, b->positions, a->vertex_count * 3 * sizeof(float));
        assert_memory_equal(a->indices, b->indices, a->triangle_count * 3 * sizeof(uint32_t));
    }
    fewray_scene_destroy(&scenes[0]);
    fewray_scene_destroy(&scenes[1]);
}

static void test_defines_and_defaults(void **state) {
    static const char *const text =
        "<scene version='3.0.0'>\n<default name='spp' value='4'/><default name='spp_max' "
        "value='9'/>"
        "<default name='w' value='$spp'/>"
        "<sensor type='perspective'><sampler type='independent'><integer name='sample_count' "
        "value='$spp_max'/></sampler><film type='hdrfilm'><integer name='width' value='1$w'/>"
        "<integer name='height' value='$spp'/></film></sensor></scene>";
    const char *const defines[] = {"spp=64"}, *const unused[] = {"depth=3"};
    const char *const malformed[] = {"depth"};
    struct fewray_scene_options options = {.defines = defines, .define_count = 1};
    struct fewray_scene *scene = NULL;
    struct fewray_error error = {0};
    (void)state;
    const char *path = scratch_text("defines.xml", text);
    assert_int_equal(fewray_scene_load(path, &options, &scene, &error), FEWRAY_OK);
    assert_int_equal(scene->sample_count, 9);
    assert_int_equal(scene->camera.width, 164);
    assert_int_equal(scene->camera.height, 64);
    fewray_scene_destroy(&scene);

    options.defines = unused;
    assert_int_equal(fewray_scene_load(path, &options, &scene, &error), FEWRAY_ERROR_ARGUMENT);
    assert_non_null(strstr(error.what, "$depth"));
    options.defines = malformed;
    assert_int_equal(fewray_scene_load(path, &options, &scene, &error), FEWRAY_ERROR_ARGUMENT);
}

/* Mitsuba's own x_fov for a film of 400 x 300 pixels. */
static void test_field_of_view_axes(void **state) {
    static const struct {
        const char *parameters;
        double degrees;
    } cases[] = {
        {"<float name='fov' value='50'/>", 50},
        {"<float name='fov' value='50'/><string name='fov_axis' value='y'/>", 63.742031},
        {"<float name='fov' value='50'/><string name='fov_axis' value='diagonal'/>", 40.915672},
        {"<float name='fov' value='50'/><string name='fov_axis' value='smaller'/>", 63.742031},
        {"<float name='fov' value='50'/><string name='fov_axis' value='larger'/>", 50},
        {"", 38.184841},
        {"<string name='focal_length' value='35mm'/>", 52.622543},
    };
    (void)state;
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++) {
        char text[1024];
        struct fewray_scene *scene = NULL;
        struct fewray_error error = {0};
        snprintf(text, sizeof(text),
                 "<scene version='3.0.0'><sensor type='perspective'>%s<film type='hdrfilm'>"
                 "<integer name='width' value='400'/><integer name='height' value='300'/></film>"
                 "</sensor></scene>",
                 cases[i].parameters);
        assert_int_equal(fewray_scene_load(scratch_text("fov.xml", text), NULL, &scene, &error),
                         FEWRAY_OK);
        assert_near(scene->camera.fov_x * 180 / 3.14159265358979, cases[i].degrees, 1e-4);
        fewray_scene_destroy(&scene);
    }
}

static void test_transforms_apply_in_order(void **state) {
    struct fewray_scene *scene = scratch_scene(
        "<shape type='rectangle'><transform name='to_world'><translate x='1'/>"
        "<rotate z='1' angle='90'/><scale value='2'/></transform></shape>"
        "<shape type='rectangle'><transform name='to_world'><matrix value='0 -2 0 2 0 0 0 2 0'/>"
        "<translate value='0, 2, 0'/></transform></shape>"
        "<shape type='rectangle'><transform name='to_world'>"
        "<lookat origin='1,2,3' target='4 5 7' up='0,1,0'/></transform></shape>");
    (void)state;
    /* (-1, -1, 0) -> (0, -1, 0) -> (1, 0, 0) -> (2, 0, 0) */
    assert_near(scene->meshes[0].positions[0], 2, 1e-6);
    assert_near(scene->meshes[0].positions[1], 0, 1e-6);
    for (int i = 0; i < 4; i++) {
        assert_near(scene->meshes[1].positions[3 * i], -2 * scene->meshes[0].uvs[2 * i + 1] * 2 + 2,
                    1e-6);
    }
    struct vec3 n = face_normal(&scene->meshes[2], 0);
    assert_near(n.x, 0.514496, 1e-5);
    assert_near(n.y, 0.514496, 1e-5);
    assert_near(n.z, 0.685994, 1e-5);
    fewray_scene_destroy(&scene);
}

static void test_simple_shapes(void **state) {
    struct fewray_scene *scene =
        scratch_scene("<shape type='rectangle'/><shape type='disk'/><shape type='cube'/>"
                      "<shape type='cylinder'><float name='radius' value='2'/></shape>"
                      "<shape type='sphere'><point name='center' x='1' y='2' z='3'/>"
                      "<float name='radius' value='2'/></shape>");
    const double areas[] = {4, 3.14159265, 24, 4 * 3.14159265};
    (void)state;
    for (int i = 0; i < 4; i++)
        assert_near(mesh_area(&scene->meshes[i]) / areas[i], 1, 1e-4);
    assert_near(face_normal(&scene->meshes[0], 0).z, 1, 1e-6);
    assert_near(face_normal(&scene->meshes[1], 100).z, 1, 1e-6);
    for (int m = 2; m < 4; m++) {
        struct vec3 center = m == 2 ? vec(0, 0, 0) : vec(0, 0, 0.5f);
        const struct mesh *mesh = &scene->meshes[m];
        for (uint32_t t = 0; t < mesh->triangle_count; t++)
            assert_true(dot(face_normal(mesh, t), sub(corner(mesh, t, 0), center)) > 0);
    }
    assert_null(scene->meshes[2].normals);
    assert_non_null(scene->meshes[3].normals);
    assert_int_equal(scene->meshes[4].kind, MESH_SPHERE);
    for (int i = 0; i < 4; i++)
        assert_near(scene->meshes[4].sphere[i], i < 3 ? i + 1 : 2, 1e-6);
    fewray_scene_destroy(&scene);
}

/* Mitsuba: rectangle, disk and cube keep their front when mirrored, a sphere turns inside out, and
 * a mesh file without normals is mirrored with its winding. */
static void test_mirrored_and_flipped_shapes(void **state) {
    scratch_text("triangle.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    scratch_text("normals.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
    const struct {
        const char *shape, *rest;
        float side;
    } cases[] = {
        {"rectangle", "", 1},
        {"disk", "", 1},
        {"obj", "<string name='filename' value='triangle.obj'/>", -1},
        {"obj", "<string name='filename' value='normals.obj'/>", 1},
        {"obj",
         "<string name='filename' value='normals.obj'/>"
         "<boolean name='face_normals' value='true'/>",
         -1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++)
        for (int flip = 0; flip < 2; flip++) {
            char body[512];
            snprintf(body, sizeof(body),
                     "<shape type='%s'>%s<boolean name='flip_normals' value='%s'/>"
                     "<transform name='to_world'><scale x='-1'/></transform></shape>",
                     cases[i].shape, cases[i].rest, flip ? "true" : "false");
            struct fewray_scene *scene = scratch_scene(body);
            float side = flip ? -cases[i].side : cases[i].side;
            assert_near(face_normal(&scene->meshes[0], 0).z, side, 1e-6);
            if (scene->meshes[0].normals)
                assert_near(scene->meshes[0].normals[2], side, 1e-6);
            fewray_scene_destroy(&scene);
        }
    struct fewray_scene *scene =
        scratch_scene("<shape type='sphere'><transform name='to_world'><scale x='-1'/></transform>"
                      "</shape>");
    assert_true(scene->meshes[0].flip_normals);
    fewray_scene_destroy(&scene);
}

static void test_uv_of_obj_is_flipped_and_of_ply_is_not(void **state) {
    scratch_text("uv.obj",
                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.1 0.2\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
    scratch_text("uv.ply",
                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                 "property float y\nproperty float z\nproperty float u\nproperty float v\n"
                 "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                 "0 0 0 0.1 0.2\n1 0 0 1 0\n0 1 0 nan 1\n3 0 1 2\n");
    struct fewray_scene *scene =
        scratch_scene("<shape type='obj'><string name='filename' value='uv.obj'/></shape>"
                      "<shape type='ply'><string name='filename' value='uv.ply'/></shape>"
                      "<shape type='obj'><string name='filename' value='uv.obj'/>"
                      "<boolean name='flip_tex_coords' value='false'/></shape>");
    (void)state;
    assert_near(scene->meshes[0].uvs[1], 0.8, 1e-6);
    assert_near(scene->meshes[1].uvs[1], 0.2, 1e-6);
    assert_near(scene->meshes[2].uvs[1], 0.2, 1e-6);
    assert_near(scene->meshes[1].uvs[4], 0, 0);
    fewray_scene_destroy(&scene);
}

/* Of the BSDF itself, or of the one that it has on its front. */
static struct texture reflectance_of(const struct fewray_scene *scene, int mesh) {
    const struct bsdf *bsdf = &scene->bsdfs[scene->meshes[mesh].bsdf];
    while (bsdf->nested[0] >= 0)
        bsdf = &scene->bsdfs[bsdf->nested[0]];
    return scene->textures[bsdf->reflectance];
}

static void test_colors(void **state) {
    struct fewray_scene *scene = scratch_scene(
        "<bsdf type='diffuse' id='a'><rgb name='reflectance' value='0.1, 0.2 0.3'/></bsdf>"
        "<shape type='cube'><ref id='a'/></shape>"
        "<shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' value='#ff8000'/></bsdf>"
        "</shape>"
        "<shape type='cube'><bsdf type='diffuse'><spectrum name='reflectance' value='0.4'/></bsdf>"
        "</shape>"
        "<shape type='cube'/>"
        "<shape type='cube'><emitter type='area'><spectrum name='radiance' value='2'/></emitter>"
        "</shape>");
    (void)state;
    assert_near(reflectance_of(scene, 0).color0.y, 0.2, 1e-7);
    assert_near(reflectance_of(scene, 1).color0.x, 1, 1e-7);
    assert_near(reflectance_of(scene, 1).color0.y, 0.215861, 1e-5);
    assert_near(reflectance_of(scene, 2).color0.z, 0.4, 1e-7);
    assert_near(reflectance_of(scene, 3).color0.z, 0.5, 1e-7);
    assert_near(reflectance_of(scene, 4).color0.z, 0, 0);
    /* Mitsuba's RGB of a flat emission spectrum. */
    assert_near(emission_of(scene, 4).x, 2.40959, 1e-4);
    assert_near(emission_of(scene, 4).z, 1.81783, 1e-4);
    assert_int_equal(scene->bsdfs[scene->meshes[0].bsdf].kind, BSDF_DIFFUSE);
    fewray_scene_destroy(&scene);
}

static void test_textures_are_shared(void **state) {
    static const uint8_t red[3] = {255, 0, 0};
    struct fewray_error error;
    assert_int_equal(fewray_image_write_png(scratch_path("red.png"), 1, 1, red, &error), FEWRAY_OK);
    struct fewray_scene *scene = scratch_scene(
        "<texture type='bitmap' id='t'><string name='filename' value='red.png'/>"
        "<string name='filter_type' value='nearest'/><transform name='to_uv'><scale x='2' y='3'/>"
        "<translate x='0.5'/></transform></texture>"
        "<bsdf type='twosided' id='b'><bsdf type='diffuse'><ref name='reflectance' id='t'/></bsdf>"
        "</bsdf>"
        "<shape type='cube'><ref id='b'/></shape>"
        "<shape type='cube'><ref id='b'/></shape>"
        "<shape type='cube'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'>"
        "<string name='filename' value='red.png'/><string name='wrap_mode' "
        "value='clamp'/></texture>"
        "</bsdf></shape>");
    const float to_uv[6] = {2, 0, 0.5f, 0, 3, 0};
    (void)state;
    assert_int_equal(scene->image_count, 1);
    assert_int_equal(scene->bsdf_count, 3);
    assert_int_equal(scene->warning_count, 0);
    assert_int_equal(scene->bsdfs[scene->meshes[1].bsdf].kind, BSDF_TWOSIDED);
    struct texture texture = reflectance_of(scene, 0);
    assert_int_equal(texture.kind, TEXTURE_BITMAP);
    assert_ptr_equal(texture.image, scene->images[0]);
    assert_true(texture.nearest && texture.srgb);
    assert_memory_equal(texture.to_uv, to_uv, sizeof(to_uv));
    assert_int_equal(texture.wrap, WRAP_REPEAT);
    assert_false(reflectance_of(scene, 2).nearest);
    assert_int_equal(reflectance_of(scene, 2).wrap, WRAP_CLAMP);
    fewray_scene_destroy(&scene);
}

static void test_textures_of_unused_materials_are_not_read(void **state) {
    struct fewray_scene *scene =
        scratch_scene("<texture type='bitmap' id='t'><string name='filename' value='none.png'/>"
                      "</texture><bsdf type='normalmap' id='n'><texture type='bitmap' "
                      "name='normalmap'><string name='filename' value='nowhere.png'/></texture>"
                      "<bsdf type='diffuse'><ref name='reflectance' id='t'/></bsdf></bsdf>"
                      "<shape type='cube'><bsdf type='diffuse'/></shape>");
    (void)state;
    assert_int_equal(scene->image_count, 0);
    assert_int_equal(scene->unused_textures, 2);
    fewray_scene_destroy(&scene);
}

static void test_environment_map_is_float_rgb(void **state) {
    static const uint8_t grey[6] = {188, 188, 188, 0, 0, 0};
    struct fewray_error error;
    assert_int_equal(fewray_image_write_png(scratch_path("sky.png"), 2, 1, grey, &error),
                     FEWRAY_OK);
    struct fewray_scene *scene = scratch_scene(
        "<emitter type='envmap'><string name='filename' value='sky.png'/>"
        "<float name='scale' value='2.5'/><transform name='to_world'><rotate y='1' angle='90'/>"
        "</transform></emitter>");
    (void)state;
    const struct environment *environment = &scene->environment;
    assert_int_equal(environment->kind, ENVIRONMENT_MAP);
    assert_int_equal(environment->image->channels, 3);
    assert_null(environment->image->bytes);
    assert_near(environment->image->floats[0], 0.502886, 1e-5);
    assert_near(environment->scale, 2.5, 0);
    /* The world's +x is where the map's +z went. */
    assert_near(environment->to_local[0], 0, 1e-6);
    assert_near(environment->to_local[6], 1, 1e-6);
    fewray_scene_destroy(&scene);
}

static void test_unused_parameters_are_warned_of_once(void **state) {
    struct fewray_scene *scene =
        scratch_scene("<shape type='cube'><float name='colour' value='1'/></shape>\n"
                      "<shape type='cube'><float name='colour' value='2'/></shape>");
    (void)state;
    assert_int_equal(scene->warning_count, 1);
    assert_non_null(strstr(scene->warnings[0], ":2: parameter colour of shape 'cube'"));
    fewray_scene_destroy(&scene);
}

static void test_warnings_without_end_are_cut(void **state) {
    enum { PARAMETERS = 1200, SHOWN = 1000 };
    char *text = malloc(PARAMETERS * 64), *end = text;
    (void)state;
    assert_non_null(text);
    end += sprintf(end, "<shape type='cube'>");
    for (int i = 0; i < PARAMETERS; i++)
        end += sprintf(end, "<float name='x%d' value='1'/>", i);
    sprintf(end, "</shape>");
    struct fewray_scene *scene = scratch_scene(text);
    assert_int_equal(scene->warning_count, SHOWN + 1);
    assert_non_null(strstr(scene->warnings[SHOWN], "more warnings"));
    fewray_scene_destroy(&scene);
    free(text);
}

static void test_a_scene_may_be_empty(void **state) {
    struct fewray_scene *scene = scratch_scene("");
    (void)state;
    assert_int_equal(scene->mesh_count, 0);
    assert_int_equal(scene->environment.kind, ENVIRONMENT_NONE);
    assert_int_equal(scene->camera.width, 768);
    fewray_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_data_scene),
        cmocka_unit_test(test_any_number_of_threads_loads_the_same),
        cmocka_unit_test(test_defines_and_defaults),
        cmocka_unit_test(test_field_of_view_axes),
        cmocka_unit_test(test_transforms_apply_in_order),
        cmocka_unit_test(test_simple_shapes),
        cmocka_unit_test(test_mirrored_and_flipped_shapes),
        cmocka_unit_test(test_uv_of_obj_is_flipped_and_of_ply_is_not),
        cmocka_unit_test(test_colors),
        cmocka_unit_test(test_textures_are_shared),
        cmocka_unit_test(test_textures_of_unused_materials_are_not_read),
        cmocka_unit_test(test_environment_map_is_float_rgb),
        cmocka_unit_test(test_unused_parameters_are_warned_of_once),
        cmocka_unit_test(test_warnings_without_end_are_cut),
        cmocka_unit_test(test_a_scene_may_be_empty),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
