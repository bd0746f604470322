/* SPDX-License-Identifier: Apache-2.0 */
/* What is wrong with a scene is told in one line, with the file's line and the name at fault. */

#include "scene_scratch.h"

struct broken {
    const char *body; /* starts in line 2 */
    int line;
    const char *what; /* part of the message */
};

static void expect_refusal(const struct broken *broken) {
    struct fewray_scene *scene = NULL;
    struct fewray_error error;
    int status = scratch_load(broken->body, &scene, &error);
    if (status >= 0 || scene)
        fail_msg("accepted: %s", broken->body);
    if (!strstr(error.what, broken->what) || strchr(error.what, '\n'))
        fail_msg("'%s' lacks '%s'", error.what, broken->what);
    if (error.line != broken->line)
        fail_msg("line %d instead of %d: %s", error.line, broken->line, error.what);
    assert_non_null(strstr(error.file, "scene.xml"));
}

static void expect_refusals(const struct broken *cases, size_t count) {
    for (size_t i = 0; i < count; i++)
        expect_refusal(&cases[i]);
}

#define COUNT(array) (sizeof(array) / sizeof(*(array)))

static void test_plugins_that_mitsuba_lacks(void **state) {
    static const struct broken cases[] = {
        {"<integrator type='pathh'/>", 2, "unknown integrator type 'pathh'"},
        {"\n<shape type='teapot'/>", 3, "unknown shape type 'teapot'"},
        {"<bsdf type='phong' id='a'/>", 2, "unknown bsdf type 'phong'"},
        {"<shape type='cube'><bsdf type='diffuse'>\n<texture type='marble' name='reflectance'/>"
         "</bsdf></shape>",
         3, "unknown texture type 'marble'"},
        {"<emitter type='sky'/>", 2, "unknown emitter type 'sky'"},
        {"<sensor type='fisheye'/>", 2, "unknown sensor type 'fisheye'"},
        {"<sensor type='perspective'><film type='ldrfilm'/></sensor>", 2, "film type 'ldrfilm'"},
        {"<sensor type='perspective'><sampler type='sobol'/></sensor>", 2, "sampler type 'sobol'"},
        {"<sensor type='perspective'><film type='hdrfilm'><rfilter type='sinc'/></film></sensor>",
         2, "rfilter type 'sinc'"},
        {"<shape/>", 2, "<shape> has no type"},
        {"<sphere/>", 2, "unknown element <sphere>"},
    };
    (void)state;
    expect_refusals(cases, COUNT(cases));
}

static void test_plugins_not_supported_yet(void **state) {
    static const struct broken cases[] = {
        {"<shape type='sdfgrid'/>", 2, "shape 'sdfgrid' is not supported"},
        {"<emitter type='projector'/>", 2, "emitter 'projector' is not supported yet"},
        {"<emitter type='spot'><texture type='checkerboard' name='texture'/></emitter>", 2,
         "spot with a texture"},
        {"<shape type='cube'><emitter type='directionalarea'/></shape>", 2,
         "emitter 'directionalarea' in a shape is not supported yet"},
        {"<integrator type='ptracer'/>", 2, "integrator 'ptracer' is not supported yet"},
        {"<integrator type='aov'><integrator type='path'/></integrator>", 2,
         "integrator 'aov' is not supported yet"},
        {"<bsdf type='hair' id='a'/>\n<shape type='cube'><ref id='a'/></shape>", 2,
         "bsdf 'hair' (id 'a') is not supported yet"},
        {"<shape type='cube'><bsdf type='mask'><bsdf type='pplastic'/></bsdf></shape>", 2,
         "bsdf 'pplastic' is not supported yet"},
        {"<shape type='cube'><bsdf type='diffuse'><texture type='volume' name='reflectance'/>"
         "</bsdf></shape>",
         2, "texture 'volume' is not supported yet"},
        {"<shape type='cube'>\n<medium type='homogeneous' name='interior'/></shape>", 3,
         "medium 'homogeneous' is not supported yet"},
    };
    (void)state;
    expect_refusals(cases, COUNT(cases));
}

static void test_references(void **state) {
    static const struct broken cases[] = {
        {"<shape type='cube'>\n<ref id='nobody'/></shape>", 3, "'nobody'"},
        {"<ref id='nobody'/>", 2, "'nobody'"},
        {"<shape type='cube'><ref/></shape>", 2, "<ref> has no id"},
        {"<bsdf type='diffuse' id='a'/>\n<bsdf type='diffuse' id='a'/>", 3, "id 'a'"},
        {"<bsdf type='twosided' id='a'><ref id='a'/></bsdf>\n<shape type='cube'><ref "
         "id='a'/></shape>",
         2, "'a' refers to itself"},
        {"<bsdf type='mask' id='a'><ref id='b'/></bsdf><bsdf type='twosided' id='b'><ref id='a'/>"
         "</bsdf><shape type='cube'><ref id='a'/></shape>",
         2, "refers to itself"},
    };
    (void)state;
    expect_refusals(cases, COUNT(cases));
}

