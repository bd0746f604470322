/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras that move: poses between keys, the XML's <animation>, $frame, and what is refused. */

#include "scene_scratch.h"

#include <math.h>

#include "guide/scene/camera_path.h"

/* A turn about y by degrees, placed at (x, y, z); mirrored: the camera's x axis is flipped. */
static struct transform pose(double degrees, double x, double y, double z, bool mirrored) {
    const double a = degrees * 3.14159265358979323846 / 180, sign = mirrored ? -1 : 1;
    return (struct transform){
        {{sign * cos(a), 0, sin(a), x}, {0, 1, 0, y}, {-sign * sin(a), 0, cos(a), z}}};
}

static void assert_pose(const float m[12], const struct transform *expected) {
    for (int i = 0; i < 12; i++)
        assert_near(m[i], expected->m[i / 4][i % 4], 1e-6);
}

static void test_positions_go_straight_and_rotations_evenly(void **state) {
    (void)state;
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        struct camera_key keys[3];
        const double degrees[3] = {10, 100, -80}, times[3] = {1, 2, 4};
        for (int k = 0; k < 3; k++) {
            const struct transform t = pose(degrees[k], 2 * k, k, -3 * k, mirrored);
            assert_true(camera_key_make(&t, times[k], &keys[k]));
        }
        /* A third of the way, between the second and third, and beyond both ends. The turn of 180
         * degrees goes either way, so only its ends are asked for. */
        const double at[5] = {1 + 1.0 / 3, 1, 2, 0, 9};
        const struct transform expected[5] = {
            pose(40, 2.0 / 3, 1.0 / 3, -1, mirrored), pose(10, 0, 0, 0, mirrored),
            pose(100, 2, 1, -3, mirrored), pose(10, 0, 0, 0, mirrored),
            pose(-80, 4, 2, -6, mirrored)};
        for (int i = 0; i < 5; i++) {
            float m[12];
            camera_path_at(keys, 3, at[i], m);
            assert_pose(m, &expected[i]);
        }
    }
}

static void test_rotations_take_the_shorter_way(void **state) {
    (void)state;
    struct camera_key keys[2];
    const struct transform a = pose(170, 0, 0, 0, false), b = pose(-170, 0, 0, 0, false);
    const struct transform middle = pose(180, 0, 0, 0, false);
    assert_true(camera_key_make(&a, 0, &keys[0]) && camera_key_make(&b, 1, &keys[1]));
    float m[12];
    camera_path_at(keys, 2, 0.5, m);
    assert_pose(m, &middle);
}

static void test_scaled_and_sheared_poses_are_no_keys(void **state) {
    (void)state;
    struct camera_key key;
    struct transform scaled = pose(0, 0, 0, 0, false), sheared = scaled;
    scaled.m[1][1] = 1.1;
    sheared.m[0][1] = 0.1;
    assert_false(camera_key_make(&scaled, 0, &key));
    assert_false(camera_key_make(&sheared, 0, &key));
}

#define SCENE_OF(to_world)                                                                         \
    "<scene version='3.0.0'>\n<sensor type='perspective'>\n" to_world                              \
    "\n<film type='hdrfilm'/></sensor>\n<shape type='sphere'/></scene>\n"
#define LOOK(x)      "<lookat origin='" x ",0,5' target='" x ",0,0' up='0,1,0'/>"
#define KEY(time, x) "<transform time='" time "'>" LOOK(x) "</transform>"

static int load_text(const char *text, const char *frame, struct fewray_scene **out,
                     struct fewray_error *error) {
    const struct fewray_scene_options options = {.frame = frame};
    memset(error, 0, sizeof *error);
    return fewray_scene_load(scratch_text("move.xml", text), &options, out, error);
}

static void test_an_animated_sensor_moves_with_the_time(void **state) {
    (void)state;
    struct fewray_scene *scene = NULL;
    struct fewray_error error;
    assert_int_equal(load_text(SCENE_OF("<animation name='to_world'>" KEY("0.5", "1")
                                            KEY("1.5", "3") "</animation>"),
                               "0", &scene, &error),
                     FEWRAY_OK);
    const double times[4] = {0, 0.75, 1.5, 2}, x[4] = {1, 1.5, 3, 3};
    assert_near(scene->camera.to_world[3], 1, 1e-6); /* as loaded: at second 0 */
    for (int i = 0; i < 4; i++) {
        fewray_scene_set_time(scene, times[i]);
        assert_near(scene->camera.to_world[3], x[i], 1e-6);
        assert_near(scene->camera.to_world[10], -1, 1e-6);
    }
    assert_int_equal(fewray_scene_summarize(scene).camera_keys, 2);
    assert_int_equal(scene->warning_count, 0);
    fewray_scene_destroy(&scene);
}

