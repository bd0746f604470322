/* SPDX-License-Identifier: Apache-2.0 */
/* Radiance from 1e-12 to 1e12: a picture scales with its lights, and so do its layers. */

#include "../unit/bundle_scenes.h"
#include "scene_stage.h"

#include "fewray/denoise.h"

/* 9e-13, 1e-6, 1e6 and 5e11. Powers of two don't round, so neither may the picture: it must
 * be the same to the bit after division. */
static const double scales[] = {0x1p-40, 0x1p-20, 0x1p20, 0x1p39};

#define VALUE(tag, name) "<" tag " name='" name "' value='%.17g'/>"
#define LOOK                                                                                       \
    "<integrator type='path'><integer name='max_depth' value='4'/></integrator>"                   \
    "<sensor type='perspective'><float name='fov' value='75'/><transform name='to_world'>"         \
    "<lookat origin='0.1,0.2,0.95' target='0,-0.2,-1' up='0,1,0'/></transform>"                    \
    "<film type='hdrfilm'><integer name='width' value='16'/><integer name='height' value='16'/>"   \
    "</film></sensor>"
#define SHINE "<emitter type='area'>" VALUE("rgb", "radiance") "</emitter>"
#define SHINING_CUBE(x)                                                                            \
    SHAPE("cube", "<scale value='0.06'/><translate x='" x "' y='0.5'/>", SHINE DIFFUSE("0.5"))

static const struct {
    const char *name, *text; /* with the light's strength, up to four times */
} lights[] = {
    {"area", LOOK ROOM THINGS LAMP_OF(SHINE)},
    {"sphere", LOOK ROOM THINGS BALL_OF(SHINE)},
    {"tree", LOOK ROOM THINGS SHINING_CUBE("-0.5") SHINING_CUBE("0") SHINING_CUBE("0.5")},
    {"point", LOOK ROOM THINGS "<emitter type='point'><point name='position' x='0.3' y='0.8' "
                               "z='0.4'/>" VALUE("rgb", "intensity") "</emitter>"},
    {"spot",
     LOOK ROOM THINGS "<emitter type='spot'><transform name='to_world'><lookat "
                      "origin='-0.6,0.8,0.6' target='0,-1,-0.4' up='0,0,1'/></transform>" VALUE(
                          "rgb", "intensity") "</emitter>"},
    {"directional", LOOK FLOOR THINGS "<emitter type='directional'><vector name='direction' x='-1' "
                                      "y='-2' z='-1.5'/>" VALUE("rgb", "irradiance") "</emitter>"},
    {"constant",
     LOOK FLOOR THINGS "<emitter type='constant'>" VALUE("rgb", "radiance") "</emitter>"},
    {"map", LOOK FLOOR THINGS "<emitter type='envmap'><string name='filename' "
                              "value='picture.hdr'/>" VALUE("float", "scale") "</emitter>"},
    {"map and area",
     LOOK FLOOR THINGS LAMP_OF(SHINE) "<emitter type='envmap'><string name='filename' "
                                      "value='picture.hdr'/>" VALUE("float", "scale") "</emitter>"},
    {"area behind glass",
     LOOK ROOM LAMP_OF(SHINE) BLOCK_OF("<bsdf type='roughplastic'/>") BALL_OF(GLASS)},
};

enum { SIDE = 16, VALUES = 3 * SIDE * SIDE };

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
static void open_lit(struct sight *s, const char *text, double strength) {
    sight_open(s, text, strength, strength, strength, strength);
}
#pragma GCC diagnostic pop

