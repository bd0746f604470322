/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes from 1e-4 to 1e6 units across, and up to 1e5 times their size from the origin: closed
 * boxes whose inside is known. */

#include "scene_stage.h"

struct placing {
    const char *name;
    double size, distance; /* of the box's half side, scene units; in sizes, from the origin */
    /* Of the mean, as a share of the known radiance. Noise of 16 x 12 x 32 samples is below 1 %
     * of it; vertices and the camera are rounded to 2^-24 of their distance, and move the light by
     * as much of the scene's size. */
    double bound;
};

#define EPSILON 5.96e-8 /* 2^-24 */
#define NOISE   0.01
/* Of a pixel's 32 samples. */
#define PIXEL_NOISE 0.3
static const struct placing placings[] = {
    {"1e-4 units", 1e-4, 0, NOISE},
    {"1e-3 units", 1e-3, 0, NOISE},
    {"1 unit", 1, 0, NOISE},
    {"1e3 units", 1e3, 0, NOISE},
    {"1e6 units", 1e6, 0, NOISE},
    {"1 unit at 10", 1, 10, NOISE + 10 * EPSILON},
    {"1 unit at 1e3", 1, 1e3, NOISE + 1e3 * EPSILON},
    {"1 unit at 1e5", 1, 1e5, NOISE + 1e5 * EPSILON},
    {"1e-4 units at 1e3", 1e-4, 1e3, NOISE + 1e3 * EPSILON},
    {"1e6 units at 1e5", 1e6, 1e5, NOISE + 1e5 * EPSILON},
};

static void open_box(struct sight *s, const struct placing *p, const char *walls,
                     const char *rest) {
    double far = p->distance * p->size;
    static char to_world[512];
    snprintf(to_world, sizeof(to_world),
             "<transform name='to_world'><scale value='%.17g'/><translate x='%.17g' y='%.17g' "
             "z='%.17g'/></transform>",
             p->size, far, far / 3, -far);
    sight_open(s,
               "<integrator type='path'><integer name='max_depth' value='-1'/></integrator>"
               "<sensor type='perspective'><float name='fov' value='80'/>"
               "<transform name='to_world'><lookat origin='%.17g,%.17g,%.17g' "
               "target='%.17g,%.17g,%.17g' up='0,1,0'/></transform><film type='hdrfilm'>"
               "<integer name='width' value='16'/><integer name='height' value='12'/></film>"
               "</sensor><shape type='cube'>%s<boolean name='flip_normals' value='true'/>%s"
               "</shape>%s",
               far + 0.1 * p->size, far / 3 + 0.2 * p->size, -far + 0.6 * p->size,
               far + 0.3 * p->size, far / 3 - 0.4 * p->size, -far - p->size, to_world, walls, rest);
}

/* Walls of albedo 1/2 that shine with 1: radiance 1 / (1 - 1/2) everywhere. A leak or a ray that
 * hits the surface that it leaves darkens it. */
static void test_closed_furnace_has_its_radiance(void **state) {
    (void)state;
    for (int i = 0; i < COUNT(placings); i++) {
        const struct placing *p = &placings[i];
        struct sight s;
        open_box(&s, p,
                 "<bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf>"
                 "<emitter type='area'><rgb name='radiance' value='1'/></emitter>",
                 "");
        for (enum route route = 0; route < ROUTES; route++) {
            if (!route_exists(route))
                continue;
            const struct levels l = sight_levels(&s, route, 32);
            assert_between(l.mean / 2, 1 - p->bound, 1 + p->bound, p->name, route);
            assert_between(l.least / 2, 1 - PIXEL_NOISE, 1, p->name, route);
            assert_between(l.most / 2, 1, 1 + PIXEL_NOISE, p->name, route);
        }
        sight_close(&s);
    }
}

