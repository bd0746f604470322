/* SPDX-License-Identifier: Apache-2.0 */
/* The guide of another renderer: what it makes of a look, and its densities. */

#include "tests/unit/guiding_host.h"

/* The sphere by Sobol points: equal areas. */
static struct vec3 sphere_point(int k, int count) {
    float u[2];
    sobol_point((uint32_t)k, 1, u);
    const float y = 1 - 2 * ((float)k + 0.5f) / (float)count, phi = 2 * PI_F * u[1];
    const float r = sqrtf(fmaxf(0, 1 - y * y));
    return vec(r * cosf(phi), y, r * sinf(phi));
}

static void assert_density(const struct fewray_guide_at *at) {
    enum { POINTS = 16384 };
    double sum = 0;
    for (int k = 0; k < POINTS; k++) {
        float d[3];
        put(d, sphere_point(k, POINTS));
        const float pdf = fewray_guide_pdf(at, d);
        assert_true(pdf >= 0);
        sum += pdf * 4 * (double)PI_F / POINTS;
    }
    /* A step function of 1024 bins of equal area by 16 points each, of which a bin gets one more or
     * less: a few per cent of the brightest bins. */
    assert_near(sum, 1, 0.05);
    for (uint32_t k = 0; k < 64; k++) {
        float d[3];
        const float u[2] = {random_float(k, 1), random_float(k, 2)};
        fewray_guide_sample(at, u, d);
        assert_near((double)(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), 1, 1e-5);
        assert_true(fewray_guide_pdf(at, d) > 0);
    }
}

static void test_densities_integrate_to_one(void **state) {
    (void)state;
    struct host *h = make_host(true);
    struct fewray_guide_stats stats;
    struct fewray_guide *guide = make_guide(h, 2, &stats);
    assert_int_equal(stats.records, RECORDS - BARE * HEIGHT);
    assert_int_equal(stats.dropped, 0);
    assert_true(stats.maps > 0 && stats.probes > 0);
    for (int x = BARE + 4; x < WIDTH; x += 9) {
        const struct fewray_guide_at at = first_at(guide, x, x % HEIGHT);
        assert_true(at.bsdf_fraction >= 0 && at.bsdf_fraction < 1);
        assert_density(&at);
    }
    const float wall[3] = {2.4f, 2.5f, 5}, out[3] = {0, 0, -1};
    int found = 0;
    for (int k = 0; k < 40; k++) {
        const float p[3] = {wall[0] + 0.05f * (float)k, wall[1], h->position[0][2] + wall[2]};
        const struct fewray_guide_at at = fewray_guide_later(guide, p, out, false);
        assert_true(at.bsdf_fraction >= 0.5f && at.light_chance > 0 && at.light_chance <= 1);
        if (at.bsdf_fraction < 1)
            assert_density(&at);
        found += at.bsdf_fraction < 1;
    }
    assert_true(found > 0);
    fewray_guide_destroy(&guide);
    assert_null(guide);
    free(h);
}

static void test_guided_mean_is_the_integral_with_less_noise(void **state) {
    (void)state;
    enum { SAMPLES = 20000 };
    struct host *h = make_host(false);
    struct fewray_guide *guide = make_guide(h, 0, NULL);
    const struct fewray_guide_at nothing = {.bsdf_fraction = 1, .light_chance = 1};
    double plain, plain_variance;
    estimate(&nothing, SAMPLES, &plain, &plain_variance);
    const double exact = exact_estimate();
    for (int x = BARE + 2; x < WIDTH; x += 7) {
        const struct fewray_guide_at at = first_at(guide, x, 13);
        double mean, variance;
        estimate(&at, SAMPLES, &mean, &variance);
        assert_true(at.bsdf_fraction < 1);
        /* Four standard errors: chance 6e-5 a point, with fixed random numbers. */
        assert_near(mean, exact, 4 * sqrt(variance / SAMPLES));
        /* The window is 1/25 of the cosine's samples: a good map gains ten times, any that works
         * three. */
        assert_true(3 * variance < plain_variance);
    }
    fewray_guide_destroy(&guide);
    free(h);
}