static void test_values(void **state) {
    static const struct broken cases[] = {
        {"<shape type='sphere'><float name='radius' value='big'/></shape>", 2, "radius = 'big'"},
        {"<shape type='sphere'><float name='radius' value='1e99'/></shape>", 2, "radius"},
        {"<shape type='sphere'><float name='radius' value='-1'/></shape>", 2, "radius"},
        {"<shape type='sphere'><float name='radius'/></shape>", 2, "has no value"},
        {"<shape type='sphere'><float value='1'/></shape>", 2, "has no name"},
        {"<shape type='sphere'><string name='radius' value='1'/></shape>", 2, "<float>"},
        {"<shape type='sphere'><float name='radius' value='1'/>\n<float name='radius' value='1'/>"
         "</shape>",
         3, "radius is given twice"},
        {"<shape type='obj'><boolean name='face_normals' value='yes'/></shape>", 2,
         "true or false"},
        {"<integrator type='path'><integer name='max_depth' value='3.5'/></integrator>", 2,
         "max_depth = '3.5'"},
        {"<integrator type='path'><integer name='max_depth' value='-2'/></integrator>", 2,
         "max_depth"},
        {"<shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' "
         "value='1.5'/></bsdf></shape>",
         2, "0..1"},
        {"<shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' value='0 -1 0'/></bsdf>"
         "</shape>",
         2, "reflectance = '0 -1 0'"},
        {"<shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' "
         "value='nan'/></bsdf></shape>",
         2, "reflectance = 'nan'"},
        {"<shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' value='1 "
         "1'/></bsdf></shape>",
         2, "reflectance = '1 1'"},
        {"<shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' value='#ff80'/></bsdf>"
         "</shape>",
         2, "#ff80"},
        {"<emitter type='constant'><rgb name='radiance' value='-1'/></emitter>", 2, "radiance"},
        {"<shape type='cube'><transform name='to_world'><matrix value='1 2 "
         "3'/></transform></shape>",
         2, "<matrix>"},
        {"<shape type='cube'><transform name='to_world'><rotate angle='3'/></transform></shape>", 2,
         "axis is zero"},
        {"<shape type='cube'><transform name='to_world'><scale value='1e30'/><scale value='1e30'/>"
         "</transform></shape>",
         2, "not finite"},
        {"<shape type='cube'><float name='$x' value='1'/></shape>", 2, "$x is not defined"},
    };
    (void)state;
    expect_refusals(cases, COUNT(cases));
}

static void test_structure(void **state) {
    static const struct broken cases[] = {
        {"<shape type='obj'/>", 2, "no filename"},
        {"<bsdf type='twosided' id='a'/><shape type='cube'><ref id='a'/></shape>", 2,
         "no BSDF inside"},
        {"<emitter type='constant'/>\n<emitter type='constant'/>", 3, "only one"},
        {"<emitter type='constant'/>\n<emitter type='sunsky'/>", 3, "only one"},
        {"<shape type='cube'><emitter type='spot'/></shape>", 2, "can't stand in a shape"},
        {"<emitter type='point'><point name='position' x='1'/><transform name='to_world'/>"
         "</emitter>",
         2, "both position and to_world"},
        {"<emitter type='directional'><vector name='direction' x='0'/></emitter>", 2,
         "direction is zero"},
        {"<emitter type='spot'><float name='beam_width' value='40'/></emitter>", 2, "beam_width"},
        {"<emitter type='envmap'><string name='filename' value='x.exr'/><transform "
         "name='to_world'><scale x='2'/></transform></emitter>",
         2, "must be a rotation"},
        {"<emitter type='area'/>", 2, "within a shape"},
        {"<shape type='cube'><emitter type='area'/><emitter type='area'/></shape>", 2,
         "two emitters"},
        {"<shape type='cube'><bsdf type='diffuse'/><bsdf type='diffuse'/></shape>", 2, "two BSDFs"},
        {"<shape type='cube'><translate x='1'/></shape>", 2, "can't stand within"},
        {"stray", 2, "text between the elements"},
        {"<shape type='cube'>\n</shap>", 3, "not well-formed XML"},
        {"<shape type='cube'>", 3, "not well-formed XML"},
    };
    (void)state;
    expect_refusals(cases, COUNT(cases));
}

static void test_files(void **state) {
    static const struct broken cases[] = {
        {"<shape type='ply'><string name='filename' value='gone.ply'/></shape>", 2, "gone.ply"},
        {"\n<shape type='obj'><string name='filename' value='gone.obj'/></shape>", 3, "gone.obj"},
        {"<shape type='cube'><bsdf type='diffuse'>\n<texture type='bitmap' name='reflectance'>"
         "<string name='filename' value='gone.png'/></texture></bsdf></shape>",
         3, "gone.png"},
        {"<emitter type='envmap'><string name='filename' value='gone.exr'/></emitter>", 2,
         "gone.exr"},
        {"<shape type='obj'><string name='filename' value='.'/></shape>", 2, "irectory"},
        /* Of several, the first that the scene names. */
        {"<shape type='ply'><string name='filename' value='gone1.ply'/></shape>"
         "<shape type='ply'><string name='filename' value='gone2.ply'/></shape>"
         "<shape type='ply'><string name='filename' value='gone3.ply'/></shape>",
         2, "gone1.ply"},
    };
    (void)state;
    expect_refusals(cases, COUNT(cases));
}

