/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles, normals and transforms at their worst: refused by one line, or harmless. */

#include "scene_stage.h"

#define VIEW                                                                                       \
    "<integrator type='path'><integer name='max_depth' value='65'/></integrator>"                  \
    "<sensor type='perspective'><float name='fov' value='45'/><transform name='to_world'>"         \
    "<lookat origin='0,0,3' target='0,0,0' up='0,1,0'/></transform><film type='hdrfilm'>"          \
    "<integer name='width' value='16'/><integer name='height' value='12'/></film></sensor>"        \
    "<emitter type='constant'><rgb name='radiance' value='1'/></emitter>"
#define WHITE                                                                                      \
    "<bsdf type='twosided'><bsdf type='diffuse'><rgb name='reflectance' value='1'/></bsdf></bsdf>"
#define FILE_SHAPE(type, file, inside)                                                             \
    "<shape type='" type "'><string name='filename' value='" file "'/>" inside "</shape>"
#define PLACED(operations) "<transform name='to_world'>" operations "</transform>"
#define PLY(vertices, faces)                                                                       \
    "ply\nformat ascii 1.0\nelement vertex " vertices                                              \
    "\nproperty float x\nproperty float y\nproperty float z\nelement face " faces                  \
    "\nproperty list uchar int vertex_indices\nend_header\n"
#define SQUARE  "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"
#define CORNERS "-1 -1 0\n1 -1 0\n1 1 0\n"

