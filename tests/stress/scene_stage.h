/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_STRESS_SCENE_STAGE_H
#define FEWRAY_TESTS_STRESS_SCENE_STAGE_H

/* Small scenes written as text, and the pictures that every route through the path tracer makes of
 * them. Wherever a picture is made here, no sample may be NaN, infinite or negative. */

#include "scene_scratch.h"

#include <math.h>
#include <omp.h>
#include <stdarg.h>

#include "guide/trace/bundle.h"
#include "guide/trace/film.h"
#include "guide/trace/surface.h"
#include "guide/trace/tiles.h"

#define COUNT(array) ((int)(sizeof(array) / sizeof(*(array))))

/* How a picture's paths are traced. */
enum route { ROUTE_ALONE, ROUTE_PLAIN, ROUTE_AVX2, ROUTE_AVX512, ROUTE_GUIDED, ROUTES };
static const char *const route_names[ROUTES] = {"alone", "bundle", "bundle avx2", "bundle avx512",
                                                "guided"};

static inline const struct bundle_tracer *route_tracer(enum route route) {
#if defined(__x86_64__)
    if (route == ROUTE_AVX2)
        return nn_kernels_get(NN_ISA_AVX2)->isa == NN_ISA_AVX2 ? &bundle_avx2 : NULL;
    if (route == ROUTE_AVX512)
        return nn_kernels_get(NN_ISA_AVX512)->isa == NN_ISA_AVX512 ? &bundle_avx512 : NULL;
#endif
    return route == ROUTE_PLAIN ? &bundle_plain : NULL;
}

static inline bool route_exists(enum route route) {
    return route == ROUTE_ALONE || route == ROUTE_GUIDED || route_tracer(route);
}

struct sight {
    struct fewray_scene *scene;
    struct fewray_world *world;
    int width, height;
};

#define SIGHT_TEXT 16384

static inline int sight_try(struct sight *s, struct fewray_error *error, const char *format,
                            va_list arguments) {
    static char body[SIGHT_TEXT], text[SIGHT_TEXT + 64];
    memset(s, 0, sizeof(*s));
    memset(error, 0, sizeof(*error));
    assert_true(vsnprintf(body, sizeof(body), format, arguments) < (int)sizeof(body));
    snprintf(text, sizeof(text), "<scene version='3.0.0'>%s</scene>", body);
    int status = fewray_scene_load(scratch_text("scene.xml", text), NULL, &s->scene, error);
    if (!status)
        status = fewray_world_create(s->scene, 1, &s->world, error);
    if (!status) {
        s->width = s->scene->camera.width;
        s->height = s->scene->camera.height;
    }
    return status;
}

/* Loads a scene, all but its root element, by a printf format. */
__attribute__((format(printf, 2, 3))) static inline void sight_open(struct sight *s,
                                                                    const char *format, ...) {
    struct fewray_error error;
    va_list arguments;
    va_start(arguments, format);
    if (sight_try(s, &error, format, arguments))
        fail_msg("%s:%d: %s", error.file, error.line, error.what);
    va_end(arguments);
}

static inline void sight_close(struct sight *s) {
    fewray_world_destroy(&s->world);
    fewray_scene_destroy(&s->scene);
}

/* The scene must be refused, with one line that has this in it. */
__attribute__((format(printf, 2, 3))) static inline void assert_refused(const char *what,
                                                                        const char *format, ...) {
    struct sight s;
    struct fewray_error error;
    va_list arguments;
    va_start(arguments, format);
    int status = sight_try(&s, &error, format, arguments);
    va_end(arguments);
    sight_close(&s);
    if (!status)
        fail_msg("taken, but should have been refused: %s", what);
    if (!(strstr(error.what, what) || strstr(error.file, what)) || strchr(error.what, '\n'))
        fail_msg("\"%s: %s\" doesn't say \"%s\"", error.file, error.what, what);
}

static inline void check_sample(const struct path_sample *p, enum route route) {
    const struct vec3 colors[] = {p->radiance, p->emission, p->bounce, p->indirect, p->albedo};
    for (int i = 0; i < COUNT(colors); i++)
        if (!is_finite(colors[i]) || fminf(colors[i].x, fminf(colors[i].y, colors[i].z)) < 0)
            fail_msg("%s: color %d of a sample is %g %g %g", route_names[route], i,
                     (double)colors[i].x, (double)colors[i].y, (double)colors[i].z);
    if (!is_finite(p->normal) || !isfinite(p->depth) || !isfinite(p->alpha))
        fail_msg("%s: a sample's features aren't finite", route_names[route]);
}

