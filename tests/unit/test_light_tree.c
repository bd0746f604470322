/* SPDX-License-Identifier: Apache-2.0 */
/* The tree that picks among many lights: its chances, and that it loses none. */

#include "light_stage.h"

/* Many small triangles of random place, direction and size, and two point lights. */
static void start_crowd(struct stage *s, float *p, uint32_t *indices, uint32_t n) {
    stage_start(s);
    for (uint32_t i = 0; i < 9 * n; i++) {
        indices[i / 3] = i / 3;
        float size = 0.02f + 0.3f * uniform(12, i / 9);
        p[i] = 4 * uniform(10, i / 9 * 3 + i % 3) - 2 + size * uniform(11, i);
    }
    add_triangles(s, p, NULL, n);
    s->meshes[0].indices = indices;
    s->meshes[0].vertex_count = 3 * n;
    s->scene.light_count = 2;
    for (int i = 0; i < 2; i++)
        s->lights[i] = (struct light){.kind = i ? LIGHT_SPOT : LIGHT_POINT,
                                      .position = {(float)i, 0.3f, 0.4f},
                                      .direction = {0, 0, -1},
                                      .intensity = {0.1f, 0.1f, 0.1f},
                                      .cutoff = 0.7f,
                                      .beam_width = 0.4f};
    stage_ready(s);
}

enum { CROWD = 300 };

static void test_chances_of_a_tree_sum_to_one(void **state) {
    (void)state;
    static float p[9 * CROWD + 1];
    static uint32_t indices[3 * CROWD];
    struct stage s;
    start_crowd(&s, p, indices, CROWD);
    const struct light_tree *tree = &s.world.lights.tree;
    assert_true(tree->node_count > CROWD / 4);
    for (uint32_t k = 0; k < 50; k++) {
        struct vec3 from = vec(6 * uniform(20, 3 * k) - 3, 6 * uniform(20, 3 * k + 1) - 3,
                               6 * uniform(20, 3 * k + 2) - 3);
        float u[2] = {uniform(21, 2 * k), uniform(21, 2 * k + 1)};
        struct vec3 normal = k % 3 == 0 ? vec(0, 0, 0) : uniform_hemisphere(u);
        double sum = 0, lost = 0;
        for (uint32_t i = 0; i < CROWD + 2; i++)
            sum += light_tree_chance(tree, from, normal, i);
        for (uint32_t i = 0; i < 1000; i++) {
            uint32_t light;
            float chance = light_tree_pick(tree, from, normal, ((float)i + 0.5f) / 1000, &light);
            lost += !(chance > 0) * 1e-3;
            if (chance > 0)
                assert_near(light_tree_chance(tree, from, normal, light) / chance, 1, 1e-4);
        }
        /* Where a cluster can't be ruled out though its lights can, the pick is lost. */
        assert_near(sum + lost, 1, 0.02);
        for (uint32_t i = 0; i < CROWD + 2; i++) {
            float half[2] = {0.4f, 0.5f};
            const struct light_source *source = &s.world.lights.sources[i];
            if (light_tree_chance(tree, from, normal, i) > 0)
                continue;
            if (source->kind == SOURCE_TRIANGLE) {
                struct surface hit = {.mesh = &s.meshes[0], .triangle = source->triangle};
                const float *q = p + 9 * source->triangle;
                struct vec3 a = vec(q[0], q[1], q[2]), b = vec(q[3], q[4], q[5]),
                            c = vec(q[6], q[7], q[8]);
                struct vec3 at = add(scale(a, 1 - half[0]), scale(add(b, c), half[0] * half[1]));
                struct vec3 to = normalize(sub(at, from));
                hit.geometric_normal = normalize(cross(sub(b, a), sub(c, a)));
                bool faces = dot(hit.geometric_normal, to) < -1e-3f;
                bool above = dot(normal, normal) == 0 || dot(normal, to) > 1e-3f;
                assert_false(faces && above);
            }
        }
    }
    stage_end(&s);
}

/* The tree's irradiance is that of all lights one by one. */
static void test_tree_keeps_the_irradiance(void **state) {
    (void)state;
    static float p[9 * CROWD + 1];
    static uint32_t indices[3 * CROWD];
    struct stage s, one;
    start_crowd(&s, p, indices, CROWD);
    struct vec3 from = vec(0.5f, -2.5f, 0.1f), normal = vec(0, 1, 0);
    double expected = 0;
    enum { GRID = 8 };
    for (uint32_t i = 0; i < CROWD; i++) {
        const float *q = p + 9 * i;
        struct vec3 a = vec(q[0], q[1], q[2]), e1 = sub(vec(q[3], q[4], q[5]), a),
                    e2 = sub(vec(q[6], q[7], q[8]), a), n = cross(e1, e2);
        for (int k = 0; k < GRID * GRID; k++) {
            float root = sqrtf(((float)(k / GRID) + 0.5f) / GRID),
                  v = ((float)(k % GRID) + 0.5f) / GRID;
            struct vec3 to = sub(add(a, add(scale(e1, 1 - root), scale(e2, v * root))), from);
            double d2 = dot(to, to), c = dot(normal, to), facing = -dot(n, to) / 2;
            if (c > 0 && facing > 0)
                expected += radiance.y * c * facing / (d2 * d2) / (GRID * GRID);
        }
    }
    for (int i = 0; i < 2; i++) {
        stage_start(&one);
        one.scene.light_count = 1;
        one.lights[0] = s.lights[i];
        stage_ready(&one);
        expected += irradiance(&one, from, normal).y;
        stage_end(&one);
    }
    assert_near(irradiance(&s, from, normal).y, expected, 0.03 * expected);
    stage_end(&s);
}

/* Lights whose power, or whose distance from each other, is beyond floats when taken together:
 * costs that are no numbers. Each light must still get a leaf of its own. */
static void test_sums_beyond_floats_are_split_too(void **state) {
    (void)state;
    enum { COUNT = 9 };
    for (int far = 0; far < 2; far++) {
        struct light_bounds bounds[COUNT];
        struct light_tree tree;
        bool taken[4 * COUNT] = {false};
        for (int i = 0; i < COUNT; i++) {
            const float x = far ? (i % 2 ? 3e38f : -3e38f) : 1;
            bounds[i] = light_bounds_none();
            bounds[i].low = bounds[i].high = vec(x, 0, 0);
            bounds[i].axis = up;
            bounds[i].phi = 3e38f;
        }
        assert_int_equal(light_tree_create(bounds, COUNT, &tree, NULL), FEWRAY_OK);
        assert_true(tree.node_count < COUNT);
        for (int i = 0; i < COUNT; i++) {
            assert_true(tree.leaf[i] < 4 * COUNT && !taken[tree.leaf[i]]);
            taken[tree.leaf[i]] = true;
        }
        light_tree_clear(&tree);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_chances_of_a_tree_sum_to_one),
        cmocka_unit_test(test_tree_keeps_the_irradiance),
        cmocka_unit_test(test_sums_beyond_floats_are_split_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
