/* SPDX-License-Identifier: Apache-2.0 */
/* Emitters, sensors, colours of spectra and included files arrive as Mitsuba 3.9.1 (scalar_rgb)
 * reads them. */

#include <sys/stat.h>

#include "guide/scene/sun_position.h"
#include "scene_scratch.h"

static void expect_vector(struct vec3 v, double x, double y, double z, double tolerance) {
    assert_near(v.x, x, tolerance);
    assert_near(v.y, y, tolerance);
    assert_near(v.z, z, tolerance);
}

static void test_lights_without_a_surface(void **state) {
    struct fewray_scene *scene = scratch_scene(
        "<emitter type='point'/>"
        "<emitter type='point'><transform name='to_world'><scale value='2'/><translate x='1'/>"
        "</transform><rgb name='intensity' value='3 2 1'/></emitter>"
        "<emitter type='point'><point name='position' x='1' y='2' z='3'/><spectrum "
        "name='intensity' value='2'/><float name='sampling_weight' value='2'/></emitter>"
        "<emitter type='spot'><transform name='to_world'><lookat origin='1,2,3' target='1,2,7' "
        "up='0,1,0'/></transform></emitter>"
        "<emitter type='spot'><float name='cutoff_angle' value='30'/><float name='beam_width' "
        "value='10'/></emitter>"
        "<emitter type='directional'><vector name='direction' x='0' y='3' z='-4'/><rgb "
        "name='irradiance' value='3 2 1'/></emitter>"
        "<emitter type='directional'><transform name='to_world'><scale value='2'/><rotate x='1' "
        "angle='90'/></transform></emitter>"
        "<emitter type='point'><rgb name='intensity' value='0'/></emitter>");
    const struct light *lights = scene->lights;
    const double degrees = 3.14159265358979 / 180;
    (void)state;
    assert_int_equal(scene->light_count, 7); /* the black one is left out */
    assert_int_equal(fewray_scene_summarize(scene).emitters, 7);
    expect_vector(lights[0].position, 0, 0, 0, 0);
    expect_vector(lights[0].intensity, 1, 1, 1, 0);
    expect_vector(lights[1].position, 1, 0, 0, 1e-6);
    expect_vector(lights[2].position, 1, 2, 3, 0);
    expect_vector(lights[2].intensity, 2.40959, 1.89658, 1.81783, 1e-4);
    assert_int_equal(lights[3].kind, LIGHT_SPOT);
    expect_vector(lights[3].position, 1, 2, 3, 1e-6);
    expect_vector(lights[3].direction, 0, 0, 1, 1e-6);
    assert_near(lights[3].cutoff, 20 * degrees, 1e-6);
    assert_near(lights[3].beam_width, 15 * degrees, 1e-6);
    assert_near(lights[4].cutoff, 30 * degrees, 1e-6);
    assert_near(lights[4].beam_width, 10 * degrees, 1e-6);
    assert_int_equal(lights[5].kind, LIGHT_DIRECTIONAL);
    expect_vector(lights[5].direction, 0, 0.6, -0.8, 1e-6);
    expect_vector(lights[5].intensity, 3, 2, 1, 0);
    expect_vector(lights[6].direction, 0, -1, 0, 1e-6);
    assert_int_equal(scene->warning_count, 0);
    fewray_scene_destroy(&scene);
}

static void test_textured_and_black_area_emitters(void **state) {
    struct fewray_scene *scene = scratch_scene(
        "<shape type='rectangle'><emitter type='area'><texture type='checkerboard' "
        "name='radiance'><rgb name='color0' value='7 8 9'/></texture></emitter></shape>"
        "<shape type='rectangle'><emitter type='area'><rgb name='radiance' value='0'/></emitter>"
        "</shape>"
        "<shape type='rectangle'><emitter type='area'/></shape>");
    const struct texture *texture = &scene->textures[scene->meshes[0].emission];
    (void)state;
    assert_int_equal(texture->kind, TEXTURE_CHECKERBOARD);
    expect_vector(texture->color0, 7, 8, 9, 0);
    assert_int_equal(scene->meshes[1].emission, -1);
    expect_vector(scene->textures[scene->meshes[2].emission].color0, 1, 1, 1, 0);
    assert_int_equal(fewray_scene_summarize(scene).emitters, 2);
    fewray_scene_destroy(&scene);
}