static void test_damaged_mesh_names_file_and_line(void **state) {
    struct fewray_scene *scene = NULL;
    struct fewray_error error;
    (void)state;
    scratch_text("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
    assert_true(scratch_load("<shape type='obj'><string name='filename' value='bad.obj'/></shape>",
                             &scene, &error) < 0);
    assert_non_null(strstr(error.file, "bad.obj"));
    assert_int_equal(error.line, 4);
    assert_non_null(strstr(error.what, "scene.xml:2"));
}

static int load_text(const char *text, struct fewray_error *error) {
    struct fewray_scene *scene = NULL;
    memset(error, 0, sizeof(*error));
    int status = fewray_scene_load(scratch_text("whole.xml", text), NULL, &scene, error);
    fewray_scene_destroy(&scene);
    return status;
}

static void test_whole_files(void **state) {
    static const struct {
        const char *text, *what;
    } cases[] = {
        {"", "not well-formed"},
        {"<scene version='3.0.0'/>", "no sensor"},
        {"<scene/>", "no version"},
        {"<scene version='0.6.0'>" SENSOR "</scene>", "only Mitsuba 3"},
        {"<scene version='new'>" SENSOR "</scene>", "version"},
        {"<svg version='3.0.0'/>", "<svg>"},
        {"<scene version='3.0.0'><sensor type='orthographic'/></scene>", "not supported yet"},
        {"<scene version='3.0.0'><sensor type='perspective'><float name='fov' "
         "value='180'/></sensor>"
         "</scene>",
         "fov"},
        {"<scene version='3.0.0'><sensor type='perspective'><transform name='to_world'>"
         "<scale value='2'/></transform></sensor></scene>",
         "must not scale"},
        {"<scene version='3.0.0'><sensor type='thinlens'/></scene>", "no aperture_radius"},
        {"<scene version='3.0.0'><sensor type='thinlens'><float name='aperture_radius' value='1'/>"
         "<float name='focus_distance' value='0'/></sensor></scene>",
         "focus_distance = 0"},
        {"<scene version='3.0.0'><sensor type='perspective'><film type='hdrfilm'>"
         "<integer name='width' value='0'/></film></sensor></scene>",
         "width"},
    };
    struct fewray_error error;
    (void)state;
    for (size_t i = 0; i < COUNT(cases); i++) {
        assert_true(load_text(cases[i].text, &error) < 0);
        if (!strstr(error.what, cases[i].what))
            fail_msg("'%s' lacks '%s'", error.what, cases[i].what);
    }
    struct fewray_scene *scene;
    assert_int_equal(fewray_scene_load(scratch_path("gone.xml"), NULL, &scene, &error),
                     FEWRAY_ERROR_IO);
    assert_int_equal(fewray_scene_load(scratch_folder, NULL, &scene, &error), FEWRAY_ERROR_IO);
}

static void test_entities_and_depth_are_bounded(void **state) {
    static char deep[20000];
    struct fewray_error error;
    (void)state;
    assert_true(load_text("<!DOCTYPE scene [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;'>]>"
                          "<scene version='3.0.0'>&b;</scene>",
                          &error) < 0);
    assert_non_null(strstr(error.what, "entity"));
    strcpy(deep, "<scene version='3.0.0'>");
    for (int i = 0; i < 500; i++)
        strcat(deep, "<bsdf type='mask'>");
    assert_true(load_text(deep, &error) < 0);
    assert_non_null(strstr(error.what, "deeper"));
}

/* Cuts the data scene anywhere, and breaks each of its bytes: never a crash, never a silent success
 * of a cut. */
static void test_cut_and_broken_xml(void **state) {
    static char text[16384], broken[16384];
    struct fewray_error error;
    FILE *file = fopen(TEST_DATA "/scene/box.xml", "rb");
    (void)state;
    assert_non_null(file);
    size_t size = fread(text, 1, sizeof(text) - 1, file);
    fclose(file);
    for (size_t cut = 0; cut < size - 10; cut += 7) {
        memcpy(broken, text, cut);
        broken[cut] = 0;
        assert_true(load_text(broken, &error) < 0);
        assert_true(error.what[0] != 0);
    }
    for (size_t i = 0; i < size; i += 3) {
        memcpy(broken, text, size + 1);
        broken[i] = (char)(broken[i] ^ 0x15);
        load_text(broken, &error);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plugins_that_mitsuba_lacks),
        cmocka_unit_test(test_plugins_not_supported_yet),
        cmocka_unit_test(test_references),
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_structure),
        cmocka_unit_test(test_files),
        cmocka_unit_test(test_damaged_mesh_names_file_and_line),
        cmocka_unit_test(test_whole_files),
        cmocka_unit_test(test_entities_and_depth_are_bounded),
        cmocka_unit_test(test_cut_and_broken_xml),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
