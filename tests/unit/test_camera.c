/* SPDX-License-Identifier: Apache-2.0 */
/* Camera rays against those of Mitsuba 3.9.1's perspective and thinlens. */

#include "tests/unit/check.h"

#include "guide/trace/camera.h"

static struct camera camera_at(float x, float y, float z) {
    return (struct camera){.to_world = {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z},
                           .fov_x = PI_F / 3,
                           .width = 200,
                           .height = 100};
}

static const float middle[2] = {0, 0};

static void test_principal_point_moves_as_mitsubas(void **state) {
    (void)state;
    struct camera c = camera_at(0, 0, 0);
    c.principal_x = 0.1f;
    c.principal_y = 0.2f;
    /* x, y in shares of the picture; direction */
    const float expected[3][5] = {{0.25f, 0.25f, 0.17059506f, 0.02843254f, 0.9849309f},
                                  {0.5f, 0.5f, -0.11396053f, -0.11396052f, 0.98692757f},
                                  {0.9f, 0.1f, -0.4975185f, 0.09950373f, 0.8617275f}};
    for (int i = 0; i < 3; i++) {
        const float *e = expected[i];
        struct vec3 origin, d;
        camera_ray(&c, 200, 100, 200 * e[0], 100 * e[1], middle, &origin, &d);
        assert_near(length(sub(d, vec(e[2], e[3], e[4]))), 0, 1e-6);
    }
}

static void test_lens_rays_meet_in_the_plane_of_focus(void **state) {
    (void)state;
    struct camera c = camera_at(1, 2, 3), pinhole = c;
    c.aperture_radius = 0.5f;
    c.focus_distance = 3;
    struct vec3 centre = vec(1, 2, 3), sum = {0, 0, 0}, origin, d;
    camera_ray(&pinhole, 200, 100, 50, 25, middle, &origin, &d);
    struct vec3 focus = add(origin, scale(d, 3 / d.z));
    double squares = 0;
    enum { GRID = 32 };
    for (int i = 0; i < GRID * GRID; i++) {
        float lens[2] = {((float)(i / GRID) + 0.5f) / GRID, ((float)(i % GRID) + 0.5f) / GRID};
        camera_ray(&c, 200, 100, 50, 25, lens, &origin, &d);
        assert_near(length(d), 1, 1e-5);
        struct vec3 at = sub(origin, centre), hit = add(origin, scale(d, 3 / d.z));
        assert_near(length(sub(hit, focus)), 0, 1e-5);
        assert_near(at.z, 0, 1e-6);
        assert_true(length(at) <= 0.5f + 1e-6f);
        sum = add(sum, at);
        squares += dot(at, at);
    }
    /* Uniform over the disk: no mean, and half the squared radius. */
    assert_near(length(sum) / (GRID * GRID), 0, 1e-4);
    assert_near(squares / (GRID * GRID), 0.125, 1e-3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_principal_point_moves_as_mitsubas),
        cmocka_unit_test(test_lens_rays_meet_in_the_plane_of_focus),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
