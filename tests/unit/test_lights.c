/* SPDX-License-Identifier: Apache-2.0 */
/* Lights of every kind: irradiance against closed forms, and densities that match the samples. */

#include "light_stage.h"

/* --- lights without a surface */

static void test_point_falls_by_squared_distance(void **state) {
    (void)state;
    struct stage s;
    stage_start(&s);
    s.scene.light_count = 1;
    s.lights[0] = (struct light){.kind = LIGHT_POINT, .position = {3, 0, 4}, .intensity = radiance};
    stage_ready(&s);
    struct light_sample l = draw(&s, origin, up, 1, 0);
    assert_true(l.delta && !l.distant && l.pdf == 1);
    assert_irradiance(&s, origin, up, 0.8 / 25, 1e-4);
    l = draw(&s, s.lights[0].position, up, 1, 0);
    assert_true(l.pdf == 0);
    stage_end(&s);
}

static void test_spot_falls_linearly_in_the_angle(void **state) {
    (void)state;
    struct stage s;
    const double degree = PI_F / 180;
    stage_start(&s);
    s.scene.light_count = 1;
    s.lights[0] = (struct light){.kind = LIGHT_SPOT,
                                 .position = {0, 0, 2},
                                 .direction = {0, 0, -1},
                                 .intensity = radiance,
                                 .cutoff = (float)(40 * degree),
                                 .beam_width = (float)(20 * degree)};
    stage_ready(&s);
    for (double angle = 0; angle < 60; angle += 7) {
        struct vec3 from = vec((float)(2 * tan(angle * degree)), 0, 0);
        double c = cos(angle * degree), fall = fmin(1, fmax(0, (40 - angle) / 20));
        assert_irradiance(&s, from, up, fall * c * c * c / 4, 1e-4);
        assert_true((draw(&s, from, up, 1, 0).pdf > 0) == (angle < 40));
    }
    stage_end(&s);
}

static void test_directional_has_its_irradiance(void **state) {
    (void)state;
    struct stage s;
    stage_start(&s);
    s.scene.light_count = 1;
    s.lights[0] = (struct light){
        .kind = LIGHT_DIRECTIONAL, .direction = {-0.6f, 0, -0.8f}, .intensity = radiance};
    stage_ready(&s);
    struct light_sample l = draw(&s, origin, up, 1, 0);
    assert_true(l.delta && l.distant);
    assert_irradiance(&s, origin, up, 0.8, 1e-4);
    assert_true(lights_pdf_sky(&s.world, l.direction) == 0);
    assert_true(luminance(lights_sky(&s.world, l.direction)) == 0);
    stage_end(&s);
}

static void start_sun(struct stage *s, float half_angle) {
    stage_start(s);
    s->scene.light_count = 1;
    s->lights[0] = (struct light){.kind = LIGHT_SUN,
                                  .direction = {0.6f, 0, 0.8f},
                                  .intensity = radiance,
                                  .cutoff = half_angle};
}

static void test_sun_fills_its_cone(void **state) {
    (void)state;
    const float halves[] = {0.0047f, 0.2f};
    for (int k = 0; k < 2; k++) {
        struct stage s;
        start_sun(&s, halves[k]);
        stage_ready(&s);
        double sine = sin(halves[k]);
        assert_irradiance(&s, origin, up, PI_F * sine * sine * 0.8, 0.005);
        struct vec3 across = vec(-0.8f, 0, 0.6f), axis = s.lights[0].direction;
        struct vec3 inside = normalize(add(axis, scale(across, tanf(0.99f * halves[k])))),
                    outside = normalize(add(axis, scale(across, tanf(1.01f * halves[k]))));
        double solid_angle = 4 * PI_F * pow(sin(0.5 * halves[k]), 2);
        assert_near(lights_pdf_sky(&s.world, inside) * solid_angle, 1, 1e-4);
        assert_true(lights_pdf_sky(&s.world, outside) == 0);
        assert_near(lights_sky(&s.world, inside).y, radiance.y, 0);
        assert_near(lights_sky(&s.world, outside).y, 0, 0);
        stage_end(&s);
    }
}

