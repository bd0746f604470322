/* SPDX-License-Identifier: Apache-2.0 */
/* Practical path guiding: what the trees learn from made-up records. */

#include "tests/unit/check.h"

#include <string.h>

#include "guide/odis/sphere_grid.h"
#include "guide/ppg/ppg.h"
#include "guide/trace/sampler.h"

static float uniform(uint32_t stream, uint32_t i) {
    return to_unit_float(hash_combine(stream, i));
}

/* Unit direction at (a, b) in [0, 1)^2, even over the sphere. */
static struct vec3 even_direction(float a, float b) {
    float y = 32 * a, x = 32 * b;
    return sphere_direction((int)y, (int)x, y - floorf(y), x - floorf(x));
}

static struct ppg *create(void) {
    struct ppg *ppg = NULL;
    assert_int_equal(ppg_create(vec(0, 0, 0), vec(1, 1, 1), 64 * 48, &ppg, NULL), FEWRAY_OK);
    return ppg;
}

/* Directions within 26 degrees of an axis are bright, the rest of the sphere 1/1000 of it. */
static const struct vec3 cap_axis = {0, 0.8f, 0.6f};

static float cap_radiance(struct vec3 d) {
    return dot(d, cap_axis) > 0.9f ? 10 : 0.01f;
}

/* A pass of n vertices spread over the box, whose directions come from the leaves with a fraction
 * of an even "BSDF", as a renderer would draw them. */
static void record_pass(struct ppg *ppg, uint32_t stream, int n, float (*radiance)(struct vec3),
                        int buffers, int threads) {
    struct ppg_buffer *b = calloc((size_t)buffers, sizeof(*b));
    const float even = 0.25f / PI_F;
    for (int i = 0; i < n; i++) {
        uint32_t k = (uint32_t)i * 8;
        struct vec3 p = vec(uniform(stream, k), uniform(stream, k + 1), uniform(stream, k + 2));
        float u[2] = {uniform(stream, k + 3), uniform(stream, k + 4)};
        const struct ppg_leaf *leaf = ppg_leaf_at(ppg, p);
        float fraction = leaf ? ppg_leaf_bsdf_fraction(leaf) : 1;
        struct vec3 d = uniform(stream, k + 5) < fraction ? even_direction(u[0], u[1])
                                                          : ppg_leaf_sample(leaf, u);
        float guide_pdf = leaf ? ppg_leaf_pdf(leaf, d) : 0;
        float pdf = fraction * even + (1 - fraction) * guide_pdf, l = radiance(d);
        struct vertex_log log = {.count = 1};
        log.vertices[0] = (struct path_vertex){.position = p,
                                               .normal = vec(0, 1, 0),
                                               .direction = d,
                                               .weight = vec(1 / pdf, 1 / pdf, 1 / pdf),
                                               .incident = vec(l, l, l),
                                               .pdf = pdf,
                                               .bsdf_pdf = even,
                                               .guide_pdf = guide_pdf};
        assert_true(ppg_buffer_add(&b[(long long)i * buffers / n], &log));
    }
    assert_int_equal(ppg_splat(ppg, b, buffers, threads, NULL), FEWRAY_OK);
    for (int i = 0; i < buffers; i++) {
        assert_int_equal(b[i].count, 0);
        ppg_buffer_free(&b[i]);
    }
    free(b);
}

static struct ppg *learn(float (*radiance)(struct vec3), int passes, int n, int buffers,
                         int threads) {
    struct ppg *ppg = create();
    for (int k = 0; k < passes; k++) {
        record_pass(ppg, (uint32_t)k + 1, n << k, radiance, buffers, threads);
        assert_int_equal(ppg_end_pass(ppg, 1 << k, threads, NULL), FEWRAY_OK);
    }
    return ppg;
}

/* Integral over the sphere of the leaf's density, weighted (NULL: by 1). */
static double integral(const struct ppg_leaf *leaf, float (*weight)(struct vec3)) {
    const int n = 512;
    double sum = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            struct vec3 d =
                even_direction(((float)i + 0.5f) / (float)n, ((float)j + 0.5f) / (float)n);
            sum += (double)ppg_leaf_pdf(leaf, d) * (weight ? weight(d) : 1);
        }
    return sum * 4 * (double)PI_F / n / n;
}

static float in_cap(struct vec3 d) {
    return dot(d, cap_axis) > 0.9f;
}

static void test_nothing_is_known_in_the_first_pass(void **state) {
    (void)state;
    struct ppg *ppg = create();
    assert_null(ppg_leaf_at(ppg, vec(0.5f, 0.5f, 0.5f)));
    assert_int_equal(ppg_end_pass(ppg, 1, 1, NULL), FEWRAY_OK);
    const struct ppg_leaf *leaf = ppg_leaf_at(ppg, vec(0.5f, 0.5f, 0.5f));
    assert_non_null(leaf);
    assert_near(ppg_leaf_bsdf_fraction(leaf), 1, 0);
    assert_near(integral(leaf, NULL), 1, 1e-3);
    ppg_destroy(&ppg);
    assert_null(ppg);
}

