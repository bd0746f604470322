/* SPDX-License-Identifier: Apache-2.0 */
/* Smooth and rough plastic: energy, the table of the coat, and that samples follow their density.
 */

#include "tests/unit/bsdf_samples.h"
#include "tests/unit/check.h"
#include "tests/unit/plain_bsdf.h"

#include "fewray/features.h"
#include "guide/bsdf/fresnel.h"
#include "guide/bsdf/microfacet.h"
#include "guide/trace/sampler.h"

static const float cosines[] = {1, 0.8f, 0.4f, 0.1f};
#define COSINES 4

/* Share of even light that comes back, by samples; specular: of the smooth coat alone. */
static double albedo_by_samples(const struct bsdf_local *b, double *specular) {
    enum { N = 4096 };
    double sum = 0;
    *specular = 0;
    for (uint32_t i = 0; i < N; i++) {
        float u[2], v[2];
        sobol_point(i, 1, u);
        sobol_point(i, 2, v);
        struct bsdf_sample s;
        if (!plastic_sample(b, v[0], u, &s))
            continue;
        sum += (double)s.weight.x / N;
        *specular += s.delta ? (double)s.weight.x / N : 0;
    }
    return sum;
}

/* What the coat mirrors and what it lets in and out make up the whole, but for the fits of the
 * diffuse Fresnel reflectances (0.2%). */
static void test_white_smooth_plastic_absorbs_nothing(void **state) {
    (void)state;
    for (int nonlinear = 0; nonlinear < 2; nonlinear++)
        for (int i = 0; i < 3 * COSINES; i++) {
            struct plain_bsdf p;
            const float etas[] = {1.3f, 1.5f, 1.9f};
            plain_bsdf_init(&p, BSDF_PLASTIC, etas[i / COSINES], vec(1, 1, 1), 0, NULL);
            p.bsdf.nonlinear = nonlinear;
            plain_bsdf_table(&p);
            struct bsdf_local b = plain_bsdf_at(&p, direction_at(cosines[i % COSINES], 0.3f));
            plastic_prepare(&b);
            double specular, albedo = albedo_by_samples(&b, &specular);
            assert_near(albedo, 1, 5e-3);
            assert_near(albedo - specular, b.albedo.x, 5e-3);
        }
}

/* With `nonlinear` a base of the reflectance r inside comes back as r (1 - k) / (1 - k r). */
static void test_nonlinear_plastic_is_darker(void **state) {
    (void)state;
    struct plain_bsdf p;
    plain_bsdf_init(&p, BSDF_PLASTIC, 1.5f, vec(0.5f, 0.5f, 0.5f), 0, NULL);
    plain_bsdf_table(&p);
    struct bsdf_local b = plain_bsdf_at(&p, direction_at(0.7f, 0));
    struct vec3 incident = direction_at(0.6f, 2);
    double linear = plastic_eval(&b, incident).x, k = p.table.internal_reflectance;
    p.bsdf.nonlinear = true;
    assert_near(plastic_eval(&b, incident).x / linear, (1 - k) / (1 - 0.5 * k), 1e-5);
}

/* A rough coat loses what its microfacets mirror twice, but never makes light; an almost smooth one
 * loses little. */
static void test_rough_plastic_makes_no_light(void **state) {
    (void)state;
    const float alphas[] = {0, 0.02f, 0.1f, 0.3f, 1};
    for (int k = 0; k < 10; k++) {
        struct plain_bsdf p;
        plain_bsdf_init(&p, BSDF_ROUGH_PLASTIC, 1.5f, vec(1, 1, 1), alphas[k / 2], NULL);
        p.bsdf.microfacets = k % 2 ? MICROFACET_GGX : MICROFACET_BECKMANN;
        plain_bsdf_table(&p);
        for (int i = 0; i < COSINES; i++) {
            struct bsdf_local b = plain_bsdf_at(&p, direction_at(cosines[i], 0.3f));
            plastic_prepare(&b);
            double specular, albedo = albedo_by_samples(&b, &specular);
            assert_true(albedo < 1.005 && specular == 0);
            assert_near(albedo, b.albedo.x, 0.02);
            if (k < 2)
                assert_true(albedo > 0.97);
        }
    }
}

/* By the plain sum over all microfacets: what passes from outside, or is mirrored inside. */
static double coat_by_sum(const struct microfacets *d, float cos_theta, float eta, bool passed) {
    enum { TILTS = 160, TURNS = 40 };
    struct vec3 v = direction_at(cos_theta, 0);
    double sum = 0;
    for (int i = 0; i < TILTS; i++)
        for (int j = 0; j < TURNS; j++) {
            double theta = M_PI / 2 * (i + 0.5) / TILTS, phi = M_PI * (j + 0.5) / TURNS;
            struct vec3 m = direction_at((float)cos(theta), (float)phi);
            double cell = sin(theta) * (M_PI / 2 / TILTS) * (2 * M_PI / TURNS);
            float between = dot(v, m);
            if (!(between > 0))
                continue;
            struct fresnel f = fresnel_dielectric(between, eta);
            struct vec3 w = passed ? refract_at(v, m, &f) : reflect_at(v, m);
            if (passed != (w.z < 0))
                continue;
            double share = passed ? 1 - f.reflectance : f.reflectance;
            sum += cell * share * microfacet_pdf(d, v, m) * microfacet_g1(d, w, m);
        }
    return sum;
}

