/* SPDX-License-Identifier: Apache-2.0 */
/* Records made of a host's arrays. */

#include <limits.h>
#include <math.h>

#include "guide/basis.h"
#include "guide/host/host.h"
#include "guide/odis/sphere_grid.h"

#define UNIT_ERROR 1e-3f /* most, of a unit vector's squared length */
#define RADIANCE_MAX                                                                               \
    1e15f /* above, a sample is a fault: its square would leave a float's range                    \
           */

_Static_assert(FEWRAY_LOOK_PDF * 2 * PI_F > 0.999999f && FEWRAY_LOOK_PDF * 2 * PI_F < 1.000001f,
               "the header says what the maps take for granted");

static int check_sizes(const struct fewray_guide_look *look, struct fewray_error *error) {
    if (look->width < 1 || look->height < 1 || look->samples < 1)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "the look has %d x %d pixels and %d records a pixel; give at least one",
                           look->width, look->height, look->samples);
    /* Indices of records are 32 bits wide. */
    if ((double)look->width * look->height * look->samples > (double)INT_MAX)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "the look has %d x %d pixels and %d records a pixel: more than 2^31",
                           look->width, look->height, look->samples);
    return FEWRAY_OK;
}

static int check_arrays(const struct fewray_guide_look *look, struct fewray_error *error) {
    const struct {
        const char *name;
        const float *data;
    } needed[] = {{"position", look->position}, {"normal", look->normal},
                  {"depth", look->depth},       {"direction", look->direction},
                  {"emitted", look->emitted},   {"reflected", look->reflected},
                  {"distance", look->distance}, {"second_normal", look->second_normal}};
    for (size_t k = 0; k < sizeof needed / sizeof *needed; k++)
        if (!needed[k].data)
            return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0, "the look has no `%s`",
                               needed[k].name);
    const int seconds = !!look->second_albedo + !!look->second_light + !!look->second_light_value +
                        !!look->second_bounce + !!look->second_bounce_value;
    if (seconds != 0 && seconds != 5)
        return fewray_fail(
            error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
            "the look has %d of the five arrays of second vertices; give all or none", seconds);
    return FEWRAY_OK;
}

static struct vec3 at3(const float *array, size_t i) {
    return vec(array[3 * i], array[3 * i + 1], array[3 * i + 2]);
}

static bool is_unit(struct vec3 v) {
    return fabsf(dot(v, v) - 1) <= UNIT_ERROR;
}

static bool is_radiance(struct vec3 v) {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && mean_component(v) <= RADIANCE_MAX;
}

static bool is_positive(float v) {
    return v >= 0 && isfinite(v);
}

/* Whether a record with a depth can be used. */
static bool is_good(const struct fewray_guide_look *look, size_t i) {
    return is_positive(look->depth[i]) && is_finite(at3(look->position, i)) &&
           is_unit(at3(look->normal, i)) && is_unit(at3(look->direction, i)) &&
           is_radiance(at3(look->emitted, i)) && is_radiance(at3(look->reflected, i)) &&
           (!look->direct || is_radiance(at3(look->direct, i))) &&
           (!look->light_pdf || is_positive(look->light_pdf[i])) &&
           is_positive(look->distance[i]) &&
           (!(look->distance[i] > 0) || is_unit(at3(look->second_normal, i)));
}

/* Of another's unit vectors we take the direction. */
static struct look_record make_record(const struct fewray_guide_look *look, size_t i) {
    const struct vec3 emission = at3(look->emitted, i), reflected = at3(look->reflected, i);
    const struct vec3 direction = normalize(at3(look->direction, i));
    const float light_pdf = look->light_pdf ? look->light_pdf[i] : 0;
    const bool hit = look->distance[i] > 0;
    return (struct look_record){
        .position = at3(look->position, i),
        .normal = normalize(at3(look->normal, i)),
        .depth = look->depth[i],
        .direction = direction,
        .bin = (uint16_t)sphere_bin(direction),
        .direct = look->direct ? at3(look->direct, i) : vec(0, 0, 0),
        .radiance = add(emission, reflected),
        .emitted = mean_component(emission) * power_heuristic(LOOK_PDF, light_pdf),
        .reflected = mean_component(reflected),
        .distance = look->distance[i],
        .second_normal = hit ? normalize(at3(look->second_normal, i)) : vec(0, 0, 0)};
}

static struct look_second make_second(const struct fewray_guide_look *look, size_t i) {
    struct look_second second = {.albedo = 0};
    const float albedo = look->second_albedo[i];
    if (!(look->distance[i] > 0) || !(albedo > 0) || !isfinite(albedo))
        return second;
    second.albedo = albedo;
    second.light = at3(look->second_light, i);
    second.bounce = at3(look->second_bounce, i);
    second.light_sent = look->second_light_value[i] >= 0 && is_unit(second.light);
    second.light_value = second.light_sent ? look->second_light_value[i] : 0;
    second.bounce_value = is_unit(second.bounce) ? look->second_bounce_value[i] : 0;
    return second;
}

int host_look_create(const struct fewray_guide_look *look, int threads, struct fewray_look **out,
                     struct fewray_guide_stats *stats, struct fewray_error *error) {
    *out = NULL;
    int status = check_sizes(look, error);
    if (!status)
        status = check_arrays(look, error);
    const bool seconds = look->second_albedo != NULL;
    if (!status)
        status = look_create(look->width, look->height, look->samples, seconds, out, error);
    if (status)
        return status;
    struct fewray_look *records = *out;
    const size_t count = (size_t)look->width * (size_t)look->height * (size_t)look->samples;
    long long used = 0, dropped = 0;
#pragma omp parallel for schedule(static) num_threads(threads) reduction(+ : used, dropped)
    for (size_t i = 0; i < count; i++) {
        const bool there = look->depth[i] != 0, good = there && is_good(look, i);
        records->records[i] = good ? make_record(look, i) : (struct look_record){.depth = 0};
        if (seconds)
            records->seconds[i] = good ? make_second(look, i) : (struct look_second){.albedo = 0};
        used += good;
        dropped += there && !good;
    }
    stats->records = used;
    stats->dropped = dropped;
    return FEWRAY_OK;
}