/* Mitsuba computes in 32 bits, and loses some ten seconds. */
static void test_position_of_the_sun(void **state) {
    static const struct {
        struct sun_time time;
        double x, y, z;
    } cases[] = {
        {{35.6894, 139.6917, 9, 2010, 7, 10, 15, 0, 0}, 0.05138545, 0.691748, 0.7203085},
        {{10, 139.6917, 9, 2010, 7, 10, 15, 0, 0}, -0.2659597, 0.6917467, 0.6713807},
        {{35.6894, 139.6917, 9, 2010, 7, 10, 23, 0, 0}, -0.8359671, 0.1869206, -0.5159647},
        {{48.5, -2, -1, 2024, 12, 21, 9, 30, 15}, 0.8912578, -0.3733645, 0.2574073},
        {{-33.9, 151.2, 10, 2010, 1, 3, 15, 0, 0}, -0.04079524, 0.6529884, 0.7562684},
    };
    (void)state;
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++)
        expect_vector(sun_position(&cases[i].time), cases[i].x, cases[i].y, cases[i].z, 3e-4);
}

/* The map turns with to_world, as the sun does; by default z is up. */
static void test_sunsky(void **state) {
    struct fewray_scene *scene = scratch_scene(
        "<emitter type='sunsky'><vector name='sun_direction' x='1' y='2' z='3'/></emitter>");
    const float upright[9] = {1, 0, 0, 0, 0, 1, 0, -1, 0};
    (void)state;
    assert_int_equal(scene->environment.kind, ENVIRONMENT_MAP);
    assert_non_null(scene->environment.image);
    assert_int_equal(scene->image_count, 1);
    assert_int_equal(scene->light_count, 1);
    assert_int_equal(scene->lights[0].kind, LIGHT_SUN);
    expect_vector(scene->lights[0].direction, 0.267261, 0.534522, 0.801784, 1e-5);
    for (int i = 0; i < 9; i++)
        assert_near(scene->environment.to_local[i], upright[i], 1e-6);
    fewray_scene_destroy(&scene);

    scene = scratch_scene("<emitter type='sunsky'><transform name='to_world'><rotate x='1' "
                          "angle='90'/></transform><float name='turbidity' value='5'/><rgb "
                          "name='albedo' value='.1 .2 .3'/></emitter>");
    expect_vector(scene->lights[0].direction, 0.0513854, -0.7203085, 0.691748, 1e-4);
    /* What is up in the emitter, its z, is the world's -y. */
    assert_near(scene->environment.to_local[4], -1, 1e-6);
    assert_int_equal(scene->warning_count, 0);
    fewray_scene_destroy(&scene);

    scene = scratch_scene("<emitter type='sunsky'><float name='sun_scale' value='0'/></emitter>");
    assert_int_equal(scene->light_count, 0);
    fewray_scene_destroy(&scene);
}

static int load_sensor(const char *sensor, struct fewray_scene **out, struct fewray_error *error) {
    char text[1024];
    snprintf(text, sizeof(text), "<scene version='3.0.0'>%s</scene>", sensor);
    return fewray_scene_load(scratch_text("sensor.xml", text), NULL, out, error);
}

