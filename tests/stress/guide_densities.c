/* SPDX-License-Identifier: Apache-2.0 */
/* The guide's densities, of whatever they are made: they integrate to 1, what they draw has the
 * density that they tell, and the BSDF keeps its share. */

#include "guide_stage.h"

#include <omp.h>

#include <string.h>

/* Float sums of 1024 values, each of which was rounded twice. */
#define INTEGRAL_BOUND 2e-5

static double integral(const float *density, int size) {
    double sum = 0;
    for (int b = 0; b < size * size; b++)
        sum += (double)density[b];
    return sum * 4 * (double)PI_F / (size * size);
}

/* --- densities of made-up values */

static void even(float *v, int n) {
    for (int b = 0; b < n; b++)
        v[b] = 1;
}
static void none(float *v, int n) {
    memset(v, 0, (size_t)n * sizeof *v);
}
static void one_bin(float *v, int n) {
    none(v, n);
    v[n / 3] = 3;
}
static void last_bin(float *v, int n) {
    none(v, n);
    v[n - 1] = 1e-20f;
}
static void wide(float *v, int n) { /* 24 decades */
    for (int b = 0; b < n; b++)
        v[b] = powf(10, 24 * stage_random(1, b) - 12);
}
static void holes(float *v, int n) {
    for (int b = 0; b < n; b++)
        v[b] = stage_random(2, b) < 0.9f ? 0 : stage_random(3, b);
}
static void large(float *v, int n) {
    for (int b = 0; b < n; b++)
        v[b] = 1e34f * stage_random(4, b);
}
static void faint(float *v, int n) {
    for (int b = 0; b < n; b++)
        v[b] = 1e-34f * stage_random(5, b);
}
static void denormal(float *v, int n) {
    for (int b = 0; b < n; b++)
        v[b] = b % 3 ? 1e-44f : 0;
}
static void one_denormal(float *v, int n) {
    none(v, n);
    v[7] = 1e-45f;
}
static void overflowing(float *v, int n) {
    for (int b = 0; b < n; b++)
        v[b] = 3e38f;
}
static void with_nan(float *v, int n) {
    even(v, n);
    v[n / 2] = NAN;
}
static void with_infinity(float *v, int n) {
    even(v, n);
    v[n / 2] = INFINITY;
}
static void both_infinities(float *v, int n) {
    with_infinity(v, n);
    v[n / 2 + 1] = -INFINITY;
}
static void with_negative(float *v, int n) {
    even(v, n);
    v[5] = -0.5f;
}
static void all_negative(float *v, int n) {
    for (int b = 0; b < n; b++)
        v[b] = -1;
}

static const struct {
    const char *name;
    void (*fill)(float *values, int n);
    bool usable; /* else the map is refused, and the BSDF draws all */
} kinds[] = {
    {"even", even, true},
    {"one bin", one_bin, true},
    {"last bin", last_bin, true},
    {"24 decades", wide, true},
    {"holes", holes, true},
    {"1e34", large, true},
    {"1e-34", faint, true},
    {"none", none, false},
    {"denormals", denormal, false},
    {"one denormal", one_denormal, false},
    {"overflow", overflowing, false},
    {"NaN", with_nan, false},
    {"infinity", with_infinity, false},
    {"both infinities", both_infinities, false},
    {"a negative", with_negative, false},
    {"all negative", all_negative, false},
};

static const int sizes[] = {8, 16, 32};

struct table {
    float values[SPHERE_BINS], row_cdf[SPHERE_ROWS + 1], density[SPHERE_BINS];
};

/* Directions drawn by numbers at and beside every row's border, and at both ends of a row. */
static void assert_borders_are_safe(const char *name, const struct table *t, int size) {
    for (int r = 0; r <= size; r++)
        for (int k = 0; k < 9; k++) {
            const float at = t->row_cdf[r], ends[3] = {0, 0.5f, 0x1.fffffep-1f};
            const float beside = k % 3 == 0   ? nextafterf(at, 0)
                                 : k % 3 == 1 ? at
                                              : nextafterf(at, 1);
            const float u[2] = {fminf(beside, 0x1.fffffep-1f), ends[k / 3]};
            const struct vec3 d = density_sample(t->row_cdf, t->density, size, u);
            const float pdf = t->density[density_bin(d, size)];
            if (!(fabsf(length(d) - 1) < 1e-5f) || !(pdf > 0))
                fail_msg("%s, %d rows: (%.9g, %.9g) gives (%g, %g, %g) of density %g", name, size,
                         u[0], u[1], d.x, d.y, d.z, pdf);
        }
}

