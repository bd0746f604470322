/* SPDX-License-Identifier: Apache-2.0 */
/* Analytic spheres: when they are, their poles, and rays that leave them. */

#include "shape_stage.h"

static void test_stretched_sphere_becomes_a_mesh(void **state) {
    struct stage stage =
        stage_open("<shape type='sphere'><transform name='to_world'>"
                   "<scale x='2'/></transform></shape>"
                   "<shape type='sphere'><float name='radius' value='3'/></shape>");
    struct surface s;
    (void)state;
    assert_int_equal(stage.scene->meshes[0].kind, MESH_TRIANGLES);
    assert_int_equal(stage.scene->meshes[1].kind, MESH_SPHERE);
    assert_int_equal(stage.scene->meshes[1].triangle_count, 0);
    assert_near(stage.scene->meshes[1].sphere[3], 3, 0);
    assert_true(surface_trace(stage.world, vec(0, 0, 0), vec(1, 0, 0), false, &s));
    assert_near(s.position.x, 2, 1e-3);
    stage_close(&stage);
}

static void test_sphere_at_its_poles_is_finite(void **state) {
    struct stage stage = stage_open("<shape type='sphere'/>");
    struct surface s;
    (void)state;
    for (int side = -1; side <= 1; side += 2) {
        assert_true(surface_trace(stage.world, vec(0, 0, 3.0f * (float)side),
                                  vec(0, 0, -(float)side), false, &s));
        assert_near(s.v, side < 0, 0);
        assert_true(isfinite(s.u) && s.u >= 0 && s.u <= 1);
        assert_near(length(s.dp_du), 0, 0);
        assert_near(length(s.dp_dv), PI_F, 1e-5);
    }
    stage_close(&stage);
}

/* Rays that leave a sphere outwards never meet it again, and those that go inwards do at the other
 * side; how small, large or far away it may be. */
static void test_spheres_do_not_shadow_themselves(void **state) {
    static const struct {
        const char *center;
        struct vec3 c;
        float radius;
    } cases[] = {{"0,0,0", {0, 0, 0}, 1},
                 {"0,0,0", {0, 0, 0}, 0.01f},
                 {"0,-1e4,0", {0, -1e4f, 0}, 1e4f},
                 {"300,-200,100", {300, -200, 100}, 0.5f}};
    (void)state;
    for (size_t i = 0; i < COUNT(cases); i++) {
        char body[256];
        snprintf(body, sizeof(body),
                 "<shape type='sphere'><point name='center' value='%s'/>"
                 "<float name='radius' value='%g'/></shape>",
                 cases[i].center, cases[i].radius);
        struct stage stage = stage_open(body);
        for (int k = 0; k < 5000; k++) {
            struct surface s;
            struct vec3 away = any_direction(), d = any_direction();
            struct vec3 centre = sub(cases[i].c, scene_origin(stage.scene));
            struct vec3 from = add(centre, scale(away, 3 * cases[i].radius));
            if (!surface_trace(stage.world, from, negate(away), false, &s))
                fail_msg("the ray to the centre misses");
            if (k % 2) /* grazing */
                d = normalize(add(scale(d, 1), scale(s.normal, -dot(d, s.normal) * 0.9999f)));
            float side = dot(d, s.geometric_normal);
            bool blocked = surface_blocked_to_sky(stage.world, s.position, s.geometric_normal, d);
            if (side > 0)
                assert_false(blocked);
            else if (side < -0.05f)
                assert_true(blocked);
        }
        stage_close(&stage);
    }
}

static void test_segments_between_points_of_a_sphere(void **state) {
    struct stage stage = stage_open("<shape type='sphere'/>");
    (void)state;
    for (int k = 0; k < 1000; k++) {
        struct vec3 p = any_direction(), q = any_direction();
        if (dot(p, q) > 0.9f)
            continue;
        /* Inside from side to side; and from outside past it or through it. */
        assert_false(surface_blocked(stage.world, p, p, q));
        assert_true(surface_blocked(stage.world, scale(p, 3), p, scale(p, -3)));
    }
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stretched_sphere_becomes_a_mesh),
        cmocka_unit_test(test_sphere_at_its_poles_is_finite),
        cmocka_unit_test(test_spheres_do_not_shadow_themselves),
        cmocka_unit_test(test_segments_between_points_of_a_sphere),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
