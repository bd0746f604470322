/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_GUIDING_HOST_H
#define FEWRAY_TESTS_GUIDING_HOST_H

/* A host renderer that is made up: a floor below a grey sky with one small bright window, seen by a
 * look of one record a pixel. */

#include "tests/unit/check.h"

#include <string.h>

#include "fewray/guiding.h"
#include "guide/odis/maps.h"
#include "guide/trace/sampler.h"

enum { WIDTH = 48, HEIGHT = 32, RECORDS = WIDTH * HEIGHT, BARE = 8 };

#define WINDOW_COSINE 0.98f /* of the cone around the window's middle */
#define WINDOW        60.0f /* its radiance */
#define SKY           0.1f

static inline struct vec3 window_direction(void) {
    return normalize(vec(0.4f, 0.8f, 0.3f));
}

/* The radiance that comes to the floor. */
static inline float sky(struct vec3 direction) {
    return dot(direction, window_direction()) > WINDOW_COSINE ? WINDOW : SKY;
}

struct host {
    struct fewray_guide_look look;
    float position[RECORDS][3], normal[RECORDS][3], depth[RECORDS], direction[RECORDS][3];
    float emitted[RECORDS][3], reflected[RECORDS][3], distance[RECORDS], second_normal[RECORDS][3];
    float direct[RECORDS][3], light_pdf[RECORDS];
    float albedo[RECORDS], light[RECORDS][3], light_value[RECORDS], bounce[RECORDS][3],
        bounce_value[RECORDS];
};

static inline void put(float *out, struct vec3 v) {
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static inline float random_float(uint32_t i, uint32_t k) {
    return to_unit_float(hash_combine(i, k));
}

/* A point of the floor; the camera misses it in the first BARE columns. */
static inline struct vec3 floor_point(int i) {
    return vec(0.1f * (float)(i % WIDTH), 0, 0.1f * (float)(i / WIDTH));
}

/* What lies in direction z > 0.5 is a wall five units away, which reflects; the rest is sky. */
static inline void look_at(struct host *h, int i) {
    float u[2];
    sobol_point((uint32_t)i, 7, u);
    const float y = 1 - u[0], r = sqrtf(fmaxf(0, 1 - y * y)), phi = 2 * PI_F * u[1];
    const struct vec3 d = normalize(vec(r * cosf(phi), y, r * sinf(phi)));
    const bool wall = d.z > 0.5f;
    const float emission = wall ? 0 : sky(d);
    put(h->position[i], floor_point(i));
    put(h->normal[i], vec(0, 1, 0));
    put(h->direction[i], d);
    put(h->second_normal[i], vec(0, 0, -1));
    put(h->emitted[i], vec(emission, emission, emission));
    h->depth[i] = i % WIDTH < BARE ? 0 : 6;
    h->distance[i] = wall ? 5 : 0;
    if (!wall)
        return;
    for (int c = 0; c < 3; c++)
        h->reflected[i][c] = random_float((uint32_t)i, 3) < 0.2f ? 2.5f : 0;
    h->albedo[i] = 0.5f;
    put(h->light[i], normalize(vec(random_float((uint32_t)i, 4) - 0.5f, 1, -0.7f)));
    h->light_value[i] = random_float((uint32_t)i, 5) < 0.5f ? 3 : 0;
    put(h->bounce[i], normalize(vec(random_float((uint32_t)i, 6) - 0.5f, 0.2f, -1)));
}

static inline struct host *make_host(bool seconds) {
    struct host *h = calloc(1, sizeof(*h));
    assert_non_null(h);
    for (int i = 0; i < RECORDS; i++)
        look_at(h, i);
    h->look = (struct fewray_guide_look){.width = WIDTH,
                                         .height = HEIGHT,
                                         .samples = 1,
                                         .position = h->position[0],
                                         .normal = h->normal[0],
                                         .depth = h->depth,
                                         .direction = h->direction[0],
                                         .emitted = h->emitted[0],
                                         .reflected = h->reflected[0],
                                         .distance = h->distance,
                                         .second_normal = h->second_normal[0]};
    if (seconds) {
        h->look.second_albedo = h->albedo;
        h->look.second_light = h->light[0];
        h->look.second_light_value = h->light_value;
        h->look.second_bounce = h->bounce[0];
        h->look.second_bounce_value = h->bounce_value;
    }
    return h;
}

static inline struct fewray_guide *make_guide(const struct host *h, int threads,
                                              struct fewray_guide_stats *stats) {
    struct fewray_guide_options options;
    struct fewray_guide *guide = NULL;
    struct fewray_error error;
    fewray_guide_options_init(&options);
    options.threads = threads;
    if (fewray_guide_create(&h->look, &options, &guide, stats, &error))
        fail_msg("%s", error.what);
    return guide;
}

static inline struct fewray_guide_at first_at(const struct fewray_guide *guide, int x, int y) {
    float position[3];
    const float up[3] = {0, 1, 0};
    put(position, floor_point(y * WIDTH + x));
    return fewray_guide_first(guide, x, y, position, up);
}

/* One bounce from the floor: irradiance / pi by the guide's mixture, and by the cosine. */
static inline void estimate(const struct fewray_guide_at *at, int samples, double *mean,
                            double *variance) {
    double sum = 0, squares = 0;
    for (uint32_t k = 0; k < (uint32_t)samples; k++) {
        float d[3];
        const float u[2] = {random_float(k, 11), random_float(k, 12)};
        const float choice = random_float(k, 13), a = at->bsdf_fraction;
        if (a < 1 && choice >= a) {
            fewray_guide_sample(at, u, d);
        } else {
            const float r = sqrtf(u[0]), phi = 2 * PI_F * u[1];
            put(d, vec(r * cosf(phi), sqrtf(fmaxf(0, 1 - u[0])), r * sinf(phi)));
        }
        const float cosine = fmaxf(d[1], 0);
        float pdf = a * cosine / PI_F;
        if (a < 1)
            pdf += (1 - a) * fewray_guide_pdf(at, d);
        const double value =
            cosine > 0 ? (double)(sky(vec(d[0], d[1], d[2])) * cosine / (PI_F * pdf)) : 0;
        sum += value;
        squares += value * value;
    }
    *mean = sum / samples;
    *variance = squares / samples - *mean * *mean;
}

/* What that comes to: a cone around n . d = cos(theta0) adds (L - L0) sin^2(alpha) cos(theta0). */
static inline double exact_estimate(void) {
    return (double)SKY + (double)(WINDOW - SKY) * (1 - (double)(WINDOW_COSINE * WINDOW_COSINE)) *
                             (double)window_direction().y;
}

#endif