/* Pearson's test of 2^14 samples, at a level of 1e-5. */
static void assert_samples_follow(const char *name, const struct table *t, int size) {
    static double observed[SPHERE_BINS], expected[SPHERE_BINS];
    const int n = 1 << 14;
    memset(observed, 0, sizeof observed);
    for (int b = 0; b < size * size; b++)
        expected[b] = n * (double)t->density[b] * 4 * (double)PI_F / (size * size);
    for (int i = 0; i < n; i++) {
        const float u[2] = {stage_random(21, i), stage_random(22, i)};
        const struct vec3 d = density_sample(t->row_cdf, t->density, size, u);
        const int b = density_bin(d, size);
        if (!(t->density[b] > 0))
            fail_msg("%s: a sample in a bin of density 0", name);
        observed[b]++;
    }
    int degrees;
    const double statistic = chi_square(observed, expected, size * size, &degrees);
    if (degrees > 0 && !(statistic < chi_square_limit(degrees)))
        fail_msg("%s, %d rows: chi-square %.1f of %d", name, size, statistic, degrees);
}

static void test_density_of_any_values_is_one_or_refused(void **state) {
    (void)state;
    static struct table t;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        for (int s = 0; s < 3; s++) {
            const int size = sizes[s];
            kinds[k].fill(t.values, size * size);
            const bool made = density_build(t.values, size, t.row_cdf, t.density);
            if (made != kinds[k].usable)
                fail_msg("%s, %d rows: %s", kinds[k].name, size, made ? "taken" : "refused");
            if (!made)
                continue;
            if (!(fabs(integral(t.density, size) - 1) <= INTEGRAL_BOUND))
                fail_msg("%s, %d rows: integral %.9g", kinds[k].name, size,
                         integral(t.density, size));
            for (int b = 0; b < size * size; b++)
                assert_true(t.density[b] >= 0);
            assert_borders_are_safe(kinds[k].name, &t, size);
            assert_samples_follow(kinds[k].name, &t, size);
        }
}

/* --- what a look of any brightness makes */

static void scale_look(const struct fewray_look *look, float factor) {
    for (int i = 0; i < stage_records(look); i++) {
        struct look_record *r = &look->records[i];
        r->radiance = scale(r->radiance, factor);
        r->direct = scale(r->direct, factor);
        r->reflected *= factor;
        r->emitted *= factor;
        look->seconds[i].light_value *= factor;
        look->seconds[i].bounce_value *= factor;
    }
}

static void assert_shares(const struct fewray_maps *maps) {
    for (int m = 0; m < maps->count; m++) {
        const struct map *map = &maps->maps[m];
        if (map->blocks.i1 == map->blocks.i0)
            continue;
        assert_near(integral(map->density, SPHERE_ROWS), 1, INTEGRAL_BOUND);
        assert_true(map->bsdf_fraction >= MAP_LEAST_FRACTION && map->bsdf_fraction <= 1);
    }
    const struct probe_level *levels[2] = {&maps->probes->fine, &maps->probes->coarse};
    for (int l = 0; l < 2; l++)
        for (int k = 0; k < levels[l]->voxels.count; k++) {
            const struct probe *p = &levels[l]->probes[k];
            assert_true(p->bsdf_fraction >= 0.25f && p->bsdf_fraction <= 1);
            assert_true(p->light_chance >= 0.5f && p->light_chance <= 1);
            if (p->bsdf_fraction < 1)
                assert_near(integral(p->density, PROBE_SIZE), 1, INTEGRAL_BOUND);
        }
}

/* Of 1e-12 to 1e12 times the brightness: the maps are the same but for rounding. The range
 * compressor of the network's input and 12 layers multiply a rounding of 6e-8 by less than 1e3. */
#define SCALE_BOUND 1e-4