/* A sealed black room below a bright sky stays black, to the bit. */
static void test_sealed_box_lets_no_light_in(void **state) {
    (void)state;
    for (int i = 0; i < COUNT(placings); i++) {
        struct sight s;
        open_box(&s, &placings[i],
                 "<bsdf type='diffuse'><rgb name='reflectance' value='0.9'/></bsdf>",
                 "<emitter type='constant'><rgb name='radiance' value='1e6'/></emitter>");
        for (enum route route = 0; route < ROUTES; route++)
            if (route_exists(route)) {
                const struct levels l = sight_levels(&s, route, 8);
                assert_between(l.most, 0, 0, placings[i].name, route);
            }
        sight_close(&s);
    }
}

/* Flat, curved and clear surfaces; all but the camera scale by a transform. */
#define ROOM                                                                                       \
    "<integrator type='path'><integer name='max_depth' value='6'/></integrator>"                   \
    "<sensor type='perspective'><float name='fov' value='70'/><transform name='to_world'>"         \
    "<lookat origin='%.17g,%.17g,%.17g' target='0,0,0' up='0,1,0'/></transform>"                   \
    "<film type='hdrfilm'><integer name='width' value='16'/><integer name='height' value='12'/>"   \
    "</film></sensor>"                                                                             \
    "<shape type='cube'>%s<boolean name='flip_normals' value='true'/></shape>"                     \
    "<shape type='sphere'><point name='center' x='0.4' y='-0.5' z='0.2'/>"                         \
    "<float name='radius' value='0.3'/>%s<bsdf type='dielectric'/></shape>"                        \
    "<shape type='cylinder'><point name='p0' x='-0.4' y='-1' z='0'/>"                              \
    "<point name='p1' x='-0.5' y='0.2' z='-0.1'/><float name='radius' value='0.2'/>%s"             \
    "<bsdf type='twosided'><bsdf type='roughplastic'/></bsdf></shape>"                             \
    "<shape type='disk'><transform name='to_world'><scale value='0.4'/>"                           \
    "<rotate x='1' angle='90'/><translate y='0.9'/><scale value='%.17g'/></transform>"             \
    "<emitter type='area'><rgb name='radiance' value='9,7,5'/></emitter></shape>"

static void open_room(struct sight *s, double size) {
    static char to_world[128];
    snprintf(to_world, sizeof(to_world),
             "<transform name='to_world'><scale value='%.17g'/></transform>", size);
    sight_open(s, ROOM, 0.2 * size, 0.3 * size, 0.9 * size, to_world, to_world, to_world, size);
}

/* Sizes are powers of two, which don't round. Below 1 all scales along, and the picture is the same
 * to the bit; above, rays leave surfaces by up to twice as much of the size (9e-5 of it): what
 * they hit moves, and with it the few samples that just miss; most of it behind the glass. */
static void test_picture_of_a_scaled_room_is_the_same(void **state) {
    (void)state;
    static const struct {
        const char *name;
        double size, reference, bound; /* mean difference over the mean */
    } cases[] = {
        {"1e-4 units", 0x1p-14, 0x1p-1, 0},
        {"1e-3 units", 0x1p-10, 0x1p-1, 0},
        {"1e3 units", 0x1p10, 1, 0.02},
        {"1e6 units", 0x1p20, 1, 0.02},
    };
    enum { VALUES = 3 * 16 * 12, SPP = 16 };
    static double scaled[VALUES], reference[VALUES];
    for (int i = 0; i < COUNT(cases); i++) {
        struct sight a, b;
        open_room(&a, cases[i].size);
        open_room(&b, cases[i].reference);
        for (enum route route = 0; route < ROUTES; route++) {
            if (!route_exists(route))
                continue;
            double difference = 0, sum = 0;
            sight_render(&a, route, SPP, scaled);
            sight_render(&b, route, SPP, reference);
            for (int k = 0; k < VALUES; k++) {
                difference += fabs(scaled[k] - reference[k]);
                sum += reference[k];
            }
            assert_true(sum > 0.1 * VALUES);
            assert_between(difference / sum, 0, cases[i].bound, cases[i].name, route);
        }
        sight_close(&a);
        sight_close(&b);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_furnace_has_its_radiance),
        cmocka_unit_test(test_picture_of_a_scaled_room_is_the_same),
        cmocka_unit_test(test_sealed_box_lets_no_light_in),
    };
    omp_set_num_threads(1);
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
