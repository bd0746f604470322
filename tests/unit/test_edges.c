/* SPDX-License-Identifier: Apache-2.0 */
/* Camera rays of their own at edges: which pixels get them, and that they change no mean. */

#include "tests/unit/check.h"

#include "guide/trace/film.h"

struct stage {
    struct fewray_scene *scene;
    struct fewray_world *world;
    struct fewray_film *film;
};

static struct stage open_stage(const struct fewray_render_settings *settings) {
    struct stage s = {NULL, NULL, NULL};
    struct fewray_error error = {.line = 0};
    int status = fewray_scene_load(EXAMPLES "/cornell-box.xml", NULL, &s.scene, &error);
    status = status ? status : fewray_world_create(s.scene, 1, &s.world, &error);
    status = status ? status : fewray_film_create(s.world, settings, &s.film, &error);
    if (status)
        fail_msg("%s", error.what);
    return s;
}

static void close_stage(struct stage *s) {
    fewray_film_destroy(&s->film);
    fewray_world_destroy(&s->world);
    fewray_scene_destroy(&s->scene);
}

static struct fewray_render_settings settings_of(int width, int height) {
    struct fewray_render_settings settings;
    fewray_render_settings_init(&settings);
    settings.width = width;
    settings.height = height;
    settings.spp = 2;
    settings.threads = 1;
    return settings;
}

/* Samples that saw this emission. */
static void fill(struct fewray_film *film, int x, int y, float emission) {
    struct pixel_group *g = &film->group[GROUP_REST][(size_t)y * (size_t)film->width + (size_t)x];
    g->count = 2;
    g->depth = 1;
    for (int c = 0; c < 3; c++)
        g->emission[c] = emission;
}

/* A pixel's own samples mustn't decide whether they are replaced: not at the border either. */
static void test_a_pixel_is_no_neighbour_of_its_own(void **state) {
    (void)state;
    const struct fewray_render_settings settings = settings_of(2, 1);
    struct fewray_render_stats stats = {0};
    struct fewray_error error;
    struct stage s = open_stage(&settings);
    fill(s.film, 0, 0, 0);
    fill(s.film, 1, 0, 5);
    assert_int_equal(fewray_trace_edges(s.world, &settings, s.film, &stats, &error), FEWRAY_OK);
    assert_int_equal(stats.edge_pixels, 0);
    close_stage(&s);
}

static void test_the_pixel_beside_an_edge_is_refined(void **state) {
    (void)state;
    const struct fewray_render_settings settings = settings_of(3, 1);
    struct fewray_render_stats stats = {0};
    struct fewray_error error;
    struct stage s = open_stage(&settings);
    for (int x = 0; x < 3; x++)
        fill(s.film, x, 0, x == 2 ? 5 : 0);
    assert_int_equal(fewray_trace_edges(s.world, &settings, s.film, &stats, &error), FEWRAY_OK);
    assert_int_equal(stats.edge_pixels, 1);
    assert_true(s.film->edges[1].rays > 0);
    close_stage(&s);
}

static double mean_color(struct stage *s, const struct fewray_render_settings *settings) {
    struct fewray_render_stats stats = {0};
    struct fewray_frame *frame = NULL;
    struct fewray_error error;
    fewray_film_destroy(&s->film);
    assert_int_equal(fewray_film_create(s->world, settings, &s->film, &error), FEWRAY_OK);
    assert_int_equal(fewray_trace_rest(s->world, NULL, settings, s->film, &stats, &error), 0);
    assert_int_equal(fewray_trace_edges(s->world, settings, s->film, &stats, &error), 0);
    assert_int_equal(fewray_film_frame(s->film, NULL, &frame, &error), FEWRAY_OK);
    const float *g = fewray_frame_plane(frame, "G");
    double sum = 0;
    int pixels = frame->width * frame->height;
    for (int i = 0; i < pixels; i++)
        sum += g[i];
    fewray_frame_destroy(&frame);
    return sum / pixels;
}

static void test_camera_rays_keep_the_mean(void **state) {
    (void)state;
    enum { SEEDS = 200 };
    struct fewray_render_settings settings = settings_of(16, 16);
    struct stage s = open_stage(&settings);
    double sum = 0, squares = 0;
    for (int k = 0; k < SEEDS; k++) {
        settings.seed = (uint64_t)k;
        settings.camera_rays = 0;
        double without = mean_color(&s, &settings);
        settings.camera_rays = 32;
        double difference = mean_color(&s, &settings) - without;
        sum += difference;
        squares += difference * difference;
    }
    double mean = sum / SEEDS;
    double error = sqrt((squares / SEEDS - mean * mean) / (SEEDS - 1));
    assert_true(error > 0);
    assert_true(fabs(mean) < 4 * error);
    close_stage(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_pixel_is_no_neighbour_of_its_own),
        cmocka_unit_test(test_the_pixel_beside_an_edge_is_refined),
        cmocka_unit_test(test_camera_rays_keep_the_mean),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