static void test_a_still_sensor_stays(void **state) {
    (void)state;
    struct fewray_scene *scene = NULL;
    struct fewray_error error;
    assert_int_equal(load_text(SCENE_OF("<transform name='to_world'>" LOOK("2") "</transform>"),
                               "3", &scene, &error),
                     FEWRAY_OK);
    const struct camera before = scene->camera;
    fewray_scene_set_time(scene, 7);
    assert_memory_equal(&before, &scene->camera, sizeof before);
    assert_false(fewray_scene_summarize(scene).uses_frame);
    fewray_scene_destroy(&scene);
}

static void test_the_number_of_the_frame_is_a_define(void **state) {
    (void)state;
    struct fewray_scene *scene = NULL;
    struct fewray_error error;
    const char *text = SCENE_OF("<default name='frame' value='1'/><transform name='to_world'>" LOOK(
        "$frame") "</transform>");
    const char *const frames[2] = {NULL, "12"};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(load_text(text, frames[i], &scene, &error), FEWRAY_OK);
        assert_near(scene->camera.to_world[3], i ? 12 : 1, 1e-6);
        assert_true(fewray_scene_summarize(scene).uses_frame);
        fewray_scene_destroy(&scene);
    }
    /* What the caller defines holds for all frames. */
    const char *const defines[] = {"frame=5"};
    const struct fewray_scene_options options = {
        .defines = defines, .define_count = 1, .frame = "12"};
    assert_int_equal(fewray_scene_load(scratch_text("move.xml", text), &options, &scene, &error),
                     FEWRAY_OK);
    assert_near(scene->camera.to_world[3], 5, 1e-6);
    assert_false(fewray_scene_summarize(scene).uses_frame);
    fewray_scene_destroy(&scene);
}

static void test_wrong_animations_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *text, *what;
        int line;
    } cases[] = {
        {SCENE_OF("<animation name='to_world'/>"), "no <transform>", 3},
        {SCENE_OF("<animation name='to_world'>" KEY("1", "0") "\n" KEY("1", "1") "</animation>"),
         "must rise", 4},
        {SCENE_OF("<animation name='to_world'>" KEY("soon", "0") "</animation>"), "soon", 3},
        {SCENE_OF("<animation name='to_world'><transform>" LOOK("0") "</transform></animation>"),
         "needs a time", 3},
        {SCENE_OF("<animation name='to_world'>" LOOK("0") "</animation>"), "can't stand within", 3},
        {SCENE_OF("<animation name='to_world'><transform time='0'><scale "
                  "value='2'/></transform></animation>"),
         "must not scale", 3},
        {SCENE_OF("<animation name='to_world'><transform time='0'><scale "
                  "x='-1'/></transform>" KEY("1", "0") "</animation>"),
         "mirrors", 3},
        {"<scene version='3.0.0'>\n<shape type='sphere'><animation name='to_world'>" KEY(
             "0", "1") "</animation></shape></scene>",
         "only a sensor", 2},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct fewray_scene *scene = NULL;
        struct fewray_error error;
        const int status = load_text(cases[i].text, "0", &scene, &error);
        if (status >= 0 || scene || !strstr(error.what, cases[i].what) ||
            error.line != cases[i].line)
            fail_msg("case %d: %d, line %d: %s", (int)i, status, error.line, error.what);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_positions_go_straight_and_rotations_evenly),
        cmocka_unit_test(test_rotations_take_the_shorter_way),
        cmocka_unit_test(test_scaled_and_sheared_poses_are_no_keys),
        cmocka_unit_test(test_an_animated_sensor_moves_with_the_time),
        cmocka_unit_test(test_a_still_sensor_stays),
        cmocka_unit_test(test_the_number_of_the_frame_is_a_define),
        cmocka_unit_test(test_wrong_animations_are_refused),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
