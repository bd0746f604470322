/* SPDX-License-Identifier: Apache-2.0 */
/* The guide of another renderer: how its look is drawn, what it may look like, what it weighs, and
 * what later samples teach. */

#include "tests/unit/guiding_host.h"

#include "fewray/guide.h"
#include "guide/host/host.h"

static void test_look_directions_are_uniform_over_the_hemisphere(void **state) {
    (void)state;
    enum { SIDE = 32, CELLS = 8, NONE = 5 };
    static float normals[SIDE * SIDE][3], directions[SIDE * SIDE][3];
    double seen[2][CELLS] = {{0}}, expected[CELLS];
    const float n[3] = {0.6f, 0, -0.8f};
    for (int i = 0; i < SIDE * SIDE; i++)
        memcpy(normals[i], n, sizeof n);
    memset(normals[NONE], 0, sizeof n);
    fewray_guide_look_directions(9, SIDE, SIDE, 1, 2, normals[0], directions[0]);
    for (int k = 0; k < CELLS; k++)
        expected[k] = (double)(SIDE * SIDE - 1) / CELLS;
    for (int i = 0; i < SIDE * SIDE; i++) {
        float d[3];
        fewray_guide_look_direction(9, i % SIDE, i / SIDE, 0, normals[i], d);
        assert_memory_equal(d, directions[i], sizeof d);
        const struct vec3 v = host_load(d);
        if (i == NONE) {
            assert_true(dot(v, v) == 0);
            continue;
        }
        assert_near((double)dot(v, v), 1, 1e-5);
        const float cosine = dot(v, host_load(n)); /* uniform in [0, 1] */
        assert_true(cosine >= -1e-6f && cosine <= 1 + 1e-5f);
        const float turn = atan2f(v.y, dot(v, vec(0.8f, 0, 0.6f))) / (2 * PI_F) + 0.5f;
        seen[0][(int)fminf(fmaxf(cosine, 0) * CELLS, CELLS - 1)]++;
        seen[1][(int)fminf(fmaxf(turn, 0) * CELLS, CELLS - 1)]++;
    }
    for (int k = 0; k < 2; k++) {
        int degrees;
        const double statistic = chi_square(seen[k], expected, CELLS, &degrees);
        assert_true(statistic < chi_square_limit(degrees));
    }
}

/* The arrays that a host would hand in, had it seen what our renderer's look saw. */
static void take_records(struct host *h, const struct fewray_look *look) {
    for (int i = 0; i < RECORDS; i++) {
        const struct look_record *r = &look->records[i];
        const struct look_second *s = &look->seconds[i];
        put(h->position[i], r->position);
        put(h->normal[i], r->normal);
        h->depth[i] = r->depth;
        put(h->direction[i], r->direction);
        put(h->emitted[i], vec(r->emitted, r->emitted, r->emitted));
        put(h->reflected[i], vec(r->reflected, r->reflected, r->reflected));
        h->distance[i] = r->distance;
        put(h->second_normal[i], r->second_normal);
        put(h->direct[i], r->direct);
        h->albedo[i] = s->albedo;
        put(h->light[i], s->light);
        h->light_value[i] = s->light_sent ? s->light_value : -1;
        put(h->bounce[i], s->bounce);
        h->bounce_value[i] = s->bounce_value;
    }
    h->look.direct = h->direct[0];
}

