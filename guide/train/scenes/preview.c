/* SPDX-License-Identifier: Apache-2.0 */
/* The crude path tracer: all surfaces are diffuse but glass, which isn't there; one bounce of
 * indirect light. */

#include "guide/train/scenes/preview.h"

#include <stdlib.h>
#include <string.h>

#define VIEW_WIDTH       20
#define VIEW_HEIGHT      12
#define EXPOSURE_WIDTH   28
#define EXPOSURE_HEIGHT  17
#define EXPOSURE_SAMPLES 10

/* A ray of the camera through x, y in -1..1 (right, up) of a picture with this width / height. */
static struct vec3 camera_dir(const struct camera_pose *camera, float x, float y, float aspect) {
    struct vec3 forward = normalize(sub(camera->target, camera->eye));
    struct vec3 left = normalize(cross(camera->up, forward)), up = cross(forward, left);
    float half = tanf(camera->fov * PI_F / 360);
    return normalize(add(forward, add(scale(left, -x * half), scale(up, y * half / aspect))));
}

static int compare_floats(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static int compare_ints(const void *a, const void *b) {
    return *(const int *)a - *(const int *)b;
}

struct view preview_view(const struct stage *stage, const struct camera_pose *camera,
                         float aspect) {
    enum { N = VIEW_WIDTH * VIEW_HEIGHT };
    float depths[N];
    int shapes[N];
    struct view view = {0};
    for (int i = 0; i < N; i++) {
        float x = 2 * ((float)(i % VIEW_WIDTH) + 0.5f) / VIEW_WIDTH - 1;
        float y = 2 * ((float)(i / VIEW_WIDTH) + 0.5f) / VIEW_HEIGHT - 1;
        struct hit hit;
        bool found =
            preview_hit(stage, camera->eye, camera_dir(camera, x, y, aspect), 1e30f, true, &hit);
        depths[i] = found ? hit.distance : 1e30f;
        shapes[i] = found ? hit.shape : -1;
        view.sky_share += found ? 0 : 1.0f / N;
    }
    qsort(depths, N, sizeof *depths, compare_floats);
    qsort(shapes, N, sizeof *shapes, compare_ints);
    for (int i = 0, run = 0; i < N; i++) {
        run = i > 0 && shapes[i] == shapes[i - 1] ? run + 1 : 1;
        view.shapes += run == 1 && shapes[i] >= 0;
        view.largest_share = fmaxf(view.largest_share, (float)run / N);
    }
    view.nearest = depths[0], view.near_depth = depths[N / 20], view.median_depth = depths[N / 2];
    return view;
}

static float reflectance(const struct stage *stage, int shape) {
    const struct material *m = &stage->materials[stage->shapes[shape].material];
    return (luminance(m->color0) + luminance(m->color1)) / 2;
}

static struct vec3 cosine_dir(struct random *r, struct vec3 n) {
    float u = uniform(r, 0, 1), phi = uniform(r, 0, 2 * PI_F), rho = sqrtf(u);
    struct vec3 t = normalize(cross(fabsf(n.y) < 0.9f ? vec(0, 1, 0) : vec(1, 0, 0), n)),
                b = cross(n, t);
    return normalize(
        add(add(scale(t, rho * cosf(phi)), scale(b, rho * sinf(phi))), scale(n, sqrtf(1 - u))));
}

/* A point on a shape, uniform in area; returns its normal. */
static struct vec3 shape_point(struct random *r, const struct shape *shape, struct vec3 *point) {
    struct vec3 local;
    if (shape->kind == SHAPE_SPHERE) {
        float z = uniform(r, -1, 1), phi = uniform(r, 0, 2 * PI_F),
              rho = sqrtf(fmaxf(0, 1 - z * z));
        local = vec(rho * cosf(phi), rho * sinf(phi), z);
    } else if (shape->kind == SHAPE_DISK) {
        float rho = sqrtf(uniform(r, 0, 1)), phi = uniform(r, 0, 2 * PI_F);
        local = vec(rho * cosf(phi), rho * sinf(phi), 0);
    } else if (shape->kind == SHAPE_CYLINDER) {
        float phi = uniform(r, 0, 2 * PI_F);
        local = vec(cosf(phi), sinf(phi), uniform(r, 0, 1));
    } else {
        float x = uniform(r, -1, 1), y = uniform(r, -1, 1);
        local = vec(x, y, 0);
    }
    *point = xform_point(&shape->to_world, local);
    return preview_normal(shape, local);
}

struct light_table {
    int count;
    int shapes[256];
    float power[256], total; /* luminance times area */
};

static void collect_lights(const struct stage *stage, struct light_table *table) {
    memset(table, 0, sizeof *table);
    for (int i = 0; i < stage->shape_count && table->count < 256; i++) {
        float power = luminance(stage->shapes[i].radiance) * shape_area(&stage->shapes[i]);
        if (power <= 0)
            continue;
        table->shapes[table->count] = i;
        table->power[table->count++] = power;
        table->total += power;
    }
}

/* Irradiance / pi from the lights without a surface. */
static float lamp_light(const struct stage *stage, struct vec3 at, struct vec3 n) {
    float sum = 0;
    for (int i = 0; i < stage->lamp_count; i++) {
        const struct lamp *lamp = &stage->lamps[i];
        struct vec3 to = sub(lamp->position, at);
        float distance = length(to);
        struct vec3 dir = scale(to, 1 / distance);
        float inside = -dot(dir, lamp->direction) - cosf(lamp->cutoff * PI_F / 180);
        if (dot(n, dir) > 0 && (!lamp->spot || inside > 0) &&
            !preview_hit(stage, at, dir, distance, false, NULL))
            sum += luminance(lamp->intensity) * dot(n, dir) / (PI_F * distance * distance);
    }
    return sum;
}

/* Irradiance / pi at a point from one light sample, the lamps and the sky's sun. */
static float direct_light(const struct stage *stage, const struct light_table *lights,
                          struct vec3 at, struct vec3 n, struct random *r) {
    float sum = lamp_light(stage, at, n);
    if (lights->total > 0) {
        float u = uniform(r, 0, lights->total);
        int i = 0;
        while (i < lights->count - 1 && u >= lights->power[i])
            u -= lights->power[i++];
        const struct shape *shape = &stage->shapes[lights->shapes[i]];
        struct vec3 point, normal = shape_point(r, shape, &point), to = sub(point, at);
        float distance2 = dot(to, to), distance = sqrtf(distance2);
        struct vec3 dir = scale(to, 1 / distance);
        float cosines = fmaxf(0, dot(n, dir)) * fmaxf(0, -dot(normal, dir));
        if (cosines > 0 && !preview_hit(stage, at, dir, distance * 0.999f, false, NULL))
            sum += cosines / (PI_F * distance2) * lights->total;
    }
    const struct sky *sky = &stage->sky;
    float solid_angle = 2 * PI_F * (1 - sky->sun_cos), cosine = dot(n, sky->sun_dir);
    if (sky->kind == SKY_MAP && sky->sun_cos <= 1 && cosine > 0 &&
        !preview_hit(stage, at, sky->sun_dir, 1e30f, false, NULL))
        sum += luminance(sky->sun) * sky->strength * solid_angle * cosine / PI_F;
    return sum;
}

/* Radiance reflected towards a camera ray; *emitted gets what the ray sees directly. */
static float reflected(const struct stage *stage, const struct light_table *lights,
                       struct vec3 origin, struct vec3 dir, struct random *r, float *emitted) {
    float sum = 0, throughput = 1;
    *emitted = 0;
    for (int bounce = 0; bounce < 3; bounce++) {
        struct hit hit;
        bool found = preview_hit(stage, origin, dir, 1e30f, false, &hit);
        float light = luminance(found ? stage->shapes[hit.shape].radiance
                                      : sky_radiance(&stage->sky, dir, false));
        if (bounce == 0)
            *emitted = light;
        else if (!found)
            sum += throughput * light;
        if (!found || bounce == 2)
            break;
        struct vec3 n = dot(hit.normal, dir) > 0 ? negate(hit.normal) : hit.normal;
        throughput *= reflectance(stage, hit.shape);
        sum += throughput * direct_light(stage, lights, hit.position, n, r);
        origin = hit.position;
        dir = cosine_dir(r, n);
    }
    return sum;
}

struct exposure preview_exposure(const struct stage *stage, const struct camera_pose *camera,
                                 float aspect, struct random *r) {
    enum { N = EXPOSURE_WIDTH * EXPOSURE_HEIGHT };
    float pixels[N];
    struct light_table lights;
    struct exposure exposure = {0};
    collect_lights(stage, &lights);
    for (int i = 0; i < N; i++) {
        pixels[i] = 0;
        for (int s = 0; s < EXPOSURE_SAMPLES; s++) {
            float x = 2 * ((float)(i % EXPOSURE_WIDTH) + uniform(r, 0, 1)) / EXPOSURE_WIDTH - 1;
            float y = 2 * ((float)(i / EXPOSURE_WIDTH) + uniform(r, 0, 1)) / EXPOSURE_HEIGHT - 1;
            struct vec3 dir = camera_dir(camera, x, y, aspect);
            float emitted;
            pixels[i] +=
                reflected(stage, &lights, camera->eye, dir, r, &emitted) / EXPOSURE_SAMPLES;
            exposure.emitted += emitted / (N * EXPOSURE_SAMPLES);
        }
    }
    qsort(pixels, N, sizeof *pixels, compare_floats);
    for (int i = 0; i < N - N / 50; i++)
        exposure.reflected += pixels[i] / (N - N / 50);
    for (int i = 0; i < N; i++)
        exposure.lit_share += pixels[i] > 0.02f * exposure.reflected ? 1.0f / N : 0;
    return exposure;
}