static void test_picture_scales_with_its_light(void **state) {
    (void)state;
    static double scaled[VALUES], plain[VALUES];
    write_picture();
    for (int l = 0; l < COUNT(lights); l++)
        for (int k = 0; k < COUNT(scales); k++) {
            struct sight a, b;
            open_lit(&a, lights[l].text, scales[k]);
            open_lit(&b, lights[l].text, 1);
            for (enum route route = 0; route < ROUTE_GUIDED; route++) {
                if (!route_exists(route))
                    continue;
                double sum = 0;
                sight_render(&a, route, 1, scaled);
                sight_render(&b, route, 1, plain);
                for (int i = 0; i < VALUES; i++) {
                    sum += plain[i];
                    if (scaled[i] != plain[i] * scales[k])
                        fail_msg("%s (%s): value %d is %.9g at 1, and %.9g times %g at that",
                                 lights[l].name, route_names[route], i, plain[i],
                                 scaled[i] / scales[k], scales[k]);
                }
                assert_true(sum > 0);
            }
            sight_close(&a);
            sight_close(&b);
        }
}

/* Powers of the light's strength in each layer. */
static int power_of(const char *plane) {
    return !strncmp(plane, "variance.", 9)               ? 2
           : !strncmp(plane, "irradiance.c", 12)         ? 0
           : !strncmp(plane, "irradiance.", 11)          ? 1
           : !strncmp(plane, "emission.", 9)             ? 1
           : strlen(plane) == 1 && strchr("RGB", *plane) ? 1
                                                         : 0;
}

static struct fewray_frame *denoised(struct fewray_frame *frame) {
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_denoise_stats stats = {0};
    struct fewray_error error;
    fewray_denoise_options_init(&options);
    options.threads = 1;
    if (fewray_denoiser_create(&options, &denoiser, &error) ||
        fewray_denoise_frame_layers(denoiser, frame, NULL, 0, &stats, &error))
        fail_msg("%s", error.what);
    fewray_denoiser_destroy(&denoiser);
    check_planes(frame);
    return frame;
}

/* Of the mean: the exposure that the denoiser works at is a power of two times a float that it
 * finds by logarithms, which round. */
#define DENOISED_BOUND 1e-5

static void assert_denoised_alike(struct fewray_frame *scaled, struct fewray_frame *plain,
                                  double factor) {
    float *a[3], *b[3];
    double sum = 0, off = 0;
    assert_true(fewray_frame_layer(denoised(scaled), FEWRAY_COLOR, a));
    assert_true(fewray_frame_layer(denoised(plain), FEWRAY_COLOR, b));
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < SIDE * SIDE; i++) {
            sum += (double)b[c][i];
            off += fabs((double)a[c][i] / factor - (double)b[c][i]);
        }
    if (!(sum > 0 && off <= DENOISED_BOUND * sum))
        fail_msg("denoised at %g: off by %g of %g", factor, off, sum);
}

static void test_guided_layers_scale_with_the_light(void **state) {
    (void)state;
    write_picture();
    for (int l = 0; l < COUNT(lights); l++)
        for (int k = 0; k < COUNT(scales); k += 3) {
            struct sight a, b;
            open_lit(&a, lights[l].text, scales[k]);
            open_lit(&b, lights[l].text, 1);
            struct fewray_frame *scaled = sight_guided(&a, 1, 3), *plain = sight_guided(&b, 1, 3);
            assert_int_equal(scaled->plane_count, plain->plane_count);
            for (size_t p = 0; p < plain->plane_count; p++) {
                double factor = pow(scales[k], power_of(plain->planes[p].name)), sum = 0, off = 0;
                for (int i = 0; i < SIDE * SIDE; i++) {
                    sum += fabs((double)plain->planes[p].data[i]);
                    off += fabs((double)scaled->planes[p].data[i] / factor -
                                (double)plain->planes[p].data[i]);
                }
                if (off > 0)
                    fail_msg("%s: %s at %g: off by %g of %g", lights[l].name, plain->planes[p].name,
                             scales[k], off, sum);
            }
            if (l == 0)
                assert_denoised_alike(scaled, plain, scales[k]);
            fewray_frame_destroy(&scaled);
            fewray_frame_destroy(&plain);
            sight_close(&a);
            sight_close(&b);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_picture_scales_with_its_light),
        cmocka_unit_test(test_guided_layers_scale_with_the_light),
    };
    omp_set_num_threads(1);
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
