/* SPDX-License-Identifier: Apache-2.0 */
/* The sky and sun against values of Mitsuba 3.9.1's sunsky (scalar_rgb, emitter.eval). */

#include "tests/unit/check.h"

#include "guide/light/environment.h"
#include "guide/scene/sunsky.h"

static const struct vec3 directions[4] = {
    {0, 0, 1}, {0.6f, 0, 0.8f}, {0, 0.8f, 0.6f}, {-0.8f, -0.36f, 0.48f}};

struct expected {
    struct sunsky parameters;
    struct vec3 sky[4], sun;
};

static const struct expected cases[] = {
    {{3, 1, 1, 0.5358f, {0.6634139f, 0.5566704f, 0.5f}, {0.3f, 0.3f, 0.3f}},
     {{0.01646589f, 0.03133862f, 0.06254064f},
      {0.03472339f, 0.05558204f, 0.0932176f},
      {0.0454542f, 0.07201187f, 0.11560364f},
      {0.03778579f, 0.06768976f, 0.11511862f}},
     {20274.44f, 15949.582f, 10618.099f}},
    {{6.5f, 1, 1, 0.5358f, {-0.9305476f, -0.3386916f, 0.1391731f}, {0.1f, 0.5f, 0.9f}},
     {{0.01125063f, 0.01873106f, 0.02923823f},
      {0.01755287f, 0.02751994f, 0.03863829f},
      {0.02548566f, 0.03751519f, 0.04811198f},
      {0.18748945f, 0.15365504f, 0.10158902f}},
     {6897.557f, 3620.9668f, 1047.6859f}},
};

/* Emitter space to the map's, as sunsky.h has it. */
static struct environment sky_of(const struct fewray_image *image) {
    return (struct environment){.kind = ENVIRONMENT_MAP,
                                .image = image,
                                .scale = 1,
                                .to_local = {1, 0, 0, 0, 0, 1, 0, -1, 0}};
}

static void assert_color(struct vec3 value, struct vec3 expected, double tolerance) {
    assert_near(value.x, expected.x, tolerance * expected.x);
    assert_near(value.y, expected.y, tolerance * expected.y);
    assert_near(value.z, expected.z, tolerance * expected.z);
}

static void test_sky_and_sun_are_mitsubas(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(*cases); k++) {
        struct fewray_image *image;
        struct light sun;
        assert_int_equal(sunsky_create(&cases[k].parameters, &image, &sun, NULL), 0);
        struct environment sky = sky_of(image);
        for (int i = 0; i < 4; i++)
            assert_color(environment_radiance(&sky, directions[i]), cases[k].sky[i], 0.003);
        assert_color(sun.intensity, cases[k].sun, 0.01);
        assert_int_equal(sun.kind, LIGHT_SUN);
        assert_near(sun.cutoff, 0.2679 * PI_F / 180, 1e-6);
        assert_near(dot(sun.direction, cases[k].parameters.sun_direction), 1, 1e-6);
        fewray_image_destroy(&image);
    }
}

static void test_scales_and_aperture(void **state) {
    (void)state;
    struct sunsky s = cases[0].parameters;
    s.sun_scale = 0.5f;
    s.sky_scale = 2;
    s.sun_aperture = 8;
    struct fewray_image *image;
    struct light sun;
    assert_int_equal(sunsky_create(&s, &image, &sun, NULL), 0);
    struct environment sky = sky_of(image);
    assert_color(environment_radiance(&sky, directions[1]), scale(cases[0].sky[1], 2), 0.003);
    double ratio = pow(sin(0.25 * 0.5358 * PI_F / 180) / sin(0.25 * 8 * PI_F / 180), 2);
    assert_color(sun.intensity, scale(cases[0].sun, (float)(0.5 * ratio)), 0.01);
    fewray_image_destroy(&image);
}

static void test_ground_and_night_are_dark(void **state) {
    (void)state;
    struct sunsky s = cases[0].parameters;
    struct fewray_image *image;
    struct light sun;
    assert_int_equal(sunsky_create(&s, &image, &sun, NULL), 0);
    struct environment sky = sky_of(image);
    assert_near(luminance(environment_radiance(&sky, vec(0.8f, 0, -0.6f))), 0, 0);
    fewray_image_destroy(&image);
    s.sun_direction = vec(0.8f, 0, -0.6f);
    assert_int_equal(sunsky_create(&s, &image, &sun, NULL), 0);
    sky = sky_of(image);
    assert_near(luminance(environment_radiance(&sky, directions[1])), 0, 0);
    assert_near(luminance(sun.intensity), 0, 0);
    fewray_image_destroy(&image);
}

/* No parameter in range may give a colour that isn't finite or is below 0. */
static void test_extremes_are_finite(void **state) {
    (void)state;
    const float turbidities[] = {1, 9.999f, 10}, elevations[] = {0, 1e-4f, 0.5f, 1};
    for (int k = 0; k < 12; k++) {
        float z = elevations[k % 4], albedo = (float)(k % 2);
        struct sunsky s = {turbidities[k / 4],      1, 1, 0.01f, {sqrtf(1 - z * z), 0, z},
                           {albedo, albedo, albedo}};
        struct fewray_image *image;
        struct light sun;
        assert_int_equal(sunsky_create(&s, &image, &sun, NULL), 0);
        for (int i = 0; i < image->width * image->height * 3; i += 7)
            assert_true(image->floats[i] >= 0 && image->floats[i] < 1e3f);
        assert_true(sun.intensity.x >= 0 && sun.intensity.y >= 0 && isfinite(sun.intensity.x));
        fewray_image_destroy(&image);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sky_and_sun_are_mitsubas),
        cmocka_unit_test(test_scales_and_aperture),
        cmocka_unit_test(test_ground_and_night_are_dark),
        cmocka_unit_test(test_extremes_are_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
