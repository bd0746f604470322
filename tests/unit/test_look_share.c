/* SPDX-License-Identifier: Apache-2.0 */
/* The first look as a part of the picture: its weight, its place among a pixel's samples, and how
 * far the irradiance made of it can be trusted. */

#include "tests/unit/check.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "fewray/guide.h"

struct stage {
    struct fewray_scene *scene;
    struct fewray_world *world;
};

static void stage_open(struct stage *s, const char *path) {
    struct fewray_error error = {.line = 0};
    *s = (struct stage){NULL, NULL};
    int status = fewray_scene_load(path, NULL, &s->scene, &error);
    status = status ? status : fewray_world_create(s->scene, 2, &s->world, &error);
    if (status)
        fail_msg("%s: %s:%d: %s", path, error.file, error.line, error.what);
}

static void stage_close(struct stage *s) {
    fewray_world_destroy(&s->world);
    fewray_scene_destroy(&s->scene);
}

/* initial 0: unguided. The frame is the caller's. */
static struct fewray_frame *render(const struct stage *stage,
                                   const struct fewray_render_settings *s) {
    struct fewray_film *film = NULL;
    struct fewray_look *look = NULL;
    struct fewray_maps *maps = NULL;
    struct fewray_frame *frame = NULL;
    struct fewray_render_stats stats = {0};
    struct fewray_error error;
    int status = fewray_film_create(stage->world, s, &film, &error);
    if (s->initial > 0) {
        status = status ? status : fewray_trace_look(stage->world, s, film, &look, &stats, &error);
        status = status ? status : fewray_maps_create(look, s, &maps, &stats, &error);
    }
    status = status ? status : fewray_trace_rest(stage->world, maps, s, film, &stats, &error);
    status = status ? status : fewray_film_frame(film, maps, &frame, &error);
    assert_int_equal(status, FEWRAY_OK);
    assert_int_equal(stats.paths, (long long)s->width * s->height * s->spp);
    fewray_maps_destroy(&maps);
    fewray_look_destroy(&look);
    fewray_film_destroy(&film);
    return frame;
}

static struct fewray_render_settings small(int width, int height, int initial, int spp) {
    struct fewray_render_settings s;
    fewray_render_settings_init(&s);
    s.width = width;
    s.height = height;
    s.initial = initial;
    s.spp = spp;
    s.threads = 2;
    return s;
}

static double plane_mean(const struct fewray_frame *frame, const char *name) {
    const float *p = fewray_frame_plane(frame, name);
    assert_non_null(p);
    int n = frame->width * frame->height;
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += p[i];
    return sum / n;
}

/* Mean of green over `seeds` pictures, and its standard error. */
static double mean_of_seeds(const struct stage *stage, struct fewray_render_settings s, int seeds,
                            double *error) {
    double sum = 0, squares = 0;
    for (int k = 0; k < seeds; k++) {
        s.seed = 1000 + (uint64_t)k;
        struct fewray_frame *frame = render(stage, &s);
        double m = plane_mean(frame, "G");
        sum += m;
        squares += m * m;
        fewray_frame_destroy(&frame);
    }
    double mean = sum / seeds;
    *error = sqrt(fmax(0, squares / seeds - mean * mean) / (seeds - 1));
    return mean;
}

/* One sample of the look and one guided one, weighted by what the maps around expect: a weight that
 * followed the samples themselves would darken the picture. */
static void expect_unguided_mean(const char *path, int seeds, double most_error) {
    struct stage stage;
    stage_open(&stage, path);
    double plain_error, guided_error;
    double plain = mean_of_seeds(&stage, small(40, 32, 0, 8), seeds / 3, &plain_error);
    double guided = mean_of_seeds(&stage, small(40, 32, 1, 2), seeds, &guided_error);
    double error = sqrt(plain_error * plain_error + guided_error * guided_error);
    assert_near(guided, plain, 4 * error);
    assert_true(error < most_error * plain);
    stage_close(&stage);
}