/* The paths of a picture in bundles, or one at a time. */
static inline void sight_trace(const struct sight *s, enum route route, int spp, double *rgb) {
    const struct fewray_render_settings settings = {.seed = 1};
    const struct integrator in = {.world = s->world,
                                  .width = s->width,
                                  .height = s->height,
                                  .max_depth = s->scene->max_depth,
                                  .rr_depth = s->scene->rr_depth};
    const int paths = s->width * s->height * spp;
    struct path_sample samples[BUNDLE_LANES];
    memset(rgb, 0, 3 * (size_t)(s->width * s->height) * sizeof(*rgb));
    for (int i = 0; i < paths; i += BUNDLE_LANES) {
        struct bundle_start starts[BUNDLE_LANES];
        int count = min_int(BUNDLE_LANES, paths - i);
        for (int k = 0; k < count; k++) {
            int x = (i + k) / spp % s->width, y = (i + k) / spp / s->width;
            starts[k] = (struct bundle_start){.x = x, .y = y};
            starts[k].sampler =
                sampler_start(pixel_seed(&settings, x, y), (uint32_t)((i + k) % spp));
            if (route == ROUTE_ALONE)
                samples[k] = trace_path(&in, x, y, &starts[k].sampler, NULL);
        }
        if (route != ROUTE_ALONE)
            route_tracer(route)->paths(&in, count, starts, samples);
        for (int k = 0; k < count; k++) {
            double *pixel = rgb + 3 * ((i + k) / spp);
            check_sample(&samples[k], route);
            pixel[0] += (double)samples[k].radiance.x / spp;
            pixel[1] += (double)samples[k].radiance.y / spp;
            pixel[2] += (double)samples[k].radiance.z / spp;
        }
    }
}

static inline void check_planes(const struct fewray_frame *frame) {
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    for (size_t k = 0; k < frame->plane_count; k++)
        for (size_t i = 0; i < pixels; i++)
            if (!isfinite(frame->planes[k].data[i]))
                fail_msg("%s of pixel %zu is %g", frame->planes[k].name, i,
                         (double)frame->planes[k].data[i]);
}

/* A guided picture with all its layers by the public functions; owned by the caller. */
static inline struct fewray_frame *sight_guided(const struct sight *s, int initial, int spp) {
    struct fewray_render_settings settings;
    struct fewray_render_stats stats = {0};
    struct fewray_error error = {.line = 0};
    struct fewray_film *film = NULL;
    struct fewray_look *look = NULL;
    struct fewray_maps *maps = NULL;
    struct fewray_frame *frame = NULL;
    fewray_render_settings_init(&settings);
    settings.initial = initial;
    settings.spp = spp;
    settings.seed = 1;
    settings.threads = 1;
    int status = fewray_film_create(s->world, &settings, &film, &error);
    status = status ? status : fewray_trace_look(s->world, &settings, film, &look, &stats, &error);
    status = status ? status : fewray_maps_create(look, &settings, &maps, &stats, &error);
    status = status ? status : fewray_trace_rest(s->world, maps, &settings, film, &stats, &error);
    status = status ? status : fewray_trace_edges(s->world, &settings, film, &stats, &error);
    status = status ? status : fewray_film_frame(film, maps, &frame, &error);
    fewray_maps_destroy(&maps);
    fewray_look_destroy(&look);
    fewray_film_destroy(&film);
    if (status)
        fail_msg("%s", error.what);
    if (stats.dropped)
        fail_msg("guided: %lld samples were dropped", stats.dropped);
    check_planes(frame);
    return frame;
}

/* rgb: (height, width, 3), mean radiance of each pixel. */
static inline void sight_render(const struct sight *s, enum route route, int spp, double *rgb) {
    if (route != ROUTE_GUIDED) {
        sight_trace(s, route, spp, rgb);
        return;
    }
    struct fewray_frame *frame = sight_guided(s, spp > 2 ? spp / 4 : 1, spp);
    float *planes[3];
    assert_true(fewray_frame_layer(frame, FEWRAY_COLOR, planes));
    for (int i = 0; i < s->width * s->height; i++)
        for (int c = 0; c < 3; c++)
            rgb[3 * i + c] = (double)planes[c][i];
    fewray_frame_destroy(&frame);
}

#define SIGHT_PIXELS 1024

struct levels {
    double least, mean, most; /* over pixels and channels */
};

static inline struct levels sight_levels(const struct sight *s, enum route route, int spp) {
    static double rgb[3 * SIGHT_PIXELS];
    struct levels levels = {INFINITY, 0, -INFINITY};
    int count = 3 * s->width * s->height;
    assert_true(count <= COUNT(rgb));
    sight_render(s, route, spp, rgb);
    for (int i = 0; i < count; i++) {
        levels.least = fmin(levels.least, rgb[i]);
        levels.most = fmax(levels.most, rgb[i]);
        levels.mean += rgb[i] / count;
    }
    return levels;
}

static inline void assert_between(double value, double low, double high, const char *name,
                                  enum route route) {
    if (!(value >= low && value <= high))
        fail_msg("%s (%s): %.9g isn't within %.9g .. %.9g", name, route_names[route], value, low,
                 high);
}

#endif