static void test_pdf_concentrates_where_the_light_is(void **state) {
    (void)state;
    double before = 0;
    for (int passes = 1; passes <= 4; passes++) {
        struct ppg *ppg = learn(cap_radiance, passes, 2000, 1, 2);
        const struct ppg_leaf *leaf = ppg_leaf_at(ppg, vec(0.3f, 0.6f, 0.2f));
        assert_near(integral(leaf, NULL), 1, 0.01);
        double inside = integral(leaf, in_cap);
        assert_true(inside > fmax(before - 0.01, 0.5));
        before = inside;
        ppg_destroy(&ppg);
    }
    assert_true(before > 0.85); /* 98 % of the light is in the cap; the box filter blurs */
}

static void test_samples_follow_pdf(void **state) {
    (void)state;
    struct ppg *ppg = learn(cap_radiance, 3, 2000, 1, 2);
    const struct ppg_leaf *leaf = ppg_leaf_at(ppg, vec(0.9f, 0.1f, 0.5f));
    static double observed[SPHERE_BINS], expected[SPHERE_BINS];
    const int n = 1 << 18, grid = 32; /* density points along a bin's sides */
    for (int b = 0; b < SPHERE_BINS; b++) {
        observed[b] = expected[b] = 0;
        for (int k = 0; k < grid * grid; k++)
            expected[b] += (double)ppg_leaf_pdf(
                leaf, sphere_direction(b / SPHERE_COLUMNS, b % SPHERE_COLUMNS,
                                       ((float)(k / grid) + 0.5f) / (float)grid,
                                       ((float)(k % grid) + 0.5f) / (float)grid));
        expected[b] *= (double)n * SPHERE_BIN_SOLID_ANGLE / (grid * grid);
    }
    for (int i = 0; i < n; i++) {
        float u[2] = {uniform(90, (uint32_t)i), uniform(91, (uint32_t)i)};
        struct vec3 d = ppg_leaf_sample(leaf, u);
        assert_near(length(d), 1, 1e-5);
        observed[sphere_bin(d)]++;
    }
    int degrees;
    double statistic = chi_square(observed, expected, SPHERE_BINS, &degrees);
    assert_true(degrees > 100 && statistic < chi_square_limit(degrees));
    ppg_destroy(&ppg);
}

static void test_extreme_random_numbers_are_safe(void **state) {
    (void)state;
    struct ppg *ppg = learn(cap_radiance, 3, 2000, 1, 1);
    const float ends[] = {0, 0x1.fffffep-1f};
    const struct ppg_leaf *leaf = ppg_leaf_at(ppg, vec(NAN, -1e30f, INFINITY));
    for (int i = 0; i < 4; i++) {
        struct vec3 d = ppg_leaf_sample(leaf, (float[2]){ends[i / 2], ends[i % 2]});
        assert_near(length(d), 1, 1e-5);
    }
    assert_true(isfinite(ppg_leaf_pdf(leaf, vec(0, 1, 0))));
    assert_true(isfinite(ppg_leaf_pdf(leaf, vec(0, -1, 0))));
    assert_true(isfinite(ppg_leaf_pdf(leaf, vec(-0.0f, 0, -1))));
    ppg_destroy(&ppg);
}

static float even_radiance(struct vec3 d) {
    (void)d;
    return 1;
}

/* Where the guide follows the cap it must be preferred; where all is even, the BSDF (even, too,
 * here but without the guide's noise). */
static void test_bsdf_fraction_moves_the_right_way(void **state) {
    (void)state;
    struct ppg *ppg = learn(cap_radiance, 1, 4000, 1, 1);
    assert_near(ppg_leaf_bsdf_fraction(ppg_leaf_at(ppg, vec(0, 0, 0))), 0.5, 1e-6);
    ppg_destroy(&ppg);
    ppg = learn(cap_radiance, 4, 4000, 1, 2);
    assert_true(ppg_leaf_bsdf_fraction(ppg_leaf_at(ppg, vec(0, 0, 0))) < 0.3);
    ppg_destroy(&ppg);
    ppg = learn(even_radiance, 4, 500, 1, 2);
    assert_true(ppg_leaf_bsdf_fraction(ppg_leaf_at(ppg, vec(0, 0, 0))) > 0.55);
    ppg_destroy(&ppg);
}

static float upper_half(struct vec3 d) {
    return d.y > 0;
}

