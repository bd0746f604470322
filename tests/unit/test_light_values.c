/* SPDX-License-Identifier: Apache-2.0 */
/* Lights light as Mitsuba's emitters of the same parameters do; see
 * tests/mitsuba/generate_light_table.py. */

#include "tests/unit/mitsuba_table.h"

#include "guide/trace/sampler.h"

enum { SIDE = 128 }; /* of the grid of samples of each light that has a size */

static struct mitsuba_table table;

/* A scene of these lights, and a surface far away from the points. */
static void load(const json_t *entry, struct fewray_scene **scene, struct fewray_world **world) {
    FILE *file = table_begin_scene(&table);
    fprintf(file,
            "<shape type='rectangle'><transform name='to_world'><translate z='-50'/>"
            "</transform></shape>\n%s\n",
            table_string(entry, "xml"));
    table_end_scene(&table, file, scene, world);
}

static struct vec3 irradiance(const struct fewray_world *world, struct vec3 position,
                              struct vec3 normal) {
    struct vec3 sum = vec(0, 0, 0);
    for (uint32_t k = 0; k < SIDE * SIDE; k++) {
        const float u[2] = {((float)(k % SIDE) + 0.5f) / SIDE, ((float)(k / SIDE) + 0.5f) / SIDE};
        float pick = to_unit_float(hash_combine(7, k));
        struct light_sample s = lights_sample(world, position, normal, pick, u);
        float cos_theta = s.pdf > 0 ? dot(normal, s.direction) : 0;
        struct vec3 radiance = s.distant && !s.delta ? lights_sky(world, s.direction) : s.radiance;
        if (cos_theta > 0)
            sum = add(sum, scale(radiance, cos_theta / s.pdf));
    }
    return scale(sum, 1.0f / (SIDE * SIDE));
}

static void test_irradiance_equals_mitsubas(void **state) {
    (void)state;
    int wrong = 0;
    json_t *entry, *row;
    const json_t *points = json_object_get(table.root, "points");
    for (size_t i = 0; (entry = json_array_get(table.configurations, i)); i++) {
        struct fewray_scene *scene = NULL;
        struct fewray_world *world = NULL;
        load(entry, &scene, &world);
        bool delta = json_is_true(json_object_get(entry, "delta"));
        for (size_t k = 0; (row = json_array_get(json_object_get(entry, "irradiance"), k)); k++) {
            const json_t *point = json_array_get(points, k);
            struct vec3 value = irradiance(world, table_vector(point, 0), table_vector(point, 3));
            struct vec3 expected = table_vector(row, 0), difference = sub(value, expected);
            float tolerance = 0.015f * length(expected) + 1e-5f;
            if (delta ? !is_near_color(value, expected) : length(difference) > tolerance) {
                print_error("%s, point %zu: %g %g %g, Mitsuba has %g %g %g\n", case_name(entry), k,
                            value.x, value.y, value.z, expected.x, expected.y, expected.z);
                wrong++;
            }
        }
        fewray_world_destroy(&world);
        fewray_scene_destroy(&scene);
    }
    assert_int_equal(wrong, 0);
}

static void test_environment_equals_mitsubas(void **state) {
    (void)state;
    int wrong = 0;
    json_t *entry, *row;
    const json_t *directions = json_object_get(table.root, "directions");
    for (size_t i = 0; (entry = json_array_get(table.configurations, i)); i++) {
        struct fewray_scene *scene = NULL;
        struct fewray_world *world = NULL;
        load(entry, &scene, &world);
        for (size_t k = 0; (row = json_array_get(json_object_get(entry, "radiance"), k)); k++) {
            struct vec3 value = lights_sky(world, table_vector(json_array_get(directions, k), 0));
            struct vec3 expected = table_vector(row, 0);
            if (!is_near_color(value, expected)) {
                print_error("%s, direction %zu: %g %g %g, Mitsuba has %g %g %g\n", case_name(entry),
                            k, value.x, value.y, value.z, expected.x, expected.y, expected.z);
                wrong++;
            }
        }
        fewray_world_destroy(&world);
        fewray_scene_destroy(&scene);
    }
    assert_int_equal(wrong, 0);
}

static int open_table(void **state) {
    (void)state;
    table_open(&table, TEST_DATA "/mitsuba/lights.json");
    return 0;
}

static int close_table(void **state) {
    (void)state;
    table_close(&table);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_irradiance_equals_mitsubas),
        cmocka_unit_test(test_environment_equals_mitsubas),
    };
    return cmocka_run_group_tests(tests, open_table, close_table);
}
