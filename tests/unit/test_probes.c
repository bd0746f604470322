/* SPDX-License-Identifier: Apache-2.0 */
/* Probes from made-up looks: what they pool, where they are found, and their densities. */

#include "tests/unit/probe_look.h"

#include <string.h>

static const struct group floor_lit = {{PLACE(0), PLACE(-1), PLACE(2)}, {0, 1, 0}, 64, 40, 64};
static const struct group wall_lit = {{PLACE(0), PLACE(-1), PLACE(2)}, {-1, 0, 0}, 50, 50, 50};
static const struct group floor_dark = {{PLACE(1), PLACE(-1), PLACE(2)}, {0, 1, 0}, 40, 0, 16};
static const struct group floor_hardly_seen = {
    {PLACE(2), PLACE(-1), PLACE(2)}, {0, 1, 0}, 40, 0, 15};
static const struct group floor_six = {{PLACE(3), PLACE(-1), PLACE(2)}, {0, 1, 0}, 6, 2, 6};
static const struct group floor_five = {{PLACE(4), PLACE(-1), PLACE(2)}, {0, 1, 0}, 5, 2, 5};

static struct probes *make_six_groups(struct scene *s) {
    const struct group groups[] = {floor_lit,         wall_lit,  floor_dark,
                                   floor_hardly_seen, floor_six, floor_five};
    scene_init(s, 400);
    add_groups(s, groups, 6);
    struct probes *probes = make_probes(s, 2);
    assert_near(probes->fine.voxels.side, 0.5, 1e-6);
    assert_int_equal(probes->fine.voxels.count, 6);
    return probes;
}

/* Where no fine probe stands the coarse one around answers, but never one of another side. */
static void test_lookup_is_by_place_and_side(void **state) {
    (void)state;
    static struct scene s;
    struct probes *probes = make_six_groups(&s);
    const struct group *known[] = {&floor_lit, &wall_lit, &floor_dark, &floor_hardly_seen,
                                   &floor_six};
    const int around[] = {64, 50, 40 + 40, 40 + 40, 6 + 5}; /* records in the coarse voxel */
    for (int i = 0; i < 5; i++) {
        const struct vec3 centre = known[i]->centre, normal = known[i]->normal;
        const struct probe *p = probe_of(probes, known[i]);
        assert_non_null(p);
        assert_int_equal(p->records, known[i]->records);
        assert_near(length(p->normal), 1, 1e-5);
        assert_true(dot(p->normal, normal) > 0.99f);
        assert_null(probes_at(probes, centre, negate(normal)));
        assert_null(probes_at(probes, centre, vec(0, 0, 1)));
        const struct probe *beside = probes_at(probes, add(centre, vec(0, 0, -1)), normal);
        assert_non_null(beside);
        assert_int_equal(beside->records, around[i]);
        assert_ptr_equal(probes_at(probes, add(centre, vec(0, -1, 0)), normal), beside);
        assert_null(probes_at(probes, add(centre, vec(0, 0, 2.5f)), normal));
        assert_null(probes_at(probes, add(centre, vec(0, 2.5f, 0)), normal));
        assert_null(probes_at(probes, add(centre, vec(12.5f, 0, 0)), normal));
    }
    assert_null(probes_at(probes, vec(NAN, INFINITY, -1e38f), vec(NAN, 0, 1)));
    probes_destroy(&probes);
    assert_null(probes);
    scene_clear(&s);
}