static void test_sensors(void **state) {
    static const struct {
        const char *text;
        float radius, distance, x, y;
    } cases[] = {
        {"<sensor type='perspective'><float name='principal_point_offset_x' value='0.1'/>"
         "<float name='principal_point_offset_y' value='-0.2'/></sensor>",
         0, 0, 0.1f, -0.2f},
        {"<sensor type='thinlens'><float name='aperture_radius' value='0.1'/></sensor>", 0.1f, 1e4f,
         0, 0},
        {"<sensor type='thinlens'><float name='aperture_radius' value='0.1'/><float "
         "name='far_clip' value='30'/></sensor>",
         0.1f, 30, 0, 0},
        {"<sensor type='thinlens'><float name='aperture_radius' value='0.1'/><float "
         "name='focus_distance' value='3'/></sensor>",
         0.1f, 3, 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++) {
        struct fewray_scene *scene = NULL;
        struct fewray_error error = {0};
        if (load_sensor(cases[i].text, &scene, &error))
            fail_msg("%s", error.what);
        assert_near(scene->camera.aperture_radius, cases[i].radius, 0);
        assert_near(scene->camera.focus_distance, cases[i].distance, 0);
        assert_near(scene->camera.principal_x, cases[i].x, 0);
        assert_near(scene->camera.principal_y, cases[i].y, 0);
        assert_int_equal(scene->warning_count, 0);
        fewray_scene_destroy(&scene);
    }
}

#define LIST "400:0.1, 500:0.5, 600:0.9, 700:0.3"

/* As a reflectance and as a radiance. */
static void test_spectra(void **state) {
    static const struct {
        const char *spectrum; /* %s: the parameter's name */
        double reflectance[3], radiance[3];
    } cases[] = {
        {"<spectrum name='%s' value='0.4'/>", {0.4, 0.4, 0.4}, {0.481918, 0.379316, 0.363566}},
        {"<spectrum name='%s' value='" LIST "'/>",
         {0.854797, 0.68754, 0.265015},
         {0.999234, 0.6597, 0.229444}},
        {"<spectrum name='%s' value='400:0.1,700:0.9'/>",
         {0.742853, 0.48114, 0.208325},
         {0.872215, 0.458728, 0.181301}},
        {"<spectrum name='%s' value='500:0.5 510:0.6'/>",
         {0, 0.0431478, 0.00789797},
         {0, 0.0393629, 0.00719241}},
        {"<spectrum name='%s' value='360:2,830:2'/>", {1, 1, 1}, {2.40977, 1.89646, 1.81853}},
        {"<spectrum name='%s' filename='file.spd'/>",
         {0.854797, 0.68754, 0.265015},
         {0.999234, 0.6597, 0.229444}},
        {"<spectrum name='%s' type='regular'><float name='wavelength_min' value='400'/><float "
         "name='wavelength_max' value='700'/><string name='values' value='0.1, 0.5, 0.9, 0.3'/>"
         "</spectrum>",
         {0.854797, 0.68754, 0.265015},
         {0.999234, 0.6597, 0.229444}},
        {"<spectrum name='%s' type='irregular'><string name='wavelengths' value='400 500 600 700'/>"
         "<string name='values' value='0.1, 0.5, 0.9, 0.3'/></spectrum>",
         {0.854797, 0.68754, 0.265015},
         {0.999234, 0.6597, 0.229444}},
        {"<spectrum name='%s' type='d65'><float name='scale' value='0.5'/></spectrum>",
         {0.5, 0.5, 0.5},
         {0.5, 0.5, 0.5}},
        {"<spectrum name='%s' type='uniform'><float name='value' value='0.3'/></spectrum>",
         {0.3, 0.3, 0.3},
         {0.3, 0.3, 0.3}},
        {"<spectrum name='%s' type='srgb'><rgb name='color' value='.1 .2 .3'/></spectrum>",
         {0.1, 0.2, 0.3},
         {0.1, 0.2, 0.3}},
    };
    (void)state;
    scratch_text("file.spd", "# hello\n400 0.1\n500\t0.5 # green\n\n600 0.9 \r\n700 0.3");
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++) {
        char reflectance[512], radiance[512], body[2048];
        snprintf(reflectance, sizeof(reflectance), cases[i].spectrum, "reflectance");
        snprintf(radiance, sizeof(radiance), cases[i].spectrum, "radiance");
        snprintf(body, sizeof(body),
                 "<shape type='cube'><bsdf type='diffuse'>%s</bsdf></shape>"
                 "<emitter type='constant'>%s</emitter>",
                 reflectance, radiance);
        struct fewray_scene *scene = scratch_scene(body);
        const double *a = cases[i].reflectance, *b = cases[i].radiance;
        const struct bsdf *bsdf = &scene->bsdfs[scene->meshes[0].bsdf];
        expect_vector(scene->textures[bsdf->reflectance].color0, a[0], a[1], a[2], 1e-5);
        expect_vector(scene->environment.radiance, b[0], b[1], b[2], 1e-5);
        assert_int_equal(scene->warning_count, 0);
        fewray_scene_destroy(&scene);
    }
}