/* What our renderer notes must be what a host may hand in: no record of it is refused. */
static void test_a_rendered_look_can_be_handed_in(void **state) {
    (void)state;
    struct fewray_scene *scene = NULL;
    struct fewray_world *world = NULL;
    struct fewray_film *film = NULL;
    struct fewray_look *look = NULL, *back = NULL;
    struct fewray_render_settings settings;
    struct fewray_render_stats counts = {0};
    struct fewray_error error = {.line = 0};
    fewray_render_settings_init(&settings);
    settings.width = WIDTH;
    settings.height = HEIGHT;
    int status = fewray_scene_load(EXAMPLES "/glossy-still-life.xml", NULL, &scene, &error);
    status = status ? status : fewray_world_create(scene, 2, &world, &error);
    status = status ? status : fewray_film_create(world, &settings, &film, &error);
    status = status ? status : fewray_trace_look(world, &settings, film, &look, &counts, &error);
    if (status)
        fail_msg("%s", error.what);
    struct host *h = make_host(true);
    take_records(h, look);
    struct fewray_guide_stats stats;
    if (host_look_create(&h->look, 2, &back, &stats, &error))
        fail_msg("%s", error.what);
    assert_int_equal(stats.dropped, 0);
    assert_true(stats.records > RECORDS / 4);
    for (int i = 0; i < RECORDS; i++) {
        assert_true(look->records[i].bin == back->records[i].bin || !(h->depth[i] > 0));
        assert_int_equal(look->seconds[i].albedo > 0, back->seconds[i].albedo > 0);
        assert_true(look->seconds[i].light_sent == back->seconds[i].light_sent ||
                    !(look->seconds[i].albedo > 0));
    }
    free(h);
    fewray_look_destroy(&back);
    fewray_look_destroy(&look);
    fewray_film_destroy(&film);
    fewray_world_destroy(&world);
    fewray_scene_destroy(&scene);
}

static void test_infinite_distances_are_misses(void **state) {
    (void)state;
    struct host *h = make_host(true), *infinite = make_host(true);
    for (int i = 0; i < RECORDS; i++) {
        if (!(h->distance[i] > 0))
            infinite->distance[i] = INFINITY;
        if (!(h->depth[i] > 0))
            infinite->depth[i] = INFINITY;
    }
    struct fewray_guide_stats stats[2];
    struct fewray_guide *guide = make_guide(h, 1, &stats[0]);
    struct fewray_guide *other = make_guide(infinite, 1, &stats[1]);
    assert_memory_equal(&stats[0], &stats[1], sizeof stats[0]);
    assert_int_equal(stats[1].dropped, 0);
    assert_int_equal(guide->maps->count, other->maps->count);
    assert_memory_equal(guide->maps->maps, other->maps->maps,
                        (size_t)guide->maps->count * sizeof(*guide->maps->maps));
    fewray_guide_destroy(&guide);
    fewray_guide_destroy(&other);
    free(h);
    free(infinite);
}

static void test_a_look_without_a_good_record_is_refused_with_the_reason(void **state) {
    (void)state;
    struct host *h = make_host(true);
    struct fewray_guide *guide = NULL;
    struct fewray_error error;
    for (int i = 0; i < RECORDS; i++)
        h->normal[i][0] = 1;
    assert_int_equal(fewray_guide_create(&h->look, NULL, &guide, NULL, &error),
                     FEWRAY_ERROR_ARGUMENT);
    assert_null(guide);
    assert_string_equal(error.what, "no record of the look can be used; pixel (8, 0), sample 0: "
                                    "normal isn't a unit vector");
    struct fewray_guide_options options;
    fewray_guide_options_init(&options);
    options.bounce_share = 2;
    assert_int_equal(fewray_guide_create(&h->look, &options, &guide, NULL, &error),
                     FEWRAY_ERROR_ARGUMENT);
    assert_non_null(strstr(error.what, "bounce_share is 2"));
    free(h);
}