static void test_density_concentrates_on_the_light(void **state) {
    (void)state;
    static struct scene s;
    struct probes *probes = make_six_groups(&s);
    const struct group *lit[] = {&floor_lit, &wall_lit};
    for (int i = 0; i < 2; i++) {
        const struct probe *p = probe_of(probes, lit[i]);
        assert_near(integral(p), 1, 1e-5);
        assert_true(p->bsdf_fraction < 1 && p->bsdf_fraction > 0);
        assert_near(p->light_chance, 1, 0);
        double in_bin = (double)probe_pdf(p, sun_direction()) * 4 * (double)PI_F / PROBE_BINS;
        assert_true(in_bin > 0.85 && in_bin < 1);
        assert_near(probe_pdf(p, negate(lit[i]->normal)), 0, 0);
        /* Nothing above the horizon is ruled out. */
        for (int b = 0; b < PROBE_BINS; b++) {
            struct vec3 d =
                density_direction(b / PROBE_SIZE, b % PROBE_SIZE, 0.5f, 0.5f, PROBE_SIZE);
            assert_true(!(dot(d, p->normal) > 0) || probe_pdf(p, d) > 0);
        }
    }
    const struct probe *dark = probe_of(probes, &floor_dark),
                       *hardly_seen = probe_of(probes, &floor_hardly_seen);
    assert_near(dark->bsdf_fraction, 1, 0);
    assert_true(dark->light_chance < 1 && dark->light_chance >= 0.1f);
    assert_near(hardly_seen->bsdf_fraction, 1, 0);
    assert_near(hardly_seen->light_chance, 1, 0);
    probes_destroy(&probes);
    scene_clear(&s);
}

/* Light that only the bounces found guides as well, and makes shadow rays worth their while. */
static void test_bounces_count_as_light(void **state) {
    (void)state;
    static struct scene s;
    scene_init(&s, 64);
    add_groups(&s, &floor_dark, 1);
    struct vec3 lamp = density_direction(2, 5, 0.5f, 0.5f, PROBE_SIZE);
    for (int i = 0; i < 20; i++) {
        s.look.seconds[i].bounce = around(lamp, 0.05f, (uint32_t)i, 30);
        s.look.seconds[i].bounce_value = 2;
    }
    struct probes *probes = make_probes(&s, 1);
    const struct probe *p = probe_of(probes, &floor_dark);
    assert_true(p->bsdf_fraction < 1);
    assert_near(p->light_chance, 1, 0);
    assert_true((double)probe_pdf(p, lamp) * 4 * (double)PI_F / PROBE_BINS > 0.8);
    probes_destroy(&probes);
    scene_clear(&s);
}

static void test_samples_follow_pdf(void **state) {
    (void)state;
    static struct scene s;
    struct probes *probes = make_six_groups(&s);
    const struct probe *p = probe_of(probes, &floor_six);
    double observed[PROBE_BINS] = {0}, expected[PROBE_BINS];
    const int n = 1 << 16;
    for (int b = 0; b < PROBE_BINS; b++)
        expected[b] = (double)probe_pdf(p, density_direction(b / PROBE_SIZE, b % PROBE_SIZE, 0.5f,
                                                             0.5f, PROBE_SIZE)) *
                      4 * (double)PI_F / PROBE_BINS * n;
    for (uint32_t i = 0; i < (uint32_t)n; i++) {
        struct vec3 d = probe_sample(p, (float[2]){uniform(i, 50), uniform(i, 51)});
        assert_near(length(d), 1, 1e-5);
        assert_true(probe_pdf(p, d) > 0);
        observed[density_bin(d, PROBE_SIZE)]++;
    }
    int degrees;
    assert_true(chi_square(observed, expected, PROBE_BINS, &degrees) < chi_square_limit(degrees));
    assert_true(degrees > 60);
    probes_destroy(&probes);
    scene_clear(&s);
}

/* The last group is too small for a probe: the coarse one, over the last two, stands in. */
static bool pooled_with(const struct scene *s, int i, int k) {
    return s->group_of[k] == s->group_of[i] || (s->group_of[i] == 5 && s->group_of[k] == 4);
}