/* 5,000 K: 12,762.4 W/(m2 sr nm) at 600 nm, and 12,107.2 at 500 nm. */
static void test_blackbody(void **state) {
    struct fewray_scene *scene =
        scratch_scene("<emitter type='constant'><spectrum name='radiance' type='blackbody'>"
                      "<float name='temperature' value='5000'/></spectrum></emitter>");
    struct vec3 c = scene->environment.radiance;
    (void)state;
    assert_true(c.x > c.y && c.y > c.z);
    assert_near(luminance(c), 12700, 150);
    fewray_scene_destroy(&scene);
}

static void test_spectra_refused(void **state) {
    static const struct {
        const char *spectrum, *what;
    } cases[] = {
        {"<spectrum name='radiance' value='600:.5,500:.5'/>", "must increase"},
        {"<spectrum name='radiance' value='500:1'/>", "at least two"},
        {"<spectrum name='radiance' value='500:1, 600'/>", "should look like"},
        {"<spectrum name='radiance' value='500:1, 600:1e999'/>", "finite"},
        {"<spectrum name='radiance' filename='gone.spd'/>", "gone.spd"},
        {"<spectrum name='radiance' filename='bad.spd'/>", "bad.spd:2: a spectrum's line"},
        {"<spectrum name='radiance' type='blackbody'/>", "no temperature"},
        {"<spectrum name='radiance' type='uniform'/>", "has no value"},
        {"<spectrum name='radiance' type='irregular'><string name='wavelengths' value='1 2'/>"
         "<string name='values' value='1'/></spectrum>",
         "at least two"},
    };
    (void)state;
    scratch_text("bad.spd", "400 1\n500 1 2\n");
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++) {
        char body[1024];
        struct fewray_scene *scene = NULL;
        struct fewray_error error;
        snprintf(body, sizeof(body), "<emitter type='constant'>%s</emitter>", cases[i].spectrum);
        if (scratch_load(body, &scene, &error) >= 0)
            fail_msg("accepted: %s", cases[i].spectrum);
        if (!strstr(error.what, cases[i].what))
            fail_msg("'%s' lacks '%s'", error.what, cases[i].what);
        assert_int_equal(error.line, 2);
    }
}

static void expect_reflectance(const struct fewray_scene *scene, int mesh, double grey) {
    const struct bsdf *bsdf = &scene->bsdfs[scene->meshes[mesh].bsdf];
    assert_near(scene->textures[bsdf->reflectance].color0.x, grey, 1e-6);
}

static void test_included_files(void **state) {
    scratch_text("materials.xml",
                 "<scene version='3.0.0'><default name='grey' value='0.9'/>"
                 "<bsdf type='diffuse' id='a'><float name='reflectance' value='$grey'/></bsdf>"
                 "<include filename='more.xml'/></scene>");
    scratch_text("more.xml", "<bsdf type='diffuse' id='b' version='3.0.0'><float "
                             "name='reflectance' value='0.3'/></bsdf>");
    scratch_text("inner.xml", "<bsdf type='diffuse' version='3.0.0'><float name='reflectance' "
                              "value='0.6'/></bsdf>");
    struct fewray_scene *scene =
        scratch_scene("<default name='grey' value='0.4'/><shape type='cube'><ref id='b'/></shape>"
                      "<include filename='materials.xml'/>"
                      "<alias id='a' as='c'/><alias id='c' as='d'/>"
                      "<shape type='cube'><ref id='d'/></shape>"
                      "<shape type='cube'><include filename='inner.xml'/></shape>");
    (void)state;
    assert_int_equal(scene->warning_count, 0);
    expect_reflectance(scene, 0, 0.3);
    expect_reflectance(scene, 1, 0.4);
    expect_reflectance(scene, 2, 0.6);
    fewray_scene_destroy(&scene);
}

