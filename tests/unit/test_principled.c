/* SPDX-License-Identifier: Apache-2.0 */
/* The principled BSDF: known values, reciprocity, and that samples follow their density. */

#include "tests/unit/bsdf_samples.h"
#include "tests/unit/check.h"
#include "tests/unit/plain_bsdf.h"

#define METALLIC        [PRINCIPLED_METALLIC]
#define ROUGHNESS       [PRINCIPLED_ROUGHNESS]
#define ANISOTROPIC     [PRINCIPLED_ANISOTROPIC]
#define SPEC_TRANS      [PRINCIPLED_SPEC_TRANS]
#define SPEC_TINT       [PRINCIPLED_SPEC_TINT]
#define SHEEN           [PRINCIPLED_SHEEN]
#define SHEEN_TINT      [PRINCIPLED_SHEEN_TINT]
#define CLEARCOAT       [PRINCIPLED_CLEARCOAT]
#define CLEARCOAT_GLOSS [PRINCIPLED_CLEARCOAT_GLOSS]
#define FLATNESS        [PRINCIPLED_FLATNESS]

static const float materials[][PRINCIPLED_COUNT] = {
    {ROUGHNESS = 0.5f},
    {ROUGHNESS = 0.6f, METALLIC = 1, ANISOTROPIC = 0.7f},
    {ROUGHNESS = 0.7f, SHEEN = 0.8f, SHEEN_TINT = 0.4f, SPEC_TINT = 0.6f},
    {ROUGHNESS = 0.8f, CLEARCOAT = 1, CLEARCOAT_GLOSS = 0.1f, METALLIC = 0.3f},
    {ROUGHNESS = 0.6f, FLATNESS = 0.7f},
    {ROUGHNESS = 0.7f, SPEC_TRANS = 1},
    {ROUGHNESS = 0.8f, SPEC_TRANS = 0.6f, METALLIC = 0.2f, CLEARCOAT = 0.5f, FLATNESS = 0.3f},
};
#define MATERIALS ((int)(sizeof(materials) / sizeof(materials[0])))

static const struct vec3 base = {0.8f, 0.4f, 0.1f};

static struct vec3 value_at(const struct plain_bsdf *p, struct vec3 outgoing,
                            struct vec3 incident) {
    struct bsdf_local b = plain_bsdf_at(p, outgoing);
    return principled_eval(&b, incident);
}

/* Straight up and down, where every weight of Schlick's is 0 and nothing is shadowed. */
static void test_values_at_normal_incidence(void **state) {
    (void)state;
    const struct vec3 up = {0, 0, 1};
    const double alpha = 0.25, d = 1 / (M_PI * alpha * alpha), f0 = 0.04;
    struct plain_bsdf p;
    const float plain[PRINCIPLED_COUNT] = {ROUGHNESS = 0.5f};
    plain_bsdf_init(&p, BSDF_PRINCIPLED, 1.5f, base, 0, plain);
    assert_near(value_at(&p, up, up).x, 0.8 / M_PI + f0 * d / 4, 1e-5);

    const float metal[PRINCIPLED_COUNT] = {ROUGHNESS = 0.5f, METALLIC = 1};
    plain_bsdf_init(&p, BSDF_PRINCIPLED, 1.5f, base, 0, metal);
    assert_near(value_at(&p, up, up).x, 0.8 * d / 4, 1e-5);

    const float coated[PRINCIPLED_COUNT] = {ROUGHNESS = 0.5f, CLEARCOAT = 0.5f};
    plain_bsdf_init(&p, BSDF_PRINCIPLED, 1.5f, base, 0, coated);
    double a2 = 0.01, coat = 0.5 * 0.25 * 0.04 * (a2 - 1) / (M_PI * log(a2) * a2);
    assert_near(value_at(&p, up, up).y, 0.4 / M_PI + f0 * d / 4 + coat, 1e-5);

    const float glass[PRINCIPLED_COUNT] = {ROUGHNESS = 0.5f, SPEC_TRANS = 1};
    plain_bsdf_init(&p, BSDF_PRINCIPLED, 1.5f, base, 0, glass);
    assert_near(value_at(&p, up, up).x, f0 * d / 4, 1e-5);
    assert_near(value_at(&p, up, negate(up)).x, sqrt(0.8) * (1 - f0) * d / (0.5 * 0.5), 1e-4);
}

/* f(a, b) = f(b, a), but for the radiance's scale by the square of the index where it goes through.
 */