static void test_maps_dont_depend_on_the_unit_of_light(void **state) {
    (void)state;
    const float factors[] = {1e-12f, 1e-6f, 1e6f, 1e12f};
    struct stage base;
    stage_open(&base, 4, 8);
    stage_make_maps(&base);
    assert_shares(base.maps);
    for (int k = 0; k < 4; k++) {
        struct stage s;
        stage_open(&s, 4, 8);
        scale_look(s.look, factors[k]);
        stage_make_maps(&s);
        assert_shares(s.maps);
        assert_int_equal(s.maps->count, base.maps->count);
        for (int m = 0; m < s.maps->count; m++) {
            assert_near(s.maps->maps[m].bsdf_fraction, base.maps->maps[m].bsdf_fraction,
                        SCALE_BOUND);
            for (int b = 0; b < SPHERE_BINS; b++) {
                const double expected = (double)base.maps->maps[m].density[b];
                assert_near(s.maps->maps[m].density[b], expected, SCALE_BOUND * (1 + expected));
            }
        }
        stage_close(&s);
    }
    stage_close(&base);
}

/* Maps that learn from faint or glaring samples, without a share for the BSDF: each direction above
 * the horizon can still be drawn. */
static void test_learning_rules_no_direction_out(void **state) {
    (void)state;
    const float units[] = {1e-15f, 1e-9f, 1, 1e9f, 1e15f};
    for (int k = 0; k < 5; k++) {
        struct stage s;
        stage_open(&s, 4, 16);
        scale_look(s.look, units[k]);
        s.settings.bsdf_fraction = 0;
        stage_make_maps(&s);
        assert_non_null(s.maps->sums);
        struct look_record r = {.depth = 1, .bin = 3, .reflected = 1000 * units[k]};
        for (int y = 0; y < STAGE_HEIGHT; y++)
            for (int x = 0; x < STAGE_WIDTH; x++) {
                const int m = s.maps->index[y / 8 * s.maps->columns + x / 8];
                if (m >= 0)
                    r.normal = s.maps->maps[m].normal;
                maps_learn(s.maps, x, y, &r);
            }
        maps_refine(s.maps, 1);
        for (int m = 0; m < s.maps->count; m++) {
            assert_near(integral(s.maps->maps[m].density, SPHERE_ROWS), 1, INTEGRAL_BOUND);
            for (int b = 0; b < SPHERE_BINS; b++)
                if (!(s.maps->maps[m].density[b] > 0))
                    fail_msg("light of %g: bin %d of map %d can't be drawn", units[k], b, m);
        }
        stage_close(&s);
    }
}

/* --- the mixture at a surface */

/* Least share of the BSDF anywhere by default: MAP_LEAST_FRACTION but for a rounding. */
static void test_mixture_covers_the_bsdf(void **state) {
    (void)state;
    struct stage s;
    int guided = 0;
    stage_open(&s, 4, 8);
    stage_make_maps(&s);
    const struct guides guides = {.maps = s.maps, .probes = s.maps->probes};
    for (int i = 0; i < stage_records(s.look); i++) {
        const struct look_record *r = &s.look->records[i];
        if (!(r->depth > 0))
            continue;
        const struct shading shading = {.position = r->position, .normal = r->normal, .breadth = 1};
        const int pixel = i / s.look->samples;
        const struct path_place places[3] = {
            {pixel % STAGE_WIDTH, pixel / STAGE_WIDTH, .first = true},
            {.last = false},
            {.last = true}};
        for (int k = 0; k < 3; k++) {
            const struct proposal p = proposal_at(&guides, places[k], &shading);
            assert_true(p.bsdf_fraction >= MAP_LEAST_FRACTION - 1e-6f && p.bsdf_fraction <= 1);
            assert_true(p.light_chance > 0 && p.light_chance <= 1);
            guided += p.bsdf_fraction < 1;
        }
    }
    assert_true(guided > stage_records(s.look));
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_density_of_any_values_is_one_or_refused),
        cmocka_unit_test(test_maps_dont_depend_on_the_unit_of_light),
        cmocka_unit_test(test_learning_rules_no_direction_out),
        cmocka_unit_test(test_mixture_covers_the_bsdf),
    };
    omp_set_num_threads(1); /* for scenes so small threads cost more than they bring */
    return cmocka_run_group_tests(tests, NULL, NULL);
}
