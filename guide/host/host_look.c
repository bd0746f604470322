/* SPDX-License-Identifier: Apache-2.0 */
/* Records made of a host's arrays. */

#include <limits.h>
#include <math.h>

#include "guide/basis.h"
#include "guide/host/host.h"
#include "guide/odis/sphere_grid.h"

#define BELOW 1e-3f /* of the horizon, as a cosine: rounding */

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
    const size_t bytes = sizeof(struct look_record) + sizeof(struct look_second);
    return fewray_memory_check(NULL, "the guide's look",
                               (double)look->width * look->height * look->samples * (double)bytes,
                               error);
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

static bool is_positive(float v) {
    return v >= 0 && isfinite(v);
}

/* Of a depth or distance: hosts call nothing hit 0 or infinite. */
static bool is_hit(float distance) {
    return distance != 0 && !isinf(distance);
}

/* Why a record with a depth can't be used; NULL: it can. */
static const char *find_flaw(const struct fewray_guide_look *look, size_t i) {
    const struct vec3 normal = at3(look->normal, i), direction = at3(look->direction, i);
    const float distance = look->distance[i];
    if (!(look->depth[i] >= 0))
        return "depth is negative or NaN";
    if (!is_finite(at3(look->position, i)))
        return "position isn't finite";
    if (!host_is_unit(normal))
        return "normal isn't a unit vector";
    if (!host_is_unit(direction))
        return "direction isn't a unit vector";
    if (!(dot(normal, direction) > -BELOW))
        return "direction points below the surface";
    if (!host_is_radiance(at3(look->emitted, i)))
        return "emitted is negative or not finite";
    if (!host_is_radiance(at3(look->reflected, i)))
        return "reflected is negative or not finite";
    if (look->direct && !host_is_radiance(at3(look->direct, i)))
        return "direct is negative or not finite";
    if (look->light_pdf && !is_positive(look->light_pdf[i]))
        return "light_pdf is negative or not finite";
    if (!(distance >= 0))
        return "distance is negative or NaN";
    if (is_hit(distance) && !host_is_unit(at3(look->second_normal, i)))
        return "second_normal isn't a unit vector";
    return NULL;
}

/* Of another's unit vectors we take the direction. */
static struct look_record make_record(const struct fewray_guide_look *look, size_t i) {
    const struct vec3 emission = at3(look->emitted, i), reflected = at3(look->reflected, i);
    const struct vec3 direction = normalize(at3(look->direction, i));
    const float light_pdf = look->light_pdf ? look->light_pdf[i] : 0;
    const bool hit = is_hit(look->distance[i]);
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
        .distance = hit ? look->distance[i] : 0,
        .second_normal = hit ? normalize(at3(look->second_normal, i)) : vec(0, 0, 0)};
}

static struct look_second make_second(const struct fewray_guide_look *look, size_t i) {
    struct look_second second = {.albedo = 0};
    const float albedo = look->second_albedo[i];
    if (!is_hit(look->distance[i]) || !(albedo > 0) || !isfinite(albedo))
        return second;
    second.albedo = albedo;
    second.light = at3(look->second_light, i);
    second.bounce = at3(look->second_bounce, i);
    second.light_sent = look->second_light_value[i] >= 0 && host_is_unit(second.light);
    second.light_value = second.light_sent ? look->second_light_value[i] : 0;
    second.bounce_value = host_is_unit(second.bounce) ? look->second_bounce_value[i] : 0;
    return second;
}

static int all_dropped(const struct fewray_guide_look *look, size_t first,
                       struct fewray_error *error) {
    const size_t samples = (size_t)look->samples, pixel = first / samples;
    return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                       "no record of the look can be used; pixel (%zu, %zu), sample %zu: %s",
                       pixel % (size_t)look->width, pixel / (size_t)look->width, first % samples,
                       find_flaw(look, first));
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
    size_t first = count; /* that was dropped */
#pragma omp parallel for schedule(static) num_threads(threads) reduction(+ : used, dropped) reduction(min : first)
    for (size_t i = 0; i < count; i++) {
        const bool there = is_hit(look->depth[i]), good = there && !find_flaw(look, i);
        records->records[i] = good ? make_record(look, i) : (struct look_record){.depth = 0};
        if (seconds)
            records->seconds[i] = good ? make_second(look, i) : (struct look_second){.albedo = 0};
        used += good;
        if (there && !good) {
            dropped++;
            first = i < first ? i : first;
        }
    }
    stats->records = used;
    stats->dropped = dropped;
    return used || !dropped ? FEWRAY_OK : all_dropped(look, first, error);
}
