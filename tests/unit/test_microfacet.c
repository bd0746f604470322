/* SPDX-License-Identifier: Apache-2.0 */
/* Microfacets and Fresnel's equations, and what rough BSDFs make of them at the edges of what is
 * allowed. */

#include "tests/unit/check.h"

#include "guide/bsdf/bsdf_local.h"
#include "guide/bsdf/fresnel.h"
#include "guide/bsdf/microfacet.h"
#include "guide/trace/sampler.h"

enum { RADII = 10, ANGLES = 16, PARTS = 8, SAMPLES = 20000 };

static const float alphas[][2] = {{0.01f, 0.01f}, {0.5f, 0.5f}, {0.1f, 0.4f}, {0.9f, 0.05f}};
static const float cosines[] = {1, 0.6f, 0.05f};

static float uniform(uint32_t stream, uint32_t i) {
    return to_unit_float(hash_combine(stream, i));
}

static struct vec3 direction(float cos_theta, float phi) {
    float r = sqrtf(fmaxf(1 - cos_theta * cos_theta, 0));
    return vec(r * cosf(phi), r * sinf(phi), cos_theta);
}

/* Normals are binned by their slopes over the alphas, r (cos phi, sin phi), in steps of phi and of
 * w = 1 / sqrt(1 + r^2). */
static struct vec3 normal_at(const struct microfacets *d, double w, double phi) {
    double r = sqrt(1 / (w * w) - 1);
    return normalize(
        vec((float)(d->alpha_u * r * cos(phi)), (float)(d->alpha_v * r * sin(phi)), 1));
}

/* d(solid angle) / (dw dphi) */
static double solid_angle_of(const struct microfacets *d, struct vec3 m, double w) {
    return (double)m.z * m.z * m.z * d->alpha_u * d->alpha_v / (w * w * w);
}

static int cell_of(const struct microfacets *d, struct vec3 m) {
    double x = m.x / (d->alpha_u * m.z), y = m.y / (d->alpha_v * m.z);
    double w = 1 / sqrt(1 + x * x + y * y), phi = atan2(y, x) / (2 * M_PI);
    int i = (int)fmin(w * RADII, RADII - 1), j = (int)((phi < 0 ? phi + 1 : phi) * ANGLES);
    return i * ANGLES + j % ANGLES;
}

/* Integrals of the density of visible normals over the cells, or of D cos(theta) where v is NULL.
 * Returns their sum. */
static double integrate(const struct microfacets *d, const struct vec3 *v, double *cells) {
    const int rows = RADII * PARTS, columns = ANGLES * PARTS;
    double sum = 0;
    for (int c = 0; c < RADII * ANGLES; c++)
        cells[c] = 0;
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < columns; j++) {
            double w = (i + 0.5) / rows, phi = 2 * M_PI * (j + 0.5) / columns;
            struct vec3 m = normal_at(d, w, phi);
            double value = v ? microfacet_pdf(d, *v, m) : microfacet_d(d, m) * m.z;
            value *= solid_angle_of(d, m, w) * 2 * M_PI / (rows * columns);
            cells[i / PARTS * ANGLES + j / PARTS] += value;
            sum += value;
        }
    return sum;
}

static void test_normals_project_to_the_surface(void **state) {
    (void)state;
    double cells[RADII * ANGLES];
    for (int kind = 0; kind < 2; kind++)
        for (int a = 0; a < 4; a++) {
            struct microfacets d =
                microfacets_make((enum microfacet_kind)kind, alphas[a][0], alphas[a][1]);
            assert_near(integrate(&d, NULL, cells), 1, 1e-3);
        }
}

static void assert_follows(const struct microfacets *d, struct vec3 v, uint32_t stream) {
    double expected[RADII * ANGLES], observed[RADII * ANGLES] = {0};
    double sum = integrate(d, &v, expected);
    assert_near(sum, 1, d->kind == MICROFACET_GGX ? 2e-3 : 6e-3);
    for (uint32_t i = 0; i < SAMPLES; i++) {
        float u[2] = {uniform(stream, 2 * i), uniform(stream, 2 * i + 1)};
        struct vec3 m = microfacet_sample(d, v, u);
        assert_near(length(m), 1, 1e-5);
        assert_true(m.z >= 0);
        observed[cell_of(d, m)]++;
    }
    for (int c = 0; c < RADII * ANGLES; c++)
        expected[c] *= SAMPLES / sum;
    int degrees;
    double statistic = chi_square(observed, expected, RADII * ANGLES, &degrees);
    if (!(statistic < chi_square_limit(degrees)))
        fail_msg("kind %d, alphas %g %g, cos %g: %g of %d degrees", d->kind, d->alpha_u, d->alpha_v,
                 v.z, statistic, degrees);
}

