/* SPDX-License-Identifier: Apache-2.0 */
/* Instances show what their group holds, where they place it. */

#include "shape_stage.h"

#define MEMBERS(at)                                                                                \
    "<shape type='cube'>" at "</shape>"                                                            \
    "<shape type='sphere'><float name='radius' value='0.7'/><point name='center' x='2' y='1'/>" at \
    "</shape><shape type='cylinder'><point name='p0' x='-3'/><point name='p1' x='-2' z='2'/>" at   \
    "</shape>"
#define TO_WORLD(more)                                                                             \
    "<transform name='to_world'><scale value='1.5'/><rotate x='1' y='-2' angle='70'/>"             \
    "<translate x='2' y='-1' z='3'/>" more "</transform>"
#define TO_THERE TO_WORLD("<translate x='7'/>")

/* Rays meet instances as they meet the same meshes in the scene itself. */
static void test_instances_equal_meshes(void **state) {
    struct stage a = stage_open("<shape type='cube'/><shape type='shapegroup' id='g'>" MEMBERS(
        "") "</shape><shape type='instance'><ref id='g'/>" TO_WORLD("") "</shape><shape "
                                                                        "type='instance'><ref "
                                                                        "id='g'/>" TO_THERE
                                                                        "</shape>");
    struct stage b = stage_open("<shape type='cube'/>" MEMBERS(TO_WORLD("")) MEMBERS(TO_THERE));
    int hits = 0, differences = 0;
    (void)state;
    assert_int_equal(a.scene->mesh_count, 4);
    for (int k = 0; k < 20000; k++) {
        struct surface s, t;
        struct vec3 from = add(vec(5, 0, 3), scale(any_direction(), 12));
        struct vec3 to = add(vec(k % 2 ? 2 : 9, -1, 3), scale(any_direction(), 2));
        struct vec3 d = normalize(sub(to, from));
        bool hit = surface_trace(a.world, from, d, false, &s);
        bool same = hit == surface_trace(b.world, from, d, false, &t);
        if (hit && same) {
            hits++;
            same = fabsf(s.distance - t.distance) < 1e-3f &&
                   length(sub(s.position, t.position)) < 1e-3f &&
                   length(sub(s.normal, t.normal)) < 1e-3f &&
                   length(sub(s.geometric_normal, t.geometric_normal)) < 1e-3f &&
                   length(sub(s.dp_du, t.dp_du)) < 1e-2f && length(sub(s.dp_dv, t.dp_dv)) < 1e-2f &&
                   fabsf(s.u - t.u) < 1e-3f && fabsf(s.v - t.v) < 1e-3f &&
                   s.mesh->kind == t.mesh->kind;
        }
        struct vec3 q = add(vec(5, 0, 3), scale(any_direction(), 8));
        same = same && surface_blocked(a.world, from, d, q) == surface_blocked(b.world, from, d, q);
        differences += !same;
    }
    assert_true(hits > 2000);
    assert_true(differences <= 10); /* at edges and seams */
    struct vec3 low[2], high[2];
    world_bounds(a.world, &low[0], &high[0]);
    world_bounds(b.world, &low[1], &high[1]);
    /* An instance's box is around the turned box of its group. */
    assert_true(low[0].x <= low[1].x + 1e-4f && high[0].x >= high[1].x - 1e-4f);
    assert_true(high[0].x < high[1].x + 6 && low[0].y > low[1].y - 6);
    stage_close(&a);
    stage_close(&b);
}

static void test_group_alone_is_invisible(void **state) {
    struct stage stage = stage_open("<shape type='shapegroup' id='g'>" MEMBERS("") "</shape>");
    struct surface s;
    struct vec3 low, high;
    (void)state;
    assert_int_equal(stage.scene->group_count, 1);
    assert_int_equal(stage.scene->instance_count, 0);
    assert_false(surface_trace(stage.world, vec(0, 0, 9), vec(0, 0, -1), false, &s));
    world_bounds(stage.world, &low, &high);
    assert_true(low.x > high.x);
    stage_close(&stage);
}

static void test_many_instances(void **state) {
    char body[60000];
    size_t used = (size_t)snprintf(body, sizeof(body),
                                   "<shape type='shapegroup' id='g'>" MEMBERS("") "</shape>");
    (void)state;
    for (int i = 0; i < 400; i++)
        used += (size_t)snprintf(body + used, sizeof(body) - used,
                                 "<shape type='instance'><ref id='g'/><transform name='to_world'>"
                                 "<translate x='%d'/></transform></shape>",
                                 10 * i);
    struct stage stage = stage_open(body);
    assert_int_equal(stage.scene->mesh_count, 3);
    assert_int_equal(stage.scene->instance_count, 400);
    for (int i = 0; i < 400; i++) {
        struct surface s;
        assert_true(
            surface_trace(stage.world, vec(10.0f * (float)i, 0.1f, 5), vec(0, 0, -1), true, &s));
        assert_near(s.position.z, 1, 1e-5);
    }
    stage_close(&stage);
}

/* Mitsuba 3.9 refuses them, too; but the flat placement, where it divides by zero. */
static void test_what_instances_can_not_do(void **state) {
    static const struct {
        const char *body, *what;
        int line;
    } cases[] = {
        {"<shape type='shapegroup'>\n<shape type='cube'><emitter type='area'/></shape></shape>",
         "can't shine", 3},
        {"<shape type='shapegroup'>\n<shape type='shapegroup'/></shape>", "don't nest", 3},
        {"<shape type='shapegroup' id='a'/><shape type='shapegroup'>\n"
         "<shape type='instance'><ref id='a'/></shape></shape>",
         "don't nest", 3},
        {"<shape type='shapegroup'>\n<bsdf type='diffuse' id='x'/></shape>", "only shapes can", 3},
        {"<shape type='instance'/>", "has no shapegroup", 2},
        {"<shape type='instance'>\n<shape type='cube'/></shape>", "only a shapegroup can", 3},
        {"<shape type='instance'><ref id='nothing'/></shape>", "nothing has the id", 2},
        {"<shape type='shapegroup' id='a'/><shape type='instance'><ref id='a'/>\n<ref id='a'/>"
         "</shape>",
         "two shapegroups", 3},
        {"<shape type='shapegroup' id='a'/><shape type='instance'><ref id='a'/>\n"
         "<transform name='to_world'><scale z='0'/></transform></shape>",
         "can't be inverted", 3},
        {"<shape type='cylinder'>\n<float name='radius' value='0'/></shape>", "must be positive",
         3},
        {"<shape type='cylinder'><point name='p1' value='0,0,0'/></shape>", "the same point", 2},
        {"<shape type='bsplinecurve'/>", "shape 'bsplinecurve' is not supported", 2},
        {"<shape type='merge'/>", "shape 'merge' is not supported", 2},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(cases); i++) {
        struct fewray_scene *scene;
        struct fewray_error error;
        assert_true(scratch_load(cases[i].body, &scene, &error) < 0);
        if (!strstr(error.what, cases[i].what))
            fail_msg("'%s' lacks '%s'", error.what, cases[i].what);
        assert_int_equal(error.line, cases[i].line);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_instances_equal_meshes),
        cmocka_unit_test(test_group_alone_is_invisible),
        cmocka_unit_test(test_many_instances),
        cmocka_unit_test(test_what_instances_can_not_do),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