static void test_automatic_look_weight_keeps_the_mean(void **state) {
    (void)state;
    expect_unguided_mean(EXAMPLES "/door-ajar.xml", 60, 0.02);
    expect_unguided_mean(EXAMPLES "/cornell-box.xml", 60, 0.01);
}

/* A screen before one quarter of the only pixel. */
static const char quarter[] =
    "<scene version='3.0.0'><integrator type='path'/><sensor type='perspective'><float name='fov' "
    "value='40'/><transform name='to_world'><lookat origin='0,0,4' target='0,0,0' up='0,1,0'/>"
    "</transform><film type='hdrfilm'><integer name='width' value='1'/><integer name='height' "
    "value='1'/><rfilter type='box'/></film></sensor><shape type='rectangle'><transform "
    "name='to_world'><scale value='9'/><translate x='%d' y='%d'/></transform><bsdf type='diffuse'/>"
    "</shape></scene>";

static void stage_open_quarter(struct stage *stage, int x, int y) {
    char path[] = "/tmp/fewray-quarter-XXXXXX", text[1024];
    int size = snprintf(text, sizeof(text), quarter, x, y);
    int fd = mkstemp(path);
    assert_true(size < (int)sizeof(text) && fd >= 0);
    assert_int_equal(write(fd, text, (size_t)size), size);
    close(fd);
    stage_open(stage, path);
    unlink(path);
}

/* A sample of the look and three others pass each quarter of the pixel once. */
static void test_look_and_rest_share_the_pixels_strata(void **state) {
    (void)state;
    for (int q = 0; q < 4; q++) {
        struct stage stage;
        stage_open_quarter(&stage, q % 2 ? 9 : -9, q / 2 ? 9 : -9);
        for (uint64_t seed = 0; seed < 8; seed++)
            for (int initial = 0; initial < 4; initial++) {
                struct fewray_render_settings s = small(1, 1, initial, 4);
                s.seed = seed;
                s.look_weight = 1; /* all samples count alike */
                struct fewray_frame *frame = render(&stage, &s);
                assert_near(fewray_frame_plane(frame, "A")[0], 0.25, 1e-6);
                fewray_frame_destroy(&frame);
            }
        stage_close(&stage);
    }
}

/* grows: with one sample a pixel much is left to learn; else all is known well. */
static void check_confidence(const char *path, bool grows) {
    struct stage stage;
    stage_open(&stage, path);
    double before = 0;
    for (int initial = 0; initial <= 4; initial += initial ? 3 : 1) {
        struct fewray_render_settings s = small(64, 48, initial, initial);
        s.spp += !initial;
        struct fewray_frame *frame = render(&stage, &s);
        const float *confidence = fewray_frame_plane(frame, "irradiance.confidence");
        const float *red = fewray_frame_plane(frame, "irradiance.R");
        assert_true((confidence != NULL) == (initial > 0) && (red != NULL) == (initial > 0));
        for (int i = 0; i < s.width * s.height && initial; i++) {
            assert_true(confidence[i] >= 0 && confidence[i] <= 1);
            assert_true(confidence[i] > 0 || red[i] == 0);
        }
        if (initial) {
            double mean = plane_mean(frame, "irradiance.confidence");
            assert_true(mean > (grows ? before : 0));
            before = mean;
        }
        fewray_frame_destroy(&frame);
    }
    assert_true(grows || before > 0.6);
    stage_close(&stage);
}

static void test_irradiance_has_a_confidence_that_grows(void **state) {
    (void)state;
    check_confidence(EXAMPLES "/door-ajar.xml", true);
    check_confidence(EXAMPLES "/window-room.xml", true);
    check_confidence(EXAMPLES "/cornell-box.xml", false);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_automatic_look_weight_keeps_the_mean),
        cmocka_unit_test(test_look_and_rest_share_the_pixels_strata),
        cmocka_unit_test(test_irradiance_has_a_confidence_that_grows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
