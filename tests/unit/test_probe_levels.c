/* SPDX-License-Identifier: Apache-2.0 */
/* Probes of two levels: what the coarse ones tell the fine ones, and where they stand in. */

#include "tests/unit/probe_look.h"

/* Two fine voxels of one coarse voxel, and one of its neighbour. */
static const struct group here = {{0.125f, 0.125f, 0.125f}, {0, 1, 0}, 300, 0, 300};
static const struct group beside = {{-0.875f, 0.125f, 0.125f}, {0, 1, 0}, 300, 0, 300};
static const struct group elsewhere = {{2.625f, 0.125f, 0.125f}, {0, 1, 0}, 300, 0, 300};

/* The middles of two bins, equally high above the ground. */
static struct vec3 one_lamp(void) {
    return density_direction(3, 13, 0.5f, 0.5f, PROBE_SIZE);
}

static struct vec3 other_lamp(void) {
    struct vec3 d = one_lamp();
    return vec(-d.x, d.y, -d.z);
}

/* Lets the first `events` records of a group find a lamp, and sets all their normals upright, so
 * that densities don't differ by their cosine. */
static void light_group(struct scene *s, uint32_t group, int events, struct vec3 lamp) {
    for (int i = 0; i < s->look.width; i++) {
        s->look.records[i].second_normal = vec(0, 1, 0);
        if (s->group_of[i] == group && events-- > 0) {
            s->look.seconds[i].light = lamp;
            s->look.seconds[i].light_value = 3;
        }
    }
}

/* Three groups: `here` sees `events` of one lamp, `beside` 200 of the other; `elsewhere` is dark.
 */
static struct probes *make_three(struct scene *s, int events) {
    const struct group groups[] = {here, beside, elsewhere};
    scene_init(s, 900);
    for (int g = 0; g < 3; g++)
        for (int k = 0; k < groups[g].records; k++)
            add_record(s, &groups[g], (uint32_t)g, k);
    light_group(s, 0, events, one_lamp());
    light_group(s, 1, 200, other_lamp());
    return make_probes(s, 2);
}

static bool is_coarse(const struct probes *probes, const struct probe *p) {
    return p >= probes->coarse.probes && p < probes->coarse.probes + probes->coarse.voxels.count;
}

static double mass(const struct probe *p, struct vec3 d) {
    return probe_pdf(p, d) * 4 * (double)PI_F / PROBE_BINS;
}

static void test_probes_without_light_take_over_the_coarse_density(void **state) {
    (void)state;
    static struct scene s;
    struct probes *probes = make_three(&s, 0);
    assert_int_equal(probes->fine.voxels.count, 3);
    assert_int_equal(probes->coarse.voxels.count, 2);
    const struct probe *p = probe_of(probes, &here);
    const struct probe *coarse =
        &probes->coarse.probes[voxel_table_find(&probes->coarse.voxels, here.centre, here.normal)];
    assert_false(is_coarse(probes, p));
    assert_int_equal(coarse->records, 600);
    assert_true(p->bsdf_fraction < 1);
    assert_near(integral(p), 1, 1e-5);
    for (int b = 0; b < PROBE_BINS; b++)
        assert_near(p->density[b], coarse->density[b], 1e-5 * (1 + coarse->density[b]));
    assert_true(mass(p, other_lamp()) > 0.9);
    assert_true(p->light_chance < 1); /* its own shadow rays were all in vain */
    assert_near(probe_of(probes, &elsewhere)->bsdf_fraction, 1, 0);
    probes_destroy(&probes);
    scene_clear(&s);
}

/* The coarse voxel's light fades with the number of own events; it counts for 20. */
static void test_probes_follow_their_own_light_the_more_they_saw(void **state) {
    (void)state;
    const int events[] = {1, 5, 20, 200};
    double before = 0;
    for (int k = 0; k < 4; k++) {
        static struct scene s;
        struct probes *probes = make_three(&s, events[k]);
        const struct probe *p = probe_of(probes, &here), *q = probe_of(probes, &beside);
        double coarse_share = (double)events[k] / (events[k] + 200);
        double expected = (events[k] + 20 * coarse_share) / (events[k] + 20);
        double one = mass(p, one_lamp()), other = mass(p, other_lamp());
        assert_near(one / (one + other), expected, 0.02);
        assert_true(one + other > 0.9);
        assert_true(one > before);
        before = one;
        assert_true(mass(q, other_lamp()) > 0.85);
        probes_destroy(&probes);
        scene_clear(&s);
    }
    assert_true(before > 0.9);
}

static void test_the_coarse_probe_stands_in_for_small_voxels(void **state) {
    (void)state;
    const struct vec3 up = vec(0, 1, 0);
    for (int records = 0; records <= 6; records++) {
        static struct scene s;
        const struct group groups[] = {{here.centre, up, records, 2, records},
                                       {beside.centre, up, 4, 2, 4}};
        scene_init(&s, 16);
        add_groups(&s, groups, 2);
        struct probes *probes = make_probes(&s, 1);
        const struct probe *p = probe_of(probes, &groups[0]), *q = probe_of(probes, &groups[1]);
        if (records < 2) {
            assert_null(p); /* five records or fewer, in the coarse voxel as well */
            assert_null(q);
        } else {
            assert_true(is_coarse(probes, q));
            assert_int_equal(q->records, records + 4);
            assert_true(is_coarse(probes, p) == (records < 6));
            assert_int_equal(p->records, records < 6 ? records + 4 : 6);
        }
        probes_destroy(&probes);
        scene_clear(&s);
    }
}

/* Every fine voxel lies in one coarse voxel whole, on both sides of the origin. */
static void test_fine_voxels_do_not_straddle_coarse_ones(void **state) {
    (void)state;
    static struct scene s;
    scene_init(&s, 4096);
    for (int i = -12; i <= 12; i++) {
        struct group g = here;
        g.centre = vec(0.5f * (float)i, 0, 0);
        for (int k = 0; k < 40; k++) {
            add_record(&s, &g, (uint32_t)(i + 12), k);
            struct look_record *r = &s.look.records[s.look.width - 1];
            struct vec3 end =
                add(g.centre, scale(vec(uniform((uint32_t)k, 40) - 0.5f, 0, 0), 0.499f));
            r->position = sub(end, scale(r->direction, r->distance));
            r->second_normal = vec(0, 1, 0);
        }
    }
    struct probes *probes = make_probes(&s, 1);
    assert_int_equal(probes->fine.voxels.count, 25);
    assert_int_equal(probes->coarse.voxels.count, 5);
    for (int k = 0; k < 25; k++)
        assert_int_equal(probes->fine.probes[k].records, 40);
    for (int k = 0; k < 5; k++)
        assert_int_equal(probes->coarse.probes[k].records, 200);
    probes_destroy(&probes);
    scene_clear(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_probes_without_light_take_over_the_coarse_density),
        cmocka_unit_test(test_probes_follow_their_own_light_the_more_they_saw),
        cmocka_unit_test(test_the_coarse_probe_stands_in_for_small_voxels),
        cmocka_unit_test(test_fine_voxels_do_not_straddle_coarse_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