static void test_table_equals_the_sum_over_microfacets(void **state) {
    (void)state;
    for (int k = 0; k < 4; k++) {
        struct plain_bsdf p;
        float alpha = k < 2 ? 0.2f : 0.5f, eta = 1.5f;
        plain_bsdf_init(&p, BSDF_ROUGH_PLASTIC, eta, vec(1, 1, 1), alpha, NULL);
        p.bsdf.microfacets = k % 2 ? MICROFACET_GGX : MICROFACET_BECKMANN;
        plain_bsdf_table(&p);
        struct microfacets d = microfacets_make(p.bsdf.microfacets, alpha, alpha);
        double internal = 0;
        for (int i = 4; i < BSDF_TRANSMITTANCE_SIZE; i++) {
            float c = (float)i / (BSDF_TRANSMITTANCE_SIZE - 1);
            if (i % 8 == 7)
                assert_near(p.table.transmittance[i], coat_by_sum(&d, c, eta, true), 3e-3);
            internal += coat_by_sum(&d, c, 1 / eta, false) * 2 * c / BSDF_TRANSMITTANCE_SIZE;
        }
        assert_near(p.table.internal_reflectance, internal, 4e-3); /* less 4 entries near 0 */
    }
}

static void test_sampling_weight_takes_mean_reflectances(void **state) {
    (void)state;
    struct plain_bsdf p;
    plain_bsdf_init(&p, BSDF_PLASTIC, 1.5f, vec(0.9f, 0.3f, 0.1f), 0, NULL);
    plain_bsdf_table(&p);
    assert_near(p.table.specular_sampling_weight, 1 / (1 + 1.3 / 3), 1e-6);

    struct texture *t = &p.textures[PLAIN_REFLECTANCE];
    t->kind = TEXTURE_CHECKERBOARD;
    t->color1 = vec(0.2f, 0.2f, 0.8f);
    plain_bsdf_table(&p);
    assert_near(p.table.specular_sampling_weight, 1 / (1 + 2.5 / 6), 1e-6);

    uint8_t bytes[6] = {0, 255, 0, 0, 0, 255};
    const struct fewray_image image = {.width = 2, .height = 1, .channels = 3, .bytes = bytes};
    *t = (struct texture){
        .kind = TEXTURE_BITMAP, .factor = {1, 1, 1}, .image = &image, .channel = -1, .srgb = true};
    plain_bsdf_table(&p);
    assert_near(p.table.specular_sampling_weight, 1 / (1 + 0.5 * (0.7152 + 0.0722)), 1e-6);
}

static void test_samples_follow_the_density(void **state) {
    (void)state;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < COSINES; i++) {
            struct plain_bsdf p;
            plain_bsdf_init(&p, k ? BSDF_ROUGH_PLASTIC : BSDF_PLASTIC, 1.5f, vec(0.2f, 0.5f, 0.8f),
                            0.3f, NULL);
            p.bsdf.microfacets = k == 2 ? MICROFACET_GGX : MICROFACET_BECKMANN;
            plain_bsdf_table(&p);
            struct bsdf_local b = plain_bsdf_at(&p, direction_at(cosines[i], 0.3f));
            plastic_prepare(&b);
            check_samples(&b, plastic_eval, plastic_pdf, plastic_sample);
        }
}

static void test_grazing_and_hidden_directions_are_finite(void **state) {
    (void)state;
    const float z[] = {1, 0.5f, 1e-3f, 1e-20f, 0, -1e-20f, -0.5f, -1};
    for (int k = 0; k < 8; k++) {
        struct plain_bsdf p;
        plain_bsdf_init(&p, k < 4 ? BSDF_ROUGH_PLASTIC : BSDF_PLASTIC, k % 2 ? 1 : 1.5f,
                        vec(0, 0, 1), 0, NULL);
        p.bsdf.microfacets = k & 2 ? MICROFACET_GGX : MICROFACET_BECKMANN;
        plain_bsdf_table(&p);
        for (int i = 0; i < 64; i++) {
            struct bsdf_local b = plain_bsdf_at(&p, direction_at(z[i / 8], 0.3f));
            struct vec3 w = direction_at(z[i % 8], 0.3f + PI_F);
            plastic_prepare(&b);
            struct vec3 f = plastic_eval(&b, w);
            float pdf = plastic_pdf(&b, w), u[2] = {0.3f, 0.999999f};
            assert_true(isfinite(f.x + f.y + f.z) && isfinite(pdf));
            assert_true(isfinite(b.albedo.x + b.albedo.z + b.breadth + b.delta_chance));
            struct bsdf_sample s;
            if (plastic_sample(&b, i % 2 ? 0 : 0.99f, u, &s))
                assert_true(isfinite(s.pdf) && isfinite(s.weight.x + s.weight.z));
            if (z[i / 8] <= 0 || z[i % 8] <= 0)
                assert_true(max_component(f) == 0 && pdf == 0);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_white_smooth_plastic_absorbs_nothing),
        cmocka_unit_test(test_nonlinear_plastic_is_darker),
        cmocka_unit_test(test_rough_plastic_makes_no_light),
        cmocka_unit_test(test_table_equals_the_sum_over_microfacets),
        cmocka_unit_test(test_sampling_weight_takes_mean_reflectances),
        cmocka_unit_test(test_samples_follow_the_density),
        cmocka_unit_test(test_grazing_and_hidden_directions_are_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