static void test_many_at_once_equal_one_by_one_on_any_threads(void **state) {
    (void)state;
    enum { COUNT = 500 };
    static float position[COUNT][3], normal[COUNT][3], u[COUNT][2], direction[2][COUNT][3],
        pdf[3][COUNT], fraction[2][COUNT];
    static int32_t pixel[COUNT][2];
    struct host *h = make_host(true);
    struct fewray_guide *guides[2] = {make_guide(h, 1, NULL), make_guide(h, 3, NULL)};
    for (uint32_t i = 0; i < COUNT; i++) {
        pixel[i][0] = (int32_t)(random_float(i, 1) * (WIDTH + 8)) - 4; /* beyond the edges, too */
        pixel[i][1] = (int32_t)(random_float(i, 2) * (HEIGHT + 8)) - 4;
        put(position[i], vec(5 * random_float(i, 3), 0, 3 * random_float(i, 4)));
        put(normal[i], vec(0, 1, 0));
        u[i][0] = random_float(i, 5);
        u[i][1] = random_float(i, 6);
    }
    for (int later = 0; later < 2; later++) {
        for (uint32_t i = 0; later && i < COUNT; i++) { /* on the wall */
            put(position[i], vec(5 * random_float(i, 3), 2 * random_float(i, 7), 6.5f));
            put(normal[i], vec(0, 0, -1));
        }
        const struct fewray_guide_points points = {COUNT, later ? NULL : pixel[0], position[0],
                                                   normal[0], .last = true};
        for (int g = 0; g < 2; g++)
            fewray_guide_sample_many(guides[g], &points, u[0], direction[g][0], pdf[g],
                                     fraction[g]);
        fewray_guide_pdf_many(guides[0], &points, direction[0][0], pdf[2], NULL);
        assert_memory_equal(direction[0], direction[1], sizeof direction[0]);
        assert_memory_equal(pdf[0], pdf[1], sizeof pdf[0]);
        assert_memory_equal(pdf[0], pdf[2], sizeof pdf[0]);
        assert_memory_equal(fraction[0], fraction[1], sizeof fraction[0]);
        int guided = 0;
        for (int i = 0; i < COUNT; i++) {
            const struct fewray_guide_at at =
                later ? fewray_guide_later(guides[0], position[i], normal[i], true)
                      : fewray_guide_first(guides[0], pixel[i][0], pixel[i][1], position[i],
                                           normal[i]);
            float one[3] = {0, 0, 0};
            assert_true(at.bsdf_fraction == fraction[0][i]);
            if (at.bsdf_fraction < 1)
                fewray_guide_sample(&at, u[i], one);
            assert_memory_equal(one, direction[0][i], sizeof one);
            assert_true(pdf[0][i] == (at.bsdf_fraction < 1 ? fewray_guide_pdf(&at, one) : 0));
            guided += at.bsdf_fraction < 1;
        }
        assert_true(guided > COUNT / 4);
    }
    fewray_guide_destroy(&guides[0]);
    fewray_guide_destroy(&guides[1]);
    free(h);
}

/* The same records, as our own renderer has them. */
static void test_maps_are_those_of_our_own_renderer(void **state) {
    (void)state;
    struct host *h = make_host(false);
    for (int i = 0; i < RECORDS; i++)
        h->light_pdf[i] = 0.3f;
    h->look.light_pdf = h->light_pdf;
    struct fewray_guide *guide = make_guide(h, 0, NULL);
    static struct look_record records[RECORDS];
    struct fewray_look look = {WIDTH, HEIGHT, 1, records, NULL};
    assert_true(FEWRAY_LOOK_PDF == LOOK_PDF);
    const float weight = FEWRAY_LOOK_PDF * FEWRAY_LOOK_PDF /
                         (FEWRAY_LOOK_PDF * FEWRAY_LOOK_PDF + 0.3f * 0.3f); /* power heuristic */
    for (int i = 0; i < RECORDS; i++) {
        const struct vec3 d = vec(h->direction[i][0], h->direction[i][1], h->direction[i][2]);
        records[i] = (struct look_record){.position = floor_point(i),
                                          .normal = vec(0, 1, 0),
                                          .depth = h->depth[i],
                                          .direction = d,
                                          .bin = (uint16_t)sphere_bin(d),
                                          .radiance = vec(1, 1, 1),
                                          .emitted = h->emitted[i][0] * weight,
                                          .reflected = h->reflected[i][0],
                                          .distance = h->distance[i],
                                          .second_normal =
                                              h->distance[i] > 0 ? vec(0, 0, -1) : vec(0, 0, 0)};
    }
    struct fewray_render_settings settings;
    struct fewray_render_stats stats = {0};
    struct fewray_maps *maps = NULL;
    struct fewray_error error;
    fewray_render_settings_init(&settings);
    settings.probes = settings.refine = false;
    assert_int_equal(fewray_maps_create(&look, &settings, &maps, &stats, &error), FEWRAY_OK);
    for (int i = 0; i < RECORDS; i += 5) {
        const int x = i % WIDTH, y = i / WIDTH;
        const struct fewray_guide_at at = first_at(guide, x, y);
        const struct map_mixture own = maps_at(maps, x, y, floor_point(i), vec(0, 1, 0));
        assert_near((double)at.bsdf_fraction, own.count ? (double)own.bsdf_fraction : 1, 1e-4);
        for (int k = 0; own.count && k < 8; k++) {
            float d[3];
            const struct vec3 direction = sphere_point(8 * i + k, 8 * RECORDS);
            put(d, direction);
            /* Rounding of a unit vector that is normalised once more. */
            const double pdf = (double)map_mixture_pdf(&own, direction);
            assert_near((double)fewray_guide_pdf(&at, d), pdf, 1e-3 * (pdf + 0.01));
        }
    }
    fewray_maps_destroy(&maps);
    fewray_guide_destroy(&guide);
    free(h);
}