static void test_meshes_that_cannot_be_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *name, *file, *content, *shape, *why;
    } cases[] = {
        {"OBJ, NaN", "a.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "", "a.obj"},
        {"OBJ, infinite", "a.obj", "v 1e999 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "", "a.obj"},
        {"OBJ, index out of range", "a.obj", SQUARE "f 1 2 5\n", "", "a.obj"},
        {"OBJ, index 0", "a.obj", SQUARE "f 0 1 2\n", "", "a.obj"},
        {"OBJ, index before the first", "a.obj", SQUARE "f -1 -2 -5\n", "", "a.obj"},
        {"PLY, NaN", "a.ply", PLY("3", "1") "nan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "", "a.ply"},
        {"PLY, infinite", "a.ply", PLY("3", "1") "inf 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "", "a.ply"},
        {"PLY, index out of range", "a.ply", PLY("3", "1") CORNERS "3 0 1 3\n", "", "a.ply"},
        {"PLY, negative index", "a.ply", PLY("3", "1") CORNERS "3 0 1 -1\n", "", "a.ply"},
        {"OBJ of points alone", "a.obj", SQUARE, "", "no faces"},
        {"empty PLY", "a.ply", PLY("0", "0"), "", "no faces"},
        {"PLY of points alone", "a.ply", PLY("3", "0") CORNERS, "", "no faces"},
        {"OBJ beyond floats by its transform", "a.obj", SQUARE "f 1 2 3\n",
         PLACED("<scale value='1e30'/><scale value='1e30'/>"), "not finite"},
    };
    for (int i = 0; i < COUNT(cases); i++) {
        scratch_text(cases[i].file, cases[i].content);
        bool ply = strstr(cases[i].file, ".ply");
        assert_refused(cases[i].why, VIEW FILE_SHAPE("%s", "%s", "%s"), ply ? "ply" : "obj",
                       cases[i].file, cases[i].shape);
    }
}

static void test_instances_that_cannot_be_are_refused(void **state) {
    (void)state;
    assert_refused("can't be inverted",
                   VIEW "<shape type='shapegroup' id='g'><shape type='cube'/></shape>"
                        "<shape type='instance'><ref id='g'/>" PLACED("<scale z='0'/>") "</shape>");
}

/* White things below a sky of 1 show 1, whatever their shape: no pixel's mean of 16 samples may be
 * brighter than noise allows, and the picture's mean is 1, within 1 %. */
#define FURNACE_PIXEL 1.3
#define FURNACE_MEAN  1.01
static void test_odd_meshes_make_no_light(void **state) {
    (void)state;
    static const struct {
        const char *name, *file, *content, *shapes;
        double least;
    } cases[] = {
        {"needles", "a.obj",
         "v -1 -1 0\nv 1 1 0\nv 1 1.0000002 0\nv -1 1 -1e-7\nf 1 2 3\nf 1 3 4\n", "", 0.99},
        {"zero area", "a.obj", SQUARE "f 1 2 3\nf 1 1 2\nf 3 3 3\nf 1 3 4\n", "", 0.99},
        {"collinear", "a.obj", "v -1 0 0\nv 0 0 0\nv 1 0 0\nf 1 2 3\n", "", 0.99},
        {"tiny", "a.obj", "v 0 0 0\nv 1e-30 0 0\nv 0 1e-30 0\nf 1 2 3\n", "", 0.99},
        {"huge", "a.obj", "v -1e9 -1e9 0\nv 1e9 -1e9 0\nv 0 1e9 0\nf 1 2 3\n", "", 0.99},
        /* its normal overflows: black */
        {"beyond floats' squares", "a.obj",
         "v -1e15 -1e15 0\nv 1e15 -1e15 0\nv 0 1e15 0\nf 1 2 3\n", "", 0},
        {"beyond Embree's range", "a.obj", "v -1e30 -1e30 0\nv 1e30 -1e30 0\nv 0 1e30 0\nf 1 2 3\n",
         "", 0},
        {"zero normals", "a.obj", SQUARE "vn 0 0 0\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n", "",
         0.99},
        {"NaN normals", "a.obj", SQUARE "vn nan nan nan\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n", "",
         0.99},
        {"normals to the other side", "a.obj",
         SQUARE "vn 0 0 -1\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n", "", 0.99},
        {"normals along the surface", "a.obj",
         SQUARE "vn 1 0 0\nvn 0 1 0\nf 1//1 2//1 3//2\nf 1//1 3//2 4//2\n", "", 0.99},
        {"normals to both sides", "a.obj",
         SQUARE "vn 0 0 1\nvn 0 0 -1\nf 1//1 2//2 3//1\nf 1//1 3//2 4//1\n", "", 0.99},
        {"coincident surfaces", "a.obj", SQUARE "f 1 2 3\nf 1 3 4\nf 1 2 4\nf 2 3 4\n",
         FILE_SHAPE("obj", "a.obj", WHITE), 0.99},
        {"coincident, to both sides", "a.obj", SQUARE "f 1 2 3\nf 1 3 4\nf 1 3 2\nf 1 4 3\n",
         FILE_SHAPE("obj", "a.obj", WHITE), 0.99},
        {"flattened cube", "a.obj", SQUARE "f 1 2 3\n",
         "<shape type='cube'>" PLACED("<scale z='0'/>") WHITE "</shape>", 0.99},
        {"cube as a line", "a.obj", SQUARE "f 1 2 3\n",
         "<shape type='cube'>" PLACED("<scale y='0' z='0'/>") WHITE "</shape>", 0.99},
        {"sphere of no size", "a.obj", SQUARE "f 1 2 3\n",
         "<shape type='sphere'>" PLACED("<scale value='0'/>") WHITE "</shape>", 0.99},
        {"flattened sphere", "a.obj", SQUARE "f 1 2 3\n",
         "<shape type='sphere'>" PLACED("<scale z='1e-6'/>") WHITE "</shape>", 0.99},
    };
    for (int i = 0; i < COUNT(cases); i++) {
        struct sight s;
        scratch_text(cases[i].file, cases[i].content);
        sight_open(&s, VIEW FILE_SHAPE("%s", "%s", WHITE) "%s",
                   strstr(cases[i].file, ".ply") ? "ply" : "obj", cases[i].file, cases[i].shapes);
        for (enum route route = 0; route < ROUTES; route++)
            if (route_exists(route)) {
                const struct levels l = sight_levels(&s, route, 16);
                assert_between(l.mean, cases[i].least, FURNACE_MEAN, cases[i].name, route);
                assert_between(l.most, 0, FURNACE_PIXEL, cases[i].name, route);
            }
        sight_close(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_meshes_that_cannot_be_are_refused),
        cmocka_unit_test(test_instances_that_cannot_be_are_refused),
        cmocka_unit_test(test_odd_meshes_make_no_light),
    };
    omp_set_num_threads(1);
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
