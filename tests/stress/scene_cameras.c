/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras that can't be, and cameras where they hardly can be. */

#include "scene_stage.h"

#define FILM                                                                                       \
    "<film type='hdrfilm'><integer name='width' value='16'/><integer name='height' value='12'/>"   \
    "</film>"
#define SKY "<emitter type='constant'><rgb name='radiance' value='1'/></emitter>"
#define WHITE                                                                                      \
    "<bsdf type='twosided'><bsdf type='diffuse'><rgb name='reflectance' value='1'/>"               \
    "</bsdf></bsdf>"

#define SENSOR_OF(fov, to_world)                                                                   \
    "<sensor type='perspective'>" fov "<transform name='to_world'>" to_world "</transform>" FILM   \
    "</sensor>" SKY
#define FOV(value) "<float name='fov' value='" value "'/>"
#define AHEAD      "<lookat origin='0,0,3' target='0,0,0' up='0,1,0'/>"

static void test_impossible_cameras_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *scene, *why;
    } cases[] = {
        {SENSOR_OF(FOV("0"), AHEAD), "fov = 0 must lie between 0 and 180"},
        {SENSOR_OF(FOV("-30"), AHEAD), "must lie between 0 and 180"},
        {SENSOR_OF(FOV("180"), AHEAD), "must lie between 0 and 180"},
        {SENSOR_OF(FOV("179.99999999"), AHEAD), "too near to 0 or 180 degrees"},
        {SENSOR_OF(FOV("1e-60"), AHEAD), "too near to 0 or 180 degrees"},
        {SENSOR_OF(FOV("nan"), AHEAD), "fov"},
        {SENSOR_OF(FOV("45"), "<lookat origin='1,2,3' target='1,2,3' up='0,1,0'/>"),
         "origin and target are the same point"},
        {SENSOR_OF(FOV("45"), "<lookat origin='0,3,0' target='0,0,0' up='0,1,0'/>"),
         "up points along the view"},
        {SENSOR_OF(FOV("45"), "<lookat origin='0,3,0' target='0,0,0' up='0,0,0'/>"),
         "up points along the view"},
        {SENSOR_OF(FOV("45"), "<scale value='0'/>"), "must not scale"},
        {SENSOR_OF(FOV("45"), "<matrix value='1 1 0 0  0 0 0 0  0 0 1 0  0 0 0 1'/>"),
         "is singular"},
        {SENSOR_OF(FOV("45"), "<matrix value='1 0 nan 0  0 1 0 0  0 0 1 0  0 0 0 1'/>"),
         "finite numbers"},
    };
    for (int i = 0; i < COUNT(cases); i++)
        assert_refused(cases[i].why, "%s", cases[i].scene);
}

/* Wherever the camera is, white surfaces and clear glass below a sky of 1 show 1: within the noise
 * of 16 x 12 x 16 samples, 2 %, and what 65 bounces leave. */
static void test_cameras_in_and_on_things_see_the_furnace(void **state) {
    (void)state;
    static const struct {
        const char *name, *scene;
        double least, most; /* mean of the picture */
    } cases[] = {
        {"in glass",
         SENSOR_OF(FOV("60"), AHEAD) "<shape type='sphere'><point name='center' z='3'/>"
                                     "<bsdf type='dielectric'/></shape>",
         2.1, 2.4}, /* radiance in the medium is eta^2 = 1.5046^2 = 2.264 of that outside */
        {"in a closed white mesh",
         SENSOR_OF(FOV("60"), AHEAD) "<shape type='cube'><transform "
                                     "name='to_world'><translate z='3'/></transform>" WHITE
                                     "</shape>",
         0, 0},
        {"on a surface, along it",
         SENSOR_OF(
             FOV("60"),
             "<lookat origin='0,0,0' target='1,0,0' up='0,1,0'/>") "<shape "
                                                                   "type='rectangle'><transform "
                                                                   "name='to_world'><rotate x='1' "
                                                                   "angle='-90'/>"
                                                                   "</transform>" WHITE "</shape>",
         0.98, 1.02},
        {"on a surface, through it",
         SENSOR_OF(
             FOV("60"),
             "<lookat origin='0,0,0' target='0,0,-1' up='0,1,0'/>") "<shape type='rectangle'>" WHITE
                                                                    "</shape>",
         0.98, 1.02},
        {"the least field of view",
         SENSOR_OF(FOV("1e-30"), AHEAD) "<shape type='sphere'>" WHITE "</shape>", 0.98, 1.02},
        {"the greatest field of view",
         SENSOR_OF(FOV("179.999"), AHEAD) "<shape type='sphere'>" WHITE "</shape>", 0.98, 1.02},
        {"a transform with shear",
         SENSOR_OF(
             FOV("45"),
             "<matrix value='1 0.6 0 0  0 0.8 0 0  0 0 -1 3  0 0 0 1'/>") "<shape "
                                                                          "type='sphere'>" WHITE
                                                                          "</shape>",
         0.98, 1.02},
    };
    for (int i = 0; i < COUNT(cases); i++) {
        struct sight s;
        sight_open(&s,
                   "<integrator type='path'><integer name='max_depth' value='65'/>"
                   "</integrator>%s",
                   cases[i].scene);
        for (enum route route = 0; route < ROUTES; route++)
            if (route_exists(route))
                assert_between(sight_levels(&s, route, 16).mean, cases[i].least, cases[i].most,
                               cases[i].name, route);
        sight_close(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_impossible_cameras_are_refused),
        cmocka_unit_test(test_cameras_in_and_on_things_see_the_furnace),
    };
    omp_set_num_threads(1);
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