/* The last <path> comes before the first, and all before the scene's own folder. */
static void test_folders_of_files(void **state) {
    char body[512];
    (void)state;
    scratch_text("which.xml", "<bsdf type='diffuse' version='3'><float name='reflectance' "
                              "value='0.1'/></bsdf>");
    assert_int_equal(mkdir(scratch_path("first"), 0700), 0);
    assert_int_equal(mkdir(scratch_path("second"), 0700), 0);
    scratch_text("second/which.xml", "<bsdf type='diffuse' version='3'><float name='reflectance' "
                                     "value='0.2'/></bsdf>");
    scratch_text("first/only.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (int i = 0; i < 2; i++) {
        snprintf(body, sizeof(body),
                 "<path value='%s'/><path value='%s'/><shape type='obj'><string name='filename' "
                 "value='only.obj'/><include filename='which.xml'/></shape>",
                 i ? "second" : "first", i ? "first" : "second");
        struct fewray_scene *scene = scratch_scene(body);
        expect_reflectance(scene, 0, 0.2);
        fewray_scene_destroy(&scene);
    }
    unlink(scratch_path("second/which.xml"));
    unlink(scratch_path("first/only.obj"));
    assert_int_equal(rmdir(scratch_path("first")), 0);
    assert_int_equal(rmdir(scratch_path("second")), 0);
}

static void test_broken_includes(void **state) {
    static const struct {
        const char *body, *file;
        int line;
        const char *what;
    } cases[] = {
        {"<include filename='gone.xml'/>", "scene.xml", 2, "gone.xml is not there"},
        {"<include/>", "scene.xml", 2, "no filename"},
        {"<include filename='self.xml'/>", "self.xml", 2, "includes itself"},
        {"<include filename='torn.xml'/>", "torn.xml", 3, "not well-formed"},
        {"<include filename='wrong.xml'/>", "wrong.xml", 2, "reflectance = 'red'"},
        {"<include filename='old.xml'/>", "old.xml", 1, "only Mitsuba 3"},
        {"<bsdf type='diffuse' id='a'/><include filename='twice.xml'/>", "twice.xml", 2,
         "id 'a' was given before, in line 2 of "},
        {"<include filename='self.xml'><bsdf type='diffuse'/></include>", "self.xml", 2, "includes itself"},
        {"<path value='.'>\n<bsdf type='diffuse'/></path>", "scene.xml", 3, "where nothing can"},
        {"<path value='nowhere'/>", "scene.xml", 2, "no folder"},
        {"<shape type='cube'><path value='.'/></shape>", "scene.xml", 2, "within <scene>"},
        {"<alias id='x' as='y'/>", "scene.xml", 2, "nothing above has the id 'x'"},
        {"<bsdf type='diffuse' id='x'/>\n<bsdf type='diffuse' id='y'/>\n<alias id='x' as='y'/>",
         "scene.xml", 4, "id 'y' was given before"},
    };
    (void)state;
    scratch_text("self.xml", "<scene version='3'>\n<include filename='self.xml'/></scene>");
    scratch_text("torn.xml", "<scene version='3'>\n<bsdf type='diffuse'>\n</scene>");
    scratch_text("wrong.xml", "<scene version='3'>\n<bsdf type='diffuse'><rgb name='reflectance' "
                              "value='red'/></bsdf></scene>");
    scratch_text("old.xml", "<scene version='0.6.0'/>");
    scratch_text("twice.xml", "<scene version='3'>\n<bsdf type='diffuse' id='a'/></scene>");
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++) {
        struct fewray_scene *scene = NULL;
        struct fewray_error error;
        if (scratch_load(cases[i].body, &scene, &error) >= 0)
            fail_msg("accepted: %s", cases[i].body);
        if (!strstr(error.what, cases[i].what) || !strstr(error.file, cases[i].file))
            fail_msg("'%s: %s' lacks '%s'", error.file, error.what, cases[i].what);
        assert_int_equal(error.line, cases[i].line);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lights_without_a_surface),
        cmocka_unit_test(test_textured_and_black_area_emitters),
        cmocka_unit_test(test_position_of_the_sun),
        cmocka_unit_test(test_sunsky),
        cmocka_unit_test(test_sensors),
        cmocka_unit_test(test_spectra),
        cmocka_unit_test(test_blackbody),
        cmocka_unit_test(test_spectra_refused),
        cmocka_unit_test(test_included_files),
        cmocka_unit_test(test_folders_of_files),
        cmocka_unit_test(test_broken_includes),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