static void test_reciprocity(void **state) {
    (void)state;
    for (int k = 0; k < MATERIALS; k++) {
        struct plain_bsdf p;
        plain_bsdf_init(&p, BSDF_PRINCIPLED, 1.5f, base, 0, materials[k]);
        for (uint32_t i = 0; i < 200; i++) {
            float u[2], v[2];
            sobol_point(i, 1, u), sobol_point(i, 2, v);
            struct vec3 a = direction_at(0.05f + 0.95f * u[0], 2 * PI_F * u[1]);
            struct vec3 b = direction_at(2 * v[0] - 1, 2 * PI_F * v[1]);
            double there = value_at(&p, a, b).y / fabsf(b.z);
            double back = value_at(&p, b, a).y / fabsf(a.z);
            if (b.z < 0)
                back /= 1.5 * 1.5;
            assert_near(there, back, 2e-4 * back + 1e-6);
        }
    }
}

static void test_samples_follow_the_density(void **state) {
    (void)state;
    const float cosines[] = {0.9f, 0.3f, -0.6f};
    for (int k = 0; k < MATERIALS; k++)
        for (int i = 0; i < (materials[k][PRINCIPLED_SPEC_TRANS] > 0 ? 3 : 2); i++) {
            struct plain_bsdf p;
            plain_bsdf_init(&p, BSDF_PRINCIPLED, 1.5f, base, 0, materials[k]);
            struct bsdf_local b = plain_bsdf_at(&p, direction_at(cosines[i], 0.3f));
            principled_prepare(&b);
            check_samples(&b, principled_eval, principled_pdf, principled_sample);
        }
}

static void test_opaque_is_black_from_below(void **state) {
    (void)state;
    for (int k = 0; k < MATERIALS; k++) {
        struct plain_bsdf p;
        plain_bsdf_init(&p, BSDF_PRINCIPLED, 1.5f, base, 0, materials[k]);
        struct bsdf_local b = plain_bsdf_at(&p, direction_at(-0.6f, 0.3f));
        principled_prepare(&b);
        bool glass = materials[k][PRINCIPLED_SPEC_TRANS] > 0;
        assert_true((max_component(b.albedo) > 0) == glass);
        assert_true((principled_eval(&b, direction_at(-0.6f, 3.4f)).x > 0) == glass);
        assert_true((principled_eval(&b, direction_at(0.8f, 3.4f)).x > 0) == glass);
        if (materials[k][PRINCIPLED_SPEC_TRANS] > 0.5f)
            assert_true(b.breadth == 0);
    }
}

static void test_extremes_are_finite(void **state) {
    (void)state;
    const float z[] = {1, 0.5f, 1e-3f, 1e-20f, 0, -1e-20f, -0.5f, -1};
    for (int k = 0; k < 32; k++) {
        float values[PRINCIPLED_COUNT];
        for (int i = 0; i < PRINCIPLED_COUNT; i++)
            values[i] = k & 1;
        values[PRINCIPLED_ROUGHNESS] = k & 2 ? 1 : 0;
        values[PRINCIPLED_METALLIC] = k & 4 ? 1 : 0;
        values[PRINCIPLED_SPEC_TRANS] = k & 8 ? 1 : 0;
        struct plain_bsdf p;
        plain_bsdf_init(&p, BSDF_PRINCIPLED, k & 16 ? 1 : 1.5f, vec(0, 0, 1), 0, values);
        for (int i = 0; i < 64; i++) {
            struct bsdf_local b = plain_bsdf_at(&p, direction_at(z[i / 8], 0.3f));
            struct vec3 w = direction_at(z[i % 8], 0.3f + PI_F);
            principled_prepare(&b);
            struct vec3 f = principled_eval(&b, w);
            float u[2] = {0.3f, 0.999999f};
            assert_true(isfinite(f.x + f.y + f.z) && isfinite(principled_pdf(&b, w)));
            assert_true(isfinite(b.albedo.x + b.albedo.z) && b.breadth >= 0 && b.breadth <= 1);
            struct bsdf_sample s;
            if (principled_sample(&b, (float)(i % 8) / 8, u, &s))
                assert_true(isfinite(s.pdf) && isfinite(s.weight.x + s.weight.z));
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values_at_normal_incidence),
        cmocka_unit_test(test_reciprocity),
        cmocka_unit_test(test_samples_follow_the_density),
        cmocka_unit_test(test_opaque_is_black_from_below),
        cmocka_unit_test(test_extremes_are_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
