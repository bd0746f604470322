/* SPDX-License-Identifier: Apache-2.0 */
/* Materials evaluate to what Mitsuba's plugins of the same parameters do. */

#include "tests/unit/bsdf_cases.h"

static bool check_value(const json_t *entry, size_t i) {
    const json_t *point = json_array_get(cases.points, i);
    const json_t *row = json_array_get(json_object_get(entry, "values"), i);
    struct vec3 outgoing = table_vector(point, 0), incident = table_vector(point, 3);
    struct shading shading =
        case_shading(entry, outgoing, (float)table_number(point, 6), (float)table_number(point, 7));
    struct vec3 direction = to_world(&cases.frame, incident);
    struct vec3 value = bsdf_times_cosine(&shading, direction), expected = table_vector(row, 0);
    double pdf = bsdf_pdf(&shading, direction);
    double expected_pdf = table_number(row, 3);
    /* How often a direction without light is drawn is of no consequence; and tables steer how often
     * a plastic's coat is. */
    bool same =
        is_near_color(value, expected) && (fabs(pdf - expected_pdf) <= 5e-3 * expected_pdf + 2e-5 ||
                                           (max_component(expected) == 0 && pdf == 0));
    if (!same)
        print_error("%s, point %zu (%.3f %.3f %.3f) <- (%.3f %.3f %.3f): %.6g %.6g %.6g pdf %.6g, "
                    "Mitsuba has %.6g %.6g %.6g pdf %.6g\n",
                    case_name(entry), i, outgoing.x, outgoing.y, outgoing.z, incident.x, incident.y,
                    incident.z, value.x, value.y, value.z, pdf, expected.x, expected.y, expected.z,
                    expected_pdf);
    return same;
}

static void test_values_and_densities_equal_mitsubas(void **state) {
    (void)state;
    int wrong = 0;
    json_t *entry, *row;
    for (size_t i = 0; (entry = json_array_get(cases.table.configurations, i)); i++)
        for (size_t k = 0; (row = json_array_get(json_object_get(entry, "values"), k)); k++) {
            wrong += !check_value(entry, k);
        }
    assert_int_equal(wrong, 0);
}

#define MOST_DELTAS 8

/* The perfectly specular directions that bsdf_sample() draws, each once. */
static int find_deltas(const struct shading *shading, struct bsdf_sample *out) {
    const float u[2] = {0.3f, 0.6f};
    int count = 0;
    for (int k = 0; k < 256; k++) {
        struct bsdf_sample sample;
        float choice = ((float)k + 0.5f) / 256 * shading->delta_chance;
        if (!(choice < shading->delta_chance) || !bsdf_sample(shading, choice, u, &sample))
            continue;
        assert_true(sample.delta);
        bool known = !(max_component(sample.weight) > 0);
        for (int j = 0; j < count && !known; j++)
            known = length(sub(sample.direction, out[j].direction)) < 1e-3f;
        if (!known && count < MOST_DELTAS)
            out[count++] = sample;
    }
    return count;
}

static bool check_delta(const json_t *entry, const json_t *row, const struct bsdf_sample *found,
                        int count) {
    struct vec3 direction = table_vector(row, 1), weight = table_vector(row, 4);
    double pdf = table_number(row, 7), eta = table_number(row, 8);
    for (int j = 0; j < count; j++)
        if (length(sub(case_local(found[j].direction), direction)) < 2e-3f) {
            bool same = is_near_color(found[j].weight, weight) && is_near(found[j].pdf, pdf, pdf) &&
                        is_near(found[j].eta, eta, eta);
            if (!same)
                print_error("%s, point %g: weight %g %g %g chance %g eta %g, Mitsuba has %g %g %g, "
                            "%g, %g\n",
                            case_name(entry), table_number(row, 0), found[j].weight.x,
                            found[j].weight.y, found[j].weight.z, found[j].pdf, found[j].eta,
                            weight.x, weight.y, weight.z, pdf, eta);
            return same;
        }
    print_error("%s, point %g: no specular direction (%g %g %g)\n", case_name(entry),
                table_number(row, 0), direction.x, direction.y, direction.z);
    return false;
}

/* All specular directions of one point, and no others. */
static int check_deltas(const json_t *entry, size_t at) {
    const json_t *point = json_array_get(cases.points, at), *row;
    struct bsdf_sample found[MOST_DELTAS];
    struct shading shading =
        case_shading(entry, table_vector(point, 0), (float)table_number(point, 6),
                     (float)table_number(point, 7));
    int count = find_deltas(&shading, found), expected = 0, wrong = 0;
    const json_t *rows = json_object_get(entry, "specular");
    for (size_t i = 0; (row = json_array_get(rows, i)); i++)
        if (table_number(row, 0) == (double)at) {
            wrong += !check_delta(entry, row, found, count);
            expected++;
        }
    if (count != expected)
        print_error("%s, point %zu: %d specular directions, Mitsuba has %d\n", case_name(entry), at,
                    count, expected);
    return wrong + (count != expected);
}

static void test_specular_samples_equal_mitsubas(void **state) {
    (void)state;
    int wrong = 0;
    json_t *entry;
    for (size_t i = 0; (entry = json_array_get(cases.table.configurations, i)); i++)
        for (size_t at = 0; at < json_array_size(cases.points); at += 4)
            wrong += check_deltas(entry, at);
    assert_int_equal(wrong, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values_and_densities_equal_mitsubas),
        cmocka_unit_test(test_specular_samples_equal_mitsubas),
    };
    return cmocka_run_group_tests(tests, cases_create, cases_destroy);
}