/* The sky's and the sun's techniques share one density, which integrates to one with the lamp. */
static void test_sun_and_sky_share_their_density(void **state) {
    (void)state;
    struct stage s;
    start_sun(&s, 0.2f);
    s.scene.environment = (struct environment){.kind = ENVIRONMENT_CONSTANT, .radiance = {1, 1, 1}};
    stage_ready(&s);
    double sine = sin(0.2);
    struct vec3 e = irradiance(&s, origin, up);
    assert_near(e.x, PI_F + 2 * PI_F * sine * sine * 0.8, 0.06);
    for (uint32_t i = 0; i < 200; i++) {
        struct light_sample l = draw(&s, origin, up, 2, i);
        assert_near(lights_pdf_sky(&s.world, l.direction) / l.pdf, 1, 1e-5);
    }
    double sum = 0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        float u[2] = {uniform(3, 2 * i), uniform(3, 2 * i + 1)};
        struct vec3 d = uniform_hemisphere(u);
        sum += lights_pdf_sky(&s.world, d) * 2 * PI_F / SAMPLES;
    }
    double sky = s.world.lights.distant[0].chance, sun = s.world.lights.distant[1].chance;
    assert_near(sky + sun, 1, 1e-6);
    assert_true(sky > 0.2 && sun > 0.2);
    assert_near(sum, 0.5 * sky + sun, 0.05);
    stage_end(&s);
}

/* --- surfaces */

static void test_sphere_has_its_form_factor(void **state) {
    (void)state;
    struct stage s;
    const float distances[] = {1.02f, 1.5f, 5, 1000};
    for (int k = 0; k < 4; k++) {
        struct vec3 axis = k == 0 ? up : vec(0.6f, 0, 0.8f);
        stage_start(&s);
        add_sphere(&s, axis.x * distances[k], 0, axis.z * distances[k], k == 1 ? 0.5f : 1);
        stage_ready(&s);
        double ratio = s.meshes[0].sphere[3] / distances[k];
        assert_irradiance(&s, origin, up, PI_F * ratio * ratio * axis.z, 0.01);
        /* The hit along each direction has the sample's density. */
        for (uint32_t i = 0; i < 100; i++) {
            struct light_sample l = draw(&s, origin, up, 5, i);
            struct vec3 to = sub(l.position, scale(axis, distances[k]));
            assert_near(length(to), s.meshes[0].sphere[3], 1e-4 * distances[k]);
            struct surface hit = {.mesh = &s.meshes[0], .distance = length(l.position)};
            hit.geometric_normal = hit.normal = normalize(to);
            assert_near(lights_pdf_hit(&s.world, origin, up, l.direction, &hit) / l.pdf, 1, 1e-4);
        }
        stage_end(&s);
    }
}

static void test_sphere_lights_its_inside_where_it_is_turned(void **state) {
    (void)state;
    struct stage s;
    stage_start(&s);
    add_sphere(&s, 0, 0.2f, -0.1f, 1);
    stage_ready(&s);
    assert_irradiance(&s, origin, up, 0, 0);
    stage_end(&s);
    s.meshes[0].flip_normals = true;
    stage_ready(&s);
    assert_irradiance(&s, origin, up, PI_F, 0.02);
    assert_irradiance(&s, vec(0, 0, 3), vec(0, 0, -1), 0, 0);
    stage_end(&s);
}

/* Irradiance over radiance of a polygon that is wholly above the surface: Lambert 1760. */
static double polygon_form(const struct vec3 *p, int n, struct vec3 normal) {
    double sum = 0;
    for (int i = 0; i < n; i++) {
        struct vec3 a = normalize(p[i]), b = normalize(p[(i + 1) % n]), c = cross(a, b);
        sum += atan2(length(c), dot(a, b)) * dot(normalize(c), normal) / 2;
    }
    return fabs(sum);
}

