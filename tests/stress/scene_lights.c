/* SPDX-License-Identifier: Apache-2.0 */
/* One bright light among 1e5, and none at all. */

#include "scene_stage.h"

/* A small patch of a white floor at the origin, seen from above through a narrow angle: its
 * radiance is irradiance / pi. */
#define PATCH                                                                                      \
    "<integrator type='path'><integer name='max_depth' value='2'/></integrator>"                   \
    "<sensor type='perspective'><float name='fov' value='0.01'/><transform name='to_world'>"       \
    "<lookat origin='0.4,0.6,1' target='0,0,0' up='0,1,0'/></transform><film type='hdrfilm'>"      \
    "<integer name='width' value='16'/><integer name='height' value='16'/></film></sensor>"        \
    "<shape type='rectangle'><transform name='to_world'><scale value='0.01'/></transform>"         \
    "<bsdf type='diffuse'><rgb name='reflectance' value='1'/></bsdf></shape>"

enum { SIDE = 224, DIM = 2 * SIDE * SIDE }; /* 1.00e5 triangles */
#define SPREAD 4.0
#define HEIGHT 2.0

/* Irradiance at the origin, facing +z, from a polygon of radiance 1 above it: Lambert 1760. */
static double polygon_irradiance(const double (*p)[3], int n) {
    double sum = 0;
    for (int i = 0; i < n; i++) {
        const double *a = p[i], *b = p[(i + 1) % n];
        double c[3], la = 0, lb = 0, ab = 0;
        for (int k = 0; k < 3; k++) {
            c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
            la += a[k] * a[k];
            lb += b[k] * b[k];
            ab += a[k] * b[k];
        }
        double lc = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        sum += acos(fmin(1, ab / sqrt(la * lb))) * c[2] / lc;
    }
    return fabs(sum) / 2;
}

/* Facing down: small triangles over a square, two to a cell. Returns their irradiance. */
static double write_dim_lights(void) {
    char *text = malloc((size_t)DIM * 160), *end = text;
    double irradiance = 0;
    assert_non_null(text);
    for (int i = 0; i < DIM; i++) {
        double x = SPREAD * (2.0 * (i / 2 % SIDE) / SIDE - 1), size = SPREAD / SIDE;
        double y = SPREAD * (2.0 * (i / 2 / SIDE) / SIDE - 1) + (i % 2 ? size : 0);
        const double p[3][3] = {{x, y, HEIGHT}, {x, y + size, HEIGHT}, {x + size, y, HEIGHT}};
        irradiance += polygon_irradiance(p, 3);
        for (int k = 0; k < 3; k++)
            end += sprintf(end, "v %.9g %.9g %.9g\n", p[k][0], p[k][1], p[k][2]);
        end += sprintf(end, "f -3 -2 -1\n");
    }
    scratch_text("dim.obj", text);
    free(text);
    return irradiance;
}

#define BRIGHT_Z 1.5
static double write_bright_light(void) {
    const double p[3][3] = {{1, 1, BRIGHT_Z}, {1, 1.02, BRIGHT_Z}, {1.02, 1, BRIGHT_Z}};
    char text[256], *end = text;
    for (int k = 0; k < 3; k++)
        end += sprintf(end, "v %.9g %.9g %.9g\n", p[k][0], p[k][1], p[k][2]);
    sprintf(end, "f 1 2 3\n");
    scratch_text("bright.obj", text);
    return polygon_irradiance(p, 3);
}

#define MESH_LIGHT(file, radiance)                                                                 \
    "<shape type='obj'><string name='filename' value='" file "'/><bsdf type='diffuse'>"            \
    "<rgb name='reflectance' value='0'/></bsdf><emitter type='area'>" radiance                     \
    "</emitter></shape>"

/* The bright one hides a part of the dim ones behind it that is below 1e-3 of them. */
static void test_one_bright_light_among_many(void **state) {
    (void)state;
    static const struct {
        const char *name, *dim;
        double dim_radiance, bright_radiance;
        double bound; /* relative error of the mean of 16 x 16 x 16 samples */
    } cases[] = {
        {"dim ones", "<rgb name='radiance' value='1e-6'/>", 1e-6, 1e6, 1e-3},
        {"black ones",
         "<texture type='checkerboard' name='radiance'><rgb name='color0' value='0'/>"
         "<rgb name='color1' value='0'/></texture>",
         0, 1, 1e-3},
        {"as much light by all dim ones as by the bright one",
         "<rgb name='radiance' value='1e-2'/>", 1e-2, 100, 0.03},
        {"dim ones alone", "<rgb name='radiance' value='1'/>", 1, 1e-12, 0.03},
    };
    double dim = write_dim_lights(), bright = write_bright_light();
    for (int i = 0; i < COUNT(cases); i++) {
        struct sight s;
        sight_open(&s,
                   PATCH MESH_LIGHT("dim.obj", "%s")
                       MESH_LIGHT("bright.obj", "<rgb name='radiance' value='%.17g'/>"),
                   cases[i].dim, cases[i].bright_radiance);
        double right = (dim * cases[i].dim_radiance + bright * cases[i].bright_radiance) / M_PI;
        for (enum route route = 0; route < ROUTE_GUIDED; route++)
            if (route_exists(route)) {
                double mean = sight_levels(&s, route, 16).mean / right;
                assert_between(mean, 1 - cases[i].bound, 1 + cases[i].bound, cases[i].name, route);
            }
        sight_close(&s);
    }
}

static void test_no_light_is_black_and_needs_no_guide(void **state) {
    (void)state;
    static const struct {
        const char *name, *lights;
    } cases[] = {
        {"none", ""},
        {"a black area light", MESH_LIGHT("bright.obj", "<rgb name='radiance' value='0'/>")},
        {"a black sky", "<emitter type='constant'><rgb name='radiance' value='0'/></emitter>"},
        {"a black bulb", "<emitter type='point'><rgb name='intensity' value='0'/></emitter>"},
        {"a light of no area", "<shape type='rectangle'><transform name='to_world'>"
                               "<scale value='0'/><translate z='1'/></transform>"
                               "<emitter type='area'/></shape>"},
        {"a light that looks away", "<shape type='rectangle'><transform name='to_world'>"
                                    "<translate z='5'/></transform><emitter type='area'/></shape>"},
    };
    write_bright_light();
    for (int i = 0; i < COUNT(cases); i++) {
        struct sight s;
        sight_open(&s, PATCH "%s", cases[i].lights);
        for (enum route route = 0; route < ROUTES; route++)
            if (route_exists(route))
                assert_between(sight_levels(&s, route, 4).most, 0, 0, cases[i].name, route);
        struct fewray_render_settings settings;
        struct fewray_render_stats stats = {0};
        struct fewray_pilot pilot;
        struct fewray_film *film = NULL;
        fewray_render_settings_init(&settings);
        settings.threads = 1;
        assert_int_equal(fewray_film_create(s.world, &settings, &film, NULL), 0);
        assert_int_equal(fewray_trace_pilot(s.world, &settings, film, &pilot, &stats, NULL), 0);
        assert_true(pilot.dark && !fewray_pilot_wants_guide(&pilot));
        fewray_film_destroy(&film);
        sight_close(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_bright_light_among_many),
        cmocka_unit_test(test_no_light_is_black_and_needs_no_guide),
    };
    omp_set_num_threads(1);
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