static void test_space_is_split_where_records_are(void **state) {
    (void)state;
    struct ppg *ppg = create();
    record_pass(ppg, 1, 900, upper_half, 1, 1);
    assert_int_equal(ppg_end_pass(ppg, 1, 1, NULL), FEWRAY_OK);
    assert_int_equal(ppg_leaf_count(ppg), 1); /* not above c = 1000 */
    record_pass(ppg, 2, 7900, upper_half, 1, 1);
    assert_int_equal(ppg_end_pass(ppg, 1, 1, NULL), FEWRAY_OK);
    assert_int_equal(ppg_leaf_count(ppg), 8);
    record_pass(ppg, 3, 7900, upper_half, 1, 1);
    assert_int_equal(ppg_end_pass(ppg, 2, 1, NULL), FEWRAY_OK);
    assert_int_equal(ppg_leaf_count(ppg), 8); /* fewer than c sqrt(2) each */
    assert_ptr_not_equal(ppg_leaf_at(ppg, vec(0.1f, 0.1f, 0.1f)),
                         ppg_leaf_at(ppg, vec(0.9f, 0.1f, 0.1f)));
    assert_ptr_equal(ppg_leaf_at(ppg, vec(0.1f, 0.1f, 0.1f)),
                     ppg_leaf_at(ppg, vec(0.4f, 0.4f, 0.4f)));
    ppg_destroy(&ppg);
}

static void test_same_bits_on_any_number_of_threads_and_buffers(void **state) {
    (void)state;
    struct ppg *one = learn(cap_radiance, 4, 5000, 1, 1);
    struct ppg *many = learn(cap_radiance, 4, 5000, 7, 3);
    assert_true(ppg_leaf_count(one) > 8);
    assert_int_equal(ppg_leaf_count(one), ppg_leaf_count(many));
    for (uint32_t i = 0; i < 20000; i++) {
        struct vec3 p = vec(uniform(5, i), uniform(6, i), uniform(7, i));
        const struct ppg_leaf *a = ppg_leaf_at(one, p), *b = ppg_leaf_at(many, p);
        float u[2] = {uniform(8, i), uniform(9, i)};
        struct vec3 da = ppg_leaf_sample(a, u), db = ppg_leaf_sample(b, u);
        float pa = ppg_leaf_pdf(a, da), pb = ppg_leaf_pdf(b, da);
        float fa = ppg_leaf_bsdf_fraction(a), fb = ppg_leaf_bsdf_fraction(b);
        assert_memory_equal(&da, &db, sizeof(da));
        assert_memory_equal(&pa, &pb, sizeof(pa));
        assert_memory_equal(&fa, &fb, sizeof(fa));
    }
    ppg_destroy(&one);
    ppg_destroy(&many);
}

static float dark(struct vec3 d) {
    (void)d;
    return 0;
}
static float broken(struct vec3 d) {
    return d.x > 0 ? NAN : d.y > 0 ? INFINITY : d.z > 0 ? 3e38f : -1;
}
static float glaring(struct vec3 d) {
    return d.y > 0.9f ? 3e37f : 1;
}

static void test_bad_records_are_safe(void **state) {
    (void)state;
    float (*const cases[])(struct vec3) = {dark, broken, glaring};
    for (int k = 0; k < 3; k++) {
        struct ppg *ppg = learn(cases[k], 3, 3000, 2, 2);
        for (uint32_t i = 0; i < 200; i++) {
            const struct ppg_leaf *leaf =
                ppg_leaf_at(ppg, vec(uniform(5, i), uniform(6, i), uniform(7, i)));
            float u[2] = {uniform(8, i), uniform(9, i)}, fraction = ppg_leaf_bsdf_fraction(leaf);
            struct vec3 d = ppg_leaf_sample(leaf, u);
            assert_near(length(d), 1, 1e-5);
            assert_true(isfinite(ppg_leaf_pdf(leaf, d)));
            assert_true(k == 0 ? fraction == 1 : fraction > 0 && fraction <= 1);
        }
        assert_near(integral(ppg_leaf_at(ppg, vec(0.5f, 0.5f, 0.5f)), NULL), 1, 0.02);
        ppg_destroy(&ppg);
    }
}

/* One narrow light: the tree deepens pass by pass, across the seam of the azimuth as well. */
static float narrow(struct vec3 d) {
    return dot(d, normalize(vec(0, 0.1f, 1))) > 0.9995f ? 1000 : 0;
}

static void test_tree_deepens_on_a_narrow_light(void **state) {
    (void)state;
    struct ppg *ppg = learn(narrow, 5, 8000, 1, 2);
    const struct ppg_leaf *leaf = ppg_leaf_at(ppg, vec(0.5f, 0.5f, 0.5f));
    struct vec3 towards = normalize(vec(0, 0.1f, 1));
    assert_true(ppg_leaf_pdf(leaf, towards) > 0.3 / (2 * (double)PI_F * 0.0005));
    assert_true(ppg_leaf_pdf(leaf, negate(towards)) < 1e-3);
    ppg_destroy(&ppg);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nothing_is_known_in_the_first_pass),
        cmocka_unit_test(test_pdf_concentrates_where_the_light_is),
        cmocka_unit_test(test_samples_follow_pdf),
        cmocka_unit_test(test_extreme_random_numbers_are_safe),
        cmocka_unit_test(test_bsdf_fraction_moves_the_right_way),
        cmocka_unit_test(test_space_is_split_where_records_are),
        cmocka_unit_test(test_same_bits_on_any_number_of_threads_and_buffers),
        cmocka_unit_test(test_bad_records_are_safe),
        cmocka_unit_test(test_tree_deepens_on_a_narrow_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
