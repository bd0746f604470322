/* SPDX-License-Identifier: Apache-2.0 */
/* The pilot: which scenes it wants a guide for. */

#include "tests/unit/check.h"

#include <string.h>
#include <unistd.h>

#include "fewray/guide.h"

static void trace(const char *path, int threads, uint64_t seed, struct fewray_pilot *pilot) {
    struct fewray_scene *scene = NULL;
    struct fewray_world *world = NULL;
    struct fewray_film *film = NULL;
    struct fewray_error error = {.line = 0};
    struct fewray_render_stats stats = {0};
    struct fewray_render_settings settings;
    fewray_render_settings_init(&settings);
    settings.width = 320;
    settings.height = 240;
    settings.threads = threads;
    settings.seed = seed;
    memset(pilot, 0xff, sizeof(*pilot));
    int status = fewray_scene_load(path, NULL, &scene, &error);
    status = status ? status : fewray_world_create(scene, threads, &world, &error);
    status = status ? status : fewray_film_create(world, &settings, &film, &error);
    status = status ? status : fewray_trace_pilot(world, &settings, film, pilot, &stats, &error);
    if (status)
        fail_msg("%s: %s:%d: %s", path, error.file, error.line, error.what);
    /* Two paths at about one of 144 pixels: it mustn't cost what a sample of the picture does. */
    assert_true(stats.rays > 0);
    assert_int_equal(stats.paths, 0);
    struct fewray_frame *frame = NULL;
    assert_int_equal(fewray_film_frame(film, NULL, &frame, &error), FEWRAY_OK);
    const float *green = fewray_frame_plane(frame, "G");
    for (int i = 0; i < 320 * 240; i++)
        assert_true(green[i] == 0); /* its paths don't count for the picture */
    fewray_frame_destroy(&frame);
    fewray_film_destroy(&film);
    fewray_world_destroy(&world);
    fewray_scene_destroy(&scene);
}

#define GREY(value) "<bsdf type='diffuse'><rgb name='reflectance' value='" value "'/></bsdf>"
#define CAMERA                                                                                     \
    "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' "                    \
    "value='-1'/></integrator><sensor type='perspective'><float name='fov' value='40'/>"           \
    "<transform name='to_world'><lookat origin='0,2,8' target='0,0.8,0' up='0,1,0'/></transform>"  \
    "<film type='hdrfilm'><integer name='width' value='64'/><integer name='height' value='48'/>"   \
    "<rfilter type='box'/></film></sensor>"
#define GROUND_AND_SPHERES                                                                         \
    "<shape type='rectangle'><transform name='to_world'><scale value='30'/><rotate x='1' "         \
    "angle='-90'/></transform>" GREY(                                                              \
        "0.5,0.5,0.5") "</shape>"                                                                  \
                       "<shape type='sphere'><point name='center' x='-1.2' y='1' z='0'/>" GREY(    \
                           "0.7,0.3,0.3") "</shape><shape type='sphere'><point name='center' "     \
                                          "x='1.2' y='1' z='0'/>" GREY("0.3,0.3,0.7") "</shape>"

static const char open_scene[] = CAMERA GROUND_AND_SPHERES
    "<emitter type='constant'><rgb name='radiance' value='1,1,1'/></emitter></scene>";
static const char dark_scene[] = CAMERA GROUND_AND_SPHERES "</scene>";

static void trace_text(const char *text, int threads, struct fewray_pilot *pilot) {
    char path[] = "/tmp/fewray-pilot-XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, text, strlen(text)), strlen(text));
    close(fd);
    trace(path, threads, 1, pilot);
    unlink(path);
}

static void test_rooms_want_the_guide(void **state) {
    (void)state;
    const char *rooms[] = {EXAMPLES "/door-ajar.xml", EXAMPLES "/window-room.xml"};
    for (int i = 0; i < 2; i++)
        for (uint64_t seed = 1; seed < 3; seed++) {
            struct fewray_pilot pilot;
            trace(rooms[i], 2, seed, &pilot);
            assert_false(pilot.dark);
            assert_true(isfinite(pilot.variance) && isfinite(pilot.bounce_variance));
            assert_true(fewray_pilot_wants_guide(&pilot));
        }
}

static void test_open_scenes_do_without(void **state) {
    (void)state;
    struct fewray_pilot pilot;
    trace_text(open_scene, 2, &pilot);
    assert_false(pilot.dark);
    assert_true(pilot.variance > 0 && pilot.bounce_variance > 0);
    assert_true(pilot.bounce_variance < 0.35f);
    assert_false(fewray_pilot_wants_guide(&pilot));
}

/* Where the pilot found no light, the look may. */
static void test_scenes_without_light_are_dark(void **state) {
    (void)state;
    struct fewray_pilot pilot;
    trace_text(dark_scene, 2, &pilot);
    assert_true(pilot.dark);
    assert_near(pilot.variance, 0, 0);
    assert_near(pilot.bounce_variance, 0, 0);
    assert_true(fewray_pilot_wants_guide(&pilot));
}

static void test_same_bits_on_any_number_of_threads(void **state) {
    (void)state;
    struct fewray_pilot one, three, other;
    trace(EXAMPLES "/door-ajar.xml", 1, 7, &one);
    trace(EXAMPLES "/door-ajar.xml", 3, 7, &three);
    trace(EXAMPLES "/door-ajar.xml", 3, 8, &other);
    assert_memory_equal(&one.variance, &three.variance, sizeof(float));
    assert_memory_equal(&one.bounce_variance, &three.bounce_variance, sizeof(float));
    assert_true(one.dark == three.dark);
    assert_true(other.variance != one.variance); /* the seed counts */
}

static void test_the_rule(void **state) {
    (void)state;
    const struct {
        struct fewray_pilot pilot;
        bool wants;
    } cases[] = {
        {{0, 0, true, false, 0, 0, 0}, true},   /* nothing is known */
        {{0, 0, false, false, 0, 0, 0}, false}, /* no noise at all */
        {{2, 2, false, false, 0, 0, 0}, true},  /* all noise comes by the bounce */
        {{2, 2, false, true, 0, 0, 0}, false},  /* but the picture is tiny */
        {{0, 0, true, true, 0, 0, 0}, false},
        {{1.05f, 1.05f, false, false, 0, 0, 0}, true},
        {{0.95f, 0.95f, false, false, 0, 0, 0}, false}, /* too little of it */
        {{10, 2.6f, false, false, 0, 0, 0}, true},
        {{10, 2.4f, false, false, 0, 0, 0}, false},    /* too small a part of all */
        {{1.3f, 0.95f, false, false, 0, 0, 0}, false}, /* enough of all, but little */
        {{NAN, NAN, false, false, 0, 0, 0}, false},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++)
        assert_true(fewray_pilot_wants_guide(&cases[i].pilot) == cases[i].wants);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rooms_want_the_guide),
        cmocka_unit_test(test_open_scenes_do_without),
        cmocka_unit_test(test_scenes_without_light_are_dark),
        cmocka_unit_test(test_same_bits_on_any_number_of_threads),
        cmocka_unit_test(test_the_rule),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