static void test_irradiance_is_that_of_the_sky(void **state) {
    (void)state;
    struct host *h = make_host(false);
    for (int i = 0; i < RECORDS; i++)
        put(h->direct[i], vec(0.5f, 0.5f, 0.5f));
    h->look.direct = h->direct[0];
    struct fewray_guide *guide = make_guide(h, 0, NULL);
    double mean = 0;
    for (int y = 0; y < HEIGHT; y++) {
        const int32_t pixel[2] = {30, y};
        const float up[3] = {0, 1, 0};
        float irradiance[3], confidence;
        const struct fewray_guide_points points = {1, pixel, NULL, up, false};
        fewray_guide_irradiance_many(guide, &points, irradiance, &confidence);
        assert_true(confidence > 0 && confidence <= 1);
        mean += (double)irradiance[0] / HEIGHT;
    }
    /* The look's own mean over all pixels, which the maps' windows cover about evenly. */
    double expected = 0;
    int count = 0;
    for (int i = 0; i < RECORDS; i++) {
        if (!(h->depth[i] > 0))
            continue;
        expected +=
            0.5 + 2 * (double)((h->emitted[i][0] + h->reflected[i][0]) * h->direction[i][1]);
        count++;
    }
    expected /= count;
    assert_near(mean, expected,
                0.25 * expected); /* windows of 576 records: 1 in 36 sees the window */
    fewray_guide_destroy(&guide);
    free(h);
}

static void test_bad_records_are_left_out_and_counted(void **state) {
    (void)state;
    struct host *h = make_host(true);
    const int first = 3 * WIDTH + BARE; /* with a depth, all of them */
    h->emitted[first][1] = NAN;
    h->reflected[first + 1][0] = INFINITY;
    h->reflected[first + 2][2] = -1;
    put(h->direction[first + 3], vec(0, 2, 0));
    put(h->normal[first + 4], vec(0, 0, 0));
    h->position[first + 5][0] = NAN;
    h->depth[first + 6] = -1;
    h->distance[first + 7] = NAN;
    put(h->direction[first + 9], vec(0.6f, -0.8f, 0)); /* below the floor */
    h->light_value[first + 8] = NAN; /* of the second vertex alone: the record stays */
    struct fewray_guide_stats stats;
    struct fewray_guide *guide = make_guide(h, 0, &stats);
    assert_int_equal(stats.dropped, 9);
    assert_int_equal(stats.records, RECORDS - BARE * HEIGHT - 9);
    const struct fewray_guide_at at = first_at(guide, BARE + 4, 4);
    assert_density(&at);
    fewray_guide_destroy(&guide);

    for (int i = 0; i < RECORDS; i++)
        h->depth[i] = 0;
    guide = make_guide(h, 0, &stats);
    assert_int_equal(stats.records + stats.dropped, 0);
    const struct fewray_guide_at nothing = first_at(guide, 20, 20);
    assert_true(nothing.bsdf_fraction == 1);
    fewray_guide_destroy(&guide);
    free(h);
}

static void test_wrong_arguments_are_refused_with_a_line(void **state) {
    (void)state;
    struct host *h = make_host(true);
    struct fewray_guide_options options, wrong[3];
    fewray_guide_options_init(&options);
    for (int k = 0; k < 3; k++)
        wrong[k] = options;
    wrong[0].bsdf_fraction = NAN;
    wrong[1].map_bins = 24;
    wrong[2].weights_path = "there is no such file";
    const char *const says[3] = {"bsdf_fraction", "map_bins", "no such file"};
    struct fewray_guide *guide = NULL;
    struct fewray_error error;
    char text[1024];
    for (int k = 0; k < 3; k++) {
        assert_true(fewray_guide_create(&h->look, &wrong[k], &guide, NULL, &error) < 0);
        assert_null(guide);
        assert_non_null(strstr(fewray_error_text(&error, text, sizeof text), says[k]));
    }
    struct fewray_guide_look looks[4] = {h->look, h->look, h->look, h->look};
    looks[0].width = 0;
    looks[1].emitted = NULL;
    looks[2].second_bounce = NULL;
    looks[3].width = looks[3].height = 1 << 20;
    const char *const tells[4] = {"0 x 32", "`emitted`", "all or none", "2^31"};
    for (int k = 0; k < 4; k++) {
        assert_true(fewray_guide_create(&looks[k], NULL, &guide, NULL, &error) < 0);
        assert_null(guide);
        assert_non_null(strstr(error.what, tells[k]));
    }
    free(h);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_densities_integrate_to_one),
        cmocka_unit_test(test_guided_mean_is_the_integral_with_less_noise),
        cmocka_unit_test(test_many_at_once_equal_one_by_one_on_any_threads),
        cmocka_unit_test(test_maps_are_those_of_our_own_renderer),
        cmocka_unit_test(test_irradiance_is_that_of_the_sky),
        cmocka_unit_test(test_bad_records_are_left_out_and_counted),
        cmocka_unit_test(test_wrong_arguments_are_refused_with_a_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