static void assert_hits_have_the_samples_density(const struct stage *s, struct vec3 from,
                                                 struct vec3 normal) {
    for (uint32_t i = 0; i < 300; i++) {
        struct light_sample l = draw(s, from, normal, 7, i);
        if (!(l.pdf > 0) || l.distant || l.delta)
            continue;
        for (int m = 0; m < s->scene.mesh_count; m++) {
            const float *p = s->meshes[m].positions;
            if (!p || fabsf(l.position.z - p[2]) > 1e-5f)
                continue;
            struct surface hit = {.mesh = &s->meshes[m], .mesh_index = (uint32_t)m};
            hit.distance = length(sub(l.position, from));
            hit.geometric_normal = hit.normal = vec(0, 0, -1);
            float pdf = lights_pdf_hit(&s->world, from, normal, l.direction, &hit);
            hit.triangle = s->meshes[m].triangle_count - 1;
            float other = lights_pdf_hit(&s->world, from, normal, l.direction, &hit);
            assert_near(fmin(fabs(pdf / l.pdf - 1), fabs(other / l.pdf - 1)), 0, 1e-4);
        }
    }
}

static void test_triangle_has_its_form_factor(void **state) {
    (void)state;
    struct stage s;
    float p[] = {-0.5f, 0.2f, 1, 0.8f, 0.9f, 1, 0.4f, -1, 1};
    stage_start(&s);
    add_triangles(&s, p, NULL, 1);
    stage_ready(&s);
    struct vec3 corners[3] = {vec(p[0], p[1], p[2]), vec(p[3], p[4], p[5]), vec(p[6], p[7], p[8])};
    struct vec3 normal = normalize(vec(0.1f, 0.2f, 1));
    assert_irradiance(&s, origin, normal, polygon_form(corners, 3, normal), 0.01);
    assert_irradiance(&s, vec(0, 0, 2), vec(0, 0, -1), 0, 0); /* its back is dark */
    assert_hits_have_the_samples_density(&s, origin, normal);
    stage_end(&s);
}

/* Two triangles with a picture that is dark but for one bright texel. */
static void test_textured_emitter_shines_by_its_picture(void **state) {
    (void)state;
    struct stage s;
    float p[] = {-1, 1, 1, 1, 1, 1, 1, -1, 1, -1, -1, 1};
    float uvs[] = {0, 0, 1, 0, 1, 1, 0, 1}, texels[4 * 4 * 3] = {0};
    struct fewray_image image = {.width = 4, .height = 4, .channels = 3, .floats = texels};
    for (int c = 0; c < 3; c++)
        texels[3 * 3 + c] = 100; /* the first row's last: in the first triangle */
    stage_start(&s);
    add_triangles(&s, p, uvs, 2);
    s.textures[0].kind = TEXTURE_BITMAP;
    s.textures[0].image = &image;
    s.textures[0].channel = -1;
    s.textures[0].factor = vec(1, 1, 1);
    s.textures[0].nearest = true;
    stage_ready(&s);
    struct light_source *sources = s.world.lights.sources;
    assert_true(sources[0].chance > 0.9f && sources[1].chance > 0);
    assert_near(sources[0].chance + sources[1].chance, 1, 1e-6);
    double expected = 0;
    for (int k = 0; k < 64; k++) {
        double x = 0.5 + 0.5 * (k / 8 + 0.5) / 8, y = 0.5 + 0.5 * (k % 8 + 0.5) / 8;
        double d2 = x * x + y * y + 1;
        expected += 100 * 0.25 / 64 / (d2 * d2);
    }
    assert_near(irradiance(&s, origin, up).y, expected, 0.08 * expected);
    assert_hits_have_the_samples_density(&s, origin, up);
    stage_end(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_point_falls_by_squared_distance),
        cmocka_unit_test(test_spot_falls_linearly_in_the_angle),
        cmocka_unit_test(test_directional_has_its_irradiance),
        cmocka_unit_test(test_sun_fills_its_cone),
        cmocka_unit_test(test_sun_and_sky_share_their_density),
        cmocka_unit_test(test_sphere_has_its_form_factor),
        cmocka_unit_test(test_sphere_lights_its_inside_where_it_is_turned),
        cmocka_unit_test(test_triangle_has_its_form_factor),
        cmocka_unit_test(test_textured_emitter_shines_by_its_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