static void test_visible_normals_follow_their_pdf(void **state) {
    (void)state;
    uint32_t stream = 1;
    for (int kind = 0; kind < 2; kind++)
        for (int a = 0; a < 4; a++)
            for (int c = 0; c < 3; c++) {
                struct microfacets d =
                    microfacets_make((enum microfacet_kind)kind, alphas[a][0], alphas[a][1]);
                assert_follows(&d, direction(cosines[c], 2.5f * (float)c), stream++);
            }
}

static void test_fresnel_at_known_angles(void **state) {
    (void)state;
    const float etas[] = {1.5f, 1.33f, 1 / 1.5f, 2.4f};
    for (int i = 0; i < 4; i++) {
        float eta = etas[i], r = (eta - 1) / (eta + 1);
        for (int side = -1; side <= 1; side += 2)
            assert_near(fresnel_dielectric((float)side, eta).reflectance, r * r, 1e-6);
        assert_near(fresnel_dielectric(0, eta).reflectance, 1, 0);
        assert_near(fresnel_conductor(1, eta, 0), r * r, 1e-6);
        assert_near(fresnel_conductor(0.7f, fmaxf(eta, 1 / eta), 0),
                    fresnel_dielectric(eta > 1 ? 0.7f : -0.7f, eta).reflectance, 1e-6);
        float brewster = 1 / sqrtf(1 + eta * eta); /* the reflection is polarized whole */
        struct fresnel f = fresnel_dielectric(brewster, eta);
        float s = (brewster + eta * f.cos_t) / (brewster - eta * f.cos_t);
        assert_near(f.reflectance, 0.5f * s * s, 1e-6);
    }
    float critical = sqrtf(1 - 1 / (1.5f * 1.5f));
    assert_near(fresnel_dielectric(-critical * 0.999f, 1.5f).reflectance, 1, 0);
    assert_near(fresnel_dielectric(-critical * 0.999f, 1.5f).cos_t, 0, 0);
    assert_true(fresnel_dielectric(-critical * 1.001f, 1.5f).reflectance < 0.9f);
    assert_near(fresnel_dielectric(0.4f, 1).reflectance, 0, 0);
    assert_near(fresnel_conductor(1, 0.2f, 3.9f), (0.64 + 15.21) / (1.44 + 15.21), 1e-6);
    for (float cos_i = 0; cos_i <= 1; cos_i += 0.125f)
        assert_near(fresnel_conductor(cos_i, 0, 1), 1, 0);
}

static void test_diffuse_reflectance_is_the_mean_over_the_hemisphere(void **state) {
    (void)state;
    const float etas[] = {1.1f, 1.33f, 1.5f, 1.9f, 1 / 1.33f, 1 / 1.5f};
    for (int i = 0; i < 6; i++) {
        double sum = 0;
        for (int k = 0; k < 2000; k++) {
            float cos_i = ((float)k + 0.5f) / 2000;
            sum += 2 * cos_i * fresnel_dielectric(cos_i, etas[i]).reflectance / 2000;
        }
        assert_near(fresnel_diffuse_reflectance(etas[i]), sum, 0.004);
    }
}

static void test_refraction_obeys_snell(void **state) {
    (void)state;
    struct vec3 m = normalize(vec(0.1f, -0.2f, 0.9f));
    for (int side = -1; side <= 1; side += 2) {
        struct vec3 v = normalize(vec(0.3f, 0.2f, 0.9f * (float)side));
        struct fresnel f = fresnel_dielectric(dot(v, m), 1.5f);
        struct vec3 t = refract_at(v, m, &f), r = reflect_at(v, m);
        assert_near(length(t), 1, 1e-6);
        assert_near(length(cross(t, m)) * f.eta_it, length(cross(v, m)), 1e-6);
        assert_near(dot(t, m), f.cos_t, 1e-6);
        assert_near(dot(r, m), dot(v, m), 1e-6);
    }
}

struct rough {
    struct bsdf bsdf;
    struct bsdf_local local;
};