static void test_unguided_points_draw_nothing(void **state) {
    (void)state;
    struct host *h = make_host(false);
    struct fewray_guide *guide = make_guide(h, 1, NULL);
    const float down[3] = {0, -1, 0}, none[3] = {0, 0, 0}, u[2] = {0.5f, 0.5f}, ones[2] = {1, 1};
    const struct fewray_guide_at at[3] = {
        fewray_guide_first(guide, 20, 20, h->position[20 * WIDTH + 20], down),
        fewray_guide_first(guide, 20, 20, h->position[20 * WIDTH + 20], none),
        fewray_guide_later(guide, h->position[0], h->normal[0], true)}; /* there are no probes */
    float d[3];
    for (int k = 0; k < 3; k++) {
        put(d, vec(1, 1, 1));
        assert_true(at[k].bsdf_fraction == 1);
        fewray_guide_sample(&at[k], u, d);
        assert_true(dot(host_load(d), host_load(d)) == 0);
        assert_true(fewray_guide_pdf(&at[k], h->normal[0]) == 0);
    }
    const struct fewray_guide_at good = first_at(guide, 20, 20);
    fewray_guide_sample(&good, ones, d); /* a random number that was rounded up */
    assert_near((double)dot(host_load(d), host_load(d)), 1, 1e-5);
    assert_true(fewray_guide_pdf(&good, d) > 0);
    fewray_guide_destroy(&guide);
    free(h);
}

static void test_the_looks_weight_falls_with_its_noise(void **state) {
    (void)state;
    static float share[RECORDS];
    struct host *h = make_host(false);
    struct fewray_guide *guide = make_guide(h, 1, NULL);
    fewray_guide_look_weights(guide, 3, share);
    for (int i = 0; i < RECORDS; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        assert_true(share[i] == fewray_guide_look_weight(guide, x, y, 3));
        assert_true(fewray_guide_look_weight(guide, x, y, 0) == 1);
        /* Of four equal samples the look's would have a quarter; the window is found by few. */
        assert_true(share[i] > 0 && share[i] <= 0.25f);
        assert_true(fewray_guide_look_weight(guide, x, y, 9) < share[i]);
    }
    fewray_guide_destroy(&guide);
    free(h);
}

/* A weight that depended on the samples it weighs would bias the picture. */
static void test_the_looks_weight_is_blind_to_the_pixels_own_look(void **state) {
    (void)state;
    struct host *h = make_host(false);
    struct fewray_guide *guide = make_guide(h, 1, NULL);
    const float before = fewray_guide_look_weight(guide, 20, 12, 3);
    fewray_guide_destroy(&guide);
    for (int y = 8; y < 16; y++) /* its block of 8 x 8 pixels */
        for (int x = 16; x < 24; x++)
            put(h->emitted[y * WIDTH + x], vec(x % 3 ? 0 : 90, 1, 1));
    guide = make_guide(h, 1, NULL);
    assert_true(fewray_guide_look_weight(guide, 20, 12, 3) == before);
    assert_true(fewray_guide_look_weight(guide, 36, 12, 3) != before);
    fewray_guide_destroy(&guide);
    free(h);
}

/* Samples that find light where the look had none draw the maps there. */
static void test_maps_learn_where_the_light_is(void **state) {
    (void)state;
    struct host *h = make_host(false);
    struct fewray_guide_options options;
    struct fewray_guide *guide = NULL, *fixed = make_guide(h, 1, NULL);
    struct fewray_error error;
    fewray_guide_options_init(&options);
    options.learns = true;
    assert_int_equal(fewray_guide_create(&h->look, &options, &guide, NULL, &error), FEWRAY_OK);
    float light[3], black[3] = {0, 0, 0}, bright[3] = {900, 900, 900};
    put(light, normalize(vec(-0.6f, 0.64f, -0.3f)));
    const int32_t pixel[2] = {20, 20};
    const struct fewray_guide_lesson lesson = {.count = 1,
                                               .pixel = pixel,
                                               .normal = h->normal[0],
                                               .direction = light,
                                               .emitted = black,
                                               .reflected = bright};
    struct fewray_guide_at at = first_at(guide, 20, 20);
    const float before = fewray_guide_pdf(&at, light);
    for (int k = 0; k < 50; k++)
        assert_int_equal(fewray_guide_learn(guide, &lesson, &error), FEWRAY_OK);
    at = first_at(guide, 20, 20);
    assert_true(fewray_guide_pdf(&at, light) == before); /* not before it is refined */
    bright[1] = NAN;
    assert_int_equal(fewray_guide_learn(guide, &lesson, &error), FEWRAY_OK); /* ignored */
    assert_int_equal(fewray_guide_refine(guide, &error), FEWRAY_OK);
    at = first_at(guide, 20, 20);
    assert_true(fewray_guide_pdf(&at, light) > 5 * before);
    struct fewray_guide_lesson lacking = lesson;
    lacking.emitted = NULL;
    assert_int_equal(fewray_guide_learn(guide, &lacking, &error), FEWRAY_ERROR_ARGUMENT);
    assert_int_equal(fewray_guide_learn(fixed, &lesson, &error), FEWRAY_ERROR_ARGUMENT);
    assert_non_null(strstr(error.what, "`learns`"));
    assert_int_equal(fewray_guide_refine(fixed, &error), FEWRAY_ERROR_ARGUMENT);
    fewray_guide_destroy(&guide);
    fewray_guide_destroy(&fixed);
    free(h);
}

