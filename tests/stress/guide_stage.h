/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_GUIDE_STAGE_H
#define FEWRAY_TESTS_GUIDE_STAGE_H

/* A small scene with its look and maps, which tests may spoil. */

#include "tests/unit/check.h"

#include <stdio.h>
#include <unistd.h>

#include "guide/odis/density.h"
#include "guide/trace/film.h"
#include "guide/trace/sampler.h"

#define STAGE_WIDTH  24
#define STAGE_HEIGHT 16

struct stage {
    struct fewray_render_settings settings;
    struct fewray_scene *scene;
    struct fewray_world *world;
    struct fewray_film *film;
    struct fewray_look *look;
    struct fewray_maps *maps;
};

/* The corner of a room under an even sky, with a shining plate and a block of plastic: shadow rays
 * and bounces both find light, so that a wrong weight of either shows. */
static const char stage_corner[] =
    "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='5'/>"
    "<integer name='rr_depth' value='3'/></integrator><sensor type='perspective'><float name='fov' "
    "value='40'/><transform name='to_world'><lookat origin='1.5,1.2,3' target='-0.3,0.7,-0.3' "
    "up='0,1,0'/></transform><film type='hdrfilm'><integer name='width' value='24'/><integer "
    "name='height' value='16'/><rfilter type='box'/></film></sensor>"
    "<bsdf type='twosided' id='b'><bsdf type='diffuse'><rgb name='reflectance' "
    "value='0.9,0.8,0.7'/></bsdf></bsdf>"
    "<shape type='rectangle'><ref id='b'/><transform name='to_world'><rotate x='1' angle='-90'/>"
    "</transform></shape>"
    "<shape type='rectangle'><ref id='b'/><transform name='to_world'><translate y='1' z='-1'/>"
    "</transform></shape>"
    "<shape type='rectangle'><ref id='b'/><transform name='to_world'><rotate y='1' angle='90'/>"
    "<translate x='-1' y='1'/></transform></shape>"
    "<shape type='rectangle'><bsdf type='diffuse'/><transform name='to_world'><scale value='0.3'/>"
    "<rotate x='1' angle='90'/><translate y='1.6'/></transform>"
    "<emitter type='area'><rgb name='radiance' value='2,2,3'/></emitter></shape>"
    "<shape type='cube'><bsdf type='plastic'/><transform name='to_world'><scale value='0.25'/>"
    "<translate x='0.3' y='0.25' z='0.1'/></transform></shape>"
    "<emitter type='constant'><rgb name='radiance' value='0.5,0.5,0.5'/></emitter></scene>";

static inline void stage_must(int status, const struct fewray_error *error) {
    if (status)
        fail_msg("%s:%d: %s", error->file, error->line, error->what);
}

/* Loads the corner and takes a look of `initial` samples a pixel. */
static inline void stage_open(struct stage *s, int initial, int spp) {
    char path[] = "/tmp/fewray-stage-XXXXXX";
    struct fewray_render_stats stats = {0};
    struct fewray_error error = {.line = 0};
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, stage_corner, sizeof stage_corner - 1), sizeof stage_corner - 1);
    close(fd);
    *s = (struct stage){.scene = NULL};
    fewray_render_settings_init(&s->settings);
    s->settings.initial = initial;
    s->settings.spp = spp;
    s->settings.threads = 1;
    stage_must(fewray_scene_load(path, NULL, &s->scene, &error), &error);
    unlink(path);
    stage_must(fewray_world_create(s->scene, 1, &s->world, &error), &error);
    stage_must(fewray_film_create(s->world, &s->settings, &s->film, &error), &error);
    stage_must(fewray_trace_look(s->world, &s->settings, s->film, &s->look, &stats, &error),
               &error);
}

static inline void stage_make_maps(struct stage *s) {
    struct fewray_render_stats stats = {0};
    struct fewray_error error = {.line = 0};
    stage_must(fewray_maps_create(s->look, &s->settings, &s->maps, &stats, &error), &error);
}

static inline void stage_close(struct stage *s) {
    fewray_maps_destroy(&s->maps);
    fewray_look_destroy(&s->look);
    fewray_film_destroy(&s->film);
    fewray_world_destroy(&s->world);
    fewray_scene_destroy(&s->scene);
}

static inline int stage_records(const struct fewray_look *look) {
    return look->width * look->height * look->samples;
}

static inline float stage_random(uint32_t stream, int i) {
    return to_unit_float(hash_combine(stream, (uint32_t)i));
}

#endif