static void make_rough(struct rough *r, bool metal, int kind, float alpha, float eta,
                       struct vec3 outgoing) {
    r->bsdf = (struct bsdf){.kind = metal ? BSDF_ROUGH_CONDUCTOR : BSDF_ROUGH_DIELECTRIC,
                            .microfacets = (enum microfacet_kind)kind,
                            .eta = eta,
                            .conductor_k = {1, 1, 1}};
    r->local = (struct bsdf_local){.bsdf = &r->bsdf,
                                   .outgoing = outgoing,
                                   .specular_reflectance = {1, 1, 1},
                                   .specular_transmittance = {1, 1, 1},
                                   .alpha_u = alpha,
                                   .alpha_v = 0.5f * alpha};
    metal ? conductor_prepare(&r->local) : dielectric_prepare(&r->local);
}

static bool sample_rough(const struct rough *r, uint32_t stream, uint32_t i,
                         struct bsdf_sample *out) {
    const float u[2] = {uniform(stream, 3 * i), uniform(stream, 3 * i + 1)};
    float choice = uniform(stream, 3 * i + 2);
    return r->bsdf.kind == BSDF_ROUGH_CONDUCTOR ? conductor_sample(&r->local, choice, u, out)
                                                : dielectric_sample(&r->local, choice, u, out);
}

/* Without the scale of radiance on entering another medium. */
static void test_no_light_is_made(void **state) {
    (void)state;
    for (int k = 0; k < 24; k++) {
        const float cos_theta[] = {0.9f, 0.05f, -0.4f};
        bool metal = k & 1;
        float eta = k & 4 ? 1.5f : 1 / 1.33f;
        struct rough r;
        make_rough(&r, metal, k >> 1 & 1, k & 8 ? 0.8f : 0.1f, eta, direction(cos_theta[k % 3], 1));
        double sum = 0;
        for (uint32_t i = 0; i < 2000; i++) {
            struct bsdf_sample s;
            if (!sample_rough(&r, (uint32_t)k + 50, i, &s))
                continue;
            sum += s.weight.x * s.eta * s.eta / 2000;
            assert_true(s.weight.x * s.eta * s.eta < 1.0002f);
        }
        assert_true(metal && r.local.outgoing.z < 0 ? sum == 0 : sum > 0.3);
    }
}

static void check_finite(const struct rough *r, struct vec3 incident) {
    bool metal = r->bsdf.kind == BSDF_ROUGH_CONDUCTOR;
    struct vec3 f =
        metal ? conductor_eval(&r->local, incident) : dielectric_eval(&r->local, incident);
    float pdf = metal ? conductor_pdf(&r->local, incident) : dielectric_pdf(&r->local, incident);
    assert_true(isfinite(f.x) && f.x >= 0);
    assert_true(isfinite(pdf) && pdf >= 0);
}

static void test_extremes_stay_finite(void **state) {
    (void)state;
    const float z[] = {1, 0.5f,  1e-3f,   1e-8f,   1e-20f, 1e-38f,
                       0, -0.0f, -1e-38f, -1e-10f, -0.7f,  -1};
    const float roughness[] = {0, 1e-4f, 0.3f, 1, 1e6f}, etas[] = {1, 1.0001f, 1.5f, 0.4f};
    const int angles = sizeof z / sizeof z[0];
    for (int k = 0; k < 2 * 2 * 5 * 4 * angles; k++) {
        struct rough r;
        make_rough(&r, k & 1, k >> 1 & 1, roughness[k / 4 % 5], etas[k / 20 % 4],
                   direction(z[k / 80], 1));
        for (int j = 0; j < 3 * angles; j++)
            check_finite(&r, direction(z[j / 3], 1 + PI_F * 0.5f * (float)(j % 3)));
        for (uint32_t i = 0; i < 20; i++) {
            struct bsdf_sample s;
            if (!sample_rough(&r, 7, i, &s))
                continue;
            assert_near(length(s.direction), 1, 1e-5);
            assert_true(isfinite(s.pdf) && s.pdf > 0);
            assert_true(s.weight.x >= 0 && s.weight.x < 10);
            check_finite(&r, s.direction);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_normals_project_to_the_surface),
        cmocka_unit_test(test_visible_normals_follow_their_pdf),
        cmocka_unit_test(test_fresnel_at_known_angles),
        cmocka_unit_test(test_diffuse_reflectance_is_the_mean_over_the_hemisphere),
        cmocka_unit_test(test_refraction_obeys_snell),
        cmocka_unit_test(test_no_light_is_made),
        cmocka_unit_test(test_extremes_stay_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