/* Each record gets its own emission and its albedo's share of what its group reflects. */
static void test_records_get_their_groups_averages(void **state) {
    (void)state;
    static struct scene s;
    struct probes *probes = make_six_groups(&s);
    for (int i = 0; i < s.look.width; i++) {
        const struct look_record *r = &s.look.records[i];
        double mean = 0, moment = 0, n = 0;
        for (int k = 0; k < s.look.width; k++)
            if (pooled_with(&s, i, k)) {
                double v = r->emitted + (double)s.look.seconds[i].albedo *
                                            s.look.records[k].reflected / s.look.seconds[k].albedo;
                mean += v;
                moment += v * v;
                n++;
            }
        assert_near(r->mean, mean / n, 2e-5 * (1 + mean / n));
        assert_near(r->moment, sqrt(moment / n), 2e-5 * (1 + sqrt(moment / n)));
    }
    probes_destroy(&probes);
    scene_clear(&s);
}

static void test_looks_without_second_vertices(void **state) {
    (void)state;
    static struct scene s;
    scene_init(&s, 64);
    struct probes *probes = make_probes(&s, 2); /* no records at all */
    assert_int_equal(probes->fine.voxels.count, 0);
    probes_destroy(&probes);
    add_groups(&s, &floor_lit, 1);
    for (int i = 0; i < s.look.width; i++) { /* all bounces miss: they see the sky alone */
        s.look.records[i].distance = 0;
        s.look.records[i].reflected = 0;
        s.look.records[i].emitted = (float)i;
        s.look.seconds[i] = (struct look_second){.albedo = 0};
    }
    probes = make_probes(&s, 2);
    for (int i = 0; i < s.look.width; i++) {
        assert_near(s.look.records[i].mean, i, 0);
        assert_near(s.look.records[i].moment, i, 0);
    }
    probes_destroy(&probes);
    memset(s.look.records, 0, 64 * sizeof(*s.look.records)); /* the camera sees nothing */
    probes = make_probes(&s, 2);
    assert_null(probes_at(probes, vec(0, 0, 0), vec(0, 1, 0)));
    probes_destroy(&probes);
    scene_clear(&s);
}

static void assert_safe(const struct probes *probes) {
    for (int k = 0; k < probes->fine.voxels.count; k++) {
        const struct probe *p = &probes->fine.probes[k];
        assert_true(p->bsdf_fraction > 0 && p->bsdf_fraction <= 1);
        assert_true(p->light_chance > 0 && p->light_chance <= 1);
        if (!(p->bsdf_fraction < 1))
            continue;
        assert_near(integral(p), 1, 1e-4);
        for (uint32_t i = 0; i < 50; i++) {
            struct vec3 d = probe_sample(p, (float[2]){uniform(i, 60), uniform(i, 61)});
            assert_near(length(d), 1, 1e-5);
            assert_true(probe_pdf(p, d) > 0);
        }
    }
}

static void test_bad_values_are_safe(void **state) {
    (void)state;
    const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f, -1, 1e-40f};
    for (int b = 0; b < 6; b++)
        for (int field = 0; field < 6; field++)
            for (int step = 1; step < 8; step += 6) { /* all records, or some */
                static struct scene s;
                const struct group groups[] = {floor_lit, wall_lit, floor_dark};
                scene_init(&s, 400);
                add_groups(&s, groups, 3);
                for (int i = 0; i < s.look.width; i += step) {
                    struct look_record *r = &s.look.records[i];
                    struct look_second *second = &s.look.seconds[i];
                    float *fields[] = {&second->light_value, &second->bounce_value, &r->reflected,
                                       &r->position.x,       &r->second_normal.y,   &r->emitted};
                    *fields[field] = bad[b];
                }
                struct probes *probes = make_probes(&s, 1);
                assert_safe(probes);
                if (step > 1 && !isfinite(bad[b])) { /* the good ones count on */
                    assert_true(field > 1 || probe_of(probes, &floor_lit)->bsdf_fraction < 1);
                    assert_true(field > 2 || isfinite(s.look.records[1].mean));
                }
                probes_destroy(&probes);
                scene_clear(&s);
            }
}