/* A pass over the picture: a sample of each pixel, drawn by its map. */
static void teach(struct fewray_guide *guide, const struct host *h, uint32_t pass) {
    static int32_t pixel[RECORDS][2];
    static float direction[RECORDS][3], emitted[RECORDS][3], black[RECORDS][3];
    for (int i = 0; i < RECORDS; i++) {
        const struct fewray_guide_at at = first_at(guide, i % WIDTH, i / WIDTH);
        const uint32_t k = (uint32_t)i + RECORDS * pass;
        pixel[i][0] = i % WIDTH;
        pixel[i][1] = i / WIDTH;
        fewray_guide_sample(&at, (float[2]){random_float(k, 1), random_float(k, 2)}, direction[i]);
        const float light = sky(host_load(direction[i]));
        put(emitted[i], vec(light, light, light));
    }
    const struct fewray_guide_lesson lesson = {.count = RECORDS,
                                               .pixel = pixel[0],
                                               .normal = h->normal[0],
                                               .direction = direction[0],
                                               .emitted = emitted[0],
                                               .reflected = black[0]};
    assert_int_equal(fewray_guide_learn(guide, &lesson, NULL), FEWRAY_OK);
}

static void test_a_taught_guide_is_unbiased_and_less_noisy(void **state) {
    (void)state;
    enum { SAMPLES = 20000, PASSES = 16, X = 30, Y = 13 };
    struct host *h = make_host(false);
    struct fewray_guide_options options;
    struct fewray_guide *guide = NULL;
    fewray_guide_options_init(&options);
    options.learns = true;
    assert_int_equal(fewray_guide_create(&h->look, &options, &guide, NULL, NULL), FEWRAY_OK);
    double mean, before, after;
    struct fewray_guide_at at = first_at(guide, X, Y);
    estimate(&at, SAMPLES, &mean, &before);
    for (uint32_t pass = 0; pass < PASSES; pass++)
        teach(guide, h, pass);
    assert_int_equal(fewray_guide_refine(guide, NULL), FEWRAY_OK);
    at = first_at(guide, X, Y);
    estimate(&at, SAMPLES, &mean, &after);
    assert_near(mean, exact_estimate(), 3 * sqrt(after / SAMPLES));
    assert_true(after < 0.8 * before);
    fewray_guide_destroy(&guide);
    free(h);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_look_directions_are_uniform_over_the_hemisphere),
        cmocka_unit_test(test_a_rendered_look_can_be_handed_in),
        cmocka_unit_test(test_infinite_distances_are_misses),
        cmocka_unit_test(test_a_look_without_a_good_record_is_refused_with_the_reason),
        cmocka_unit_test(test_unguided_points_draw_nothing),
        cmocka_unit_test(test_the_looks_weight_falls_with_its_noise),
        cmocka_unit_test(test_the_looks_weight_is_blind_to_the_pixels_own_look),
        cmocka_unit_test(test_maps_learn_where_the_light_is),
        cmocka_unit_test(test_a_taught_guide_is_unbiased_and_less_noisy),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