/* A scene that lies a million units off: its voxels stay apart. */
static void test_far_away_scenes_have_probes(void **state) {
    (void)state;
    static struct scene s;
    const struct vec3 offsets[] = {{1e6f, 0, 0}, {0, -1e6f, 1e6f}};
    for (int k = 0; k < 2; k++) {
        struct group groups[] = {floor_lit, floor_dark};
        scene_init(&s, 400);
        for (int g = 0; g < 2; g++)
            groups[g].centre = add(groups[g].centre, offsets[k]);
        add_groups(&s, groups, 2);
        struct probes *probes = make_probes(&s, 1);
        assert_safe(probes);
        const struct probe *lit = probe_of(probes, &groups[0]),
                           *dark = probe_of(probes, &groups[1]);
        assert_true(lit && dark && lit != dark);
        assert_true(lit->bsdf_fraction < 1 && !(dark->bsdf_fraction < 1));
        probes_destroy(&probes);
        scene_clear(&s);
    }
}

/* Six records in each of so many voxels that the table grows several times. */
enum { SIDE = 105 };

static struct group grid_group(int i) {
    struct group g = floor_six;
    g.centre.x = PLACE((float)(i % SIDE - SIDE / 2));
    g.centre.z = PLACE((float)(i / SIDE - SIDE / 2));
    g.lit = i % 3;
    return g;
}

static void add_grid(struct scene *s) {
    scene_init(s, 6 * SIDE * SIDE);
    for (int k = 0; k < 6; k++)
        for (int i = 0; i < SIDE * SIDE; i++) {
            struct group g = grid_group(i);
            add_record(s, &g, (uint32_t)i, k);
        }
}

/* Light found by any group of a coarse voxel lights all its groups; here columns are alike. */
static bool lit_around(const struct group *g) {
    bool lit = false;
    for (int i = 0; i < SIDE; i++) {
        struct group other = grid_group(i);
        lit |= other.lit && coarse_cell(other.centre.x) == coarse_cell(g->centre.x);
    }
    return lit;
}

static void assert_same_bits(const struct probe_level *a, const struct probe_level *b) {
    assert_int_equal(a->voxels.count, b->voxels.count);
    for (int k = 0; k < a->voxels.count; k++) {
        const struct probe *p = &a->probes[k], *q = &b->probes[k];
        assert_int_equal(p->records, q->records);
        assert_memory_equal(&p->bsdf_fraction, &q->bsdf_fraction, 4 * sizeof(float));
        if (p->bsdf_fraction < 1)
            assert_memory_equal(p->density, q->density, sizeof(p->density));
    }
}

static void test_many_voxels_and_same_bits_on_any_number_of_threads(void **state) {
    (void)state;
    static struct scene one, three;
    add_grid(&one), add_grid(&three);
    struct probes *a = make_probes(&one, 1), *b = make_probes(&three, 3);
    assert_int_equal(a->fine.voxels.count, SIDE * SIDE);
    int lit = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        struct group g = grid_group(i);
        const struct probe *p = probe_of(a, &g);
        assert_true(p && p->records == 6);
        assert_true((p->bsdf_fraction < 1) == lit_around(&g));
        lit += lit_around(&g);
    }
    assert_true(lit > SIDE * SIDE / 2 && lit < SIDE * SIDE);
    assert_same_bits(&a->fine, &b->fine);
    assert_same_bits(&a->coarse, &b->coarse);
    assert_memory_equal(one.look.records, three.look.records,
                        (size_t)one.look.width * sizeof(*one.look.records));
    probes_destroy(&a), probes_destroy(&b);
    scene_clear(&one), scene_clear(&three);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lookup_is_by_place_and_side),
        cmocka_unit_test(test_density_concentrates_on_the_light),
        cmocka_unit_test(test_bounces_count_as_light),
        cmocka_unit_test(test_samples_follow_pdf),
        cmocka_unit_test(test_records_get_their_groups_averages),
        cmocka_unit_test(test_looks_without_second_vertices),
        cmocka_unit_test(test_bad_values_are_safe),
        cmocka_unit_test(test_far_away_scenes_have_probes),
        cmocka_unit_test(test_many_voxels_and_same_bits_on_any_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
