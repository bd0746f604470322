/* SPDX-License-Identifier: Apache-2.0 */
/* The sunsky emitter: an environment map and a sun. */

#include <string.h>

#include "guide/scene/params.h"
#include "guide/scene/sun_position.h"
#include "guide/scene/sunsky.h"

static int parse_date(struct loader *loader, struct xml_node *emitter, struct sun_time *time) {
    int status = param_integer(loader, emitter, "year", 1, &time->year);
    if (!status)
        status = param_integer(loader, emitter, "month", 1, &time->month);
    if (!status)
        status = param_integer(loader, emitter, "day", 1, &time->day);
    if (!status && (time->year > 9999 || time->month > 12 || time->day > 31))
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter, "%d-%d-%d is no date",
                             time->year, time->month, time->day);
    return status;
}

/* Mitsuba's default: an afternoon of July in Tokyo. */
static int parse_time(struct loader *loader, struct xml_node *emitter, struct vec3 *direction) {
    struct sun_time time = {.latitude = 35.6894,
                            .longitude = 139.6917,
                            .timezone = 9,
                            .year = 2010,
                            .month = 7,
                            .day = 10,
                            .hour = 15};
    const struct {
        const char *name;
        double least, most, *value;
    } numbers[] = {{"latitude", -90, 90, &time.latitude}, {"longitude", -180, 180, &time.longitude},
                   {"timezone", -24, 24, &time.timezone}, {"hour", 0, 24, &time.hour},
                   {"minute", 0, 60, &time.minute},       {"second", 0, 60, &time.second}};
    int status = parse_date(loader, emitter, &time);
    for (size_t i = 0; i < sizeof(numbers) / sizeof(*numbers) && !status; i++)
        status = param_number(loader, emitter, numbers[i].name, numbers[i].least, numbers[i].most,
                              numbers[i].value);
    if (!status)
        *direction = sun_position(&time);
    return status;
}

static int parse_sun_direction(struct loader *loader, struct xml_node *emitter,
                               struct vec3 *direction) {
    static const char *const times[] = {"latitude", "longitude", "timezone", "year",  "month",
                                        "day",      "hour",      "minute",   "second"};
    struct xml_node *given = param_find(emitter, "sun_direction");
    double d[3] = {0, 0, 0};
    if (!given)
        return parse_time(loader, emitter, direction);
    for (size_t i = 0; i < sizeof(times) / sizeof(*times); i++)
        if (param_find(emitter, times[i]))
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, given,
                               "both sun_direction and %s are given", times[i]);
    int status = param_point(loader, emitter, "sun_direction", d);
    double size = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    if (!status && !(size > 1e-30 && size < 1e30))
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, given, "sun_direction is zero");
    if (!status)
        *direction = vec((float)(d[0] / size), (float)(d[1] / size), (float)(d[2] / size));
    return status;
}

static int parse_parameters(struct loader *loader, struct xml_node *emitter, struct sunsky *out) {
    double turbidity = 3, sun_scale = 1, sky_scale = 1, aperture = 0.5358;
    bool complex_sun = false;
    struct xml_node *albedo = param_find(emitter, "albedo");
    int status = param_number(loader, emitter, "turbidity", 1, 10, &turbidity);
    if (!status)
        status = param_number(loader, emitter, "sun_scale", 0, 1e30, &sun_scale);
    if (!status)
        status = param_number(loader, emitter, "sky_scale", 0, 1e30, &sky_scale);
    if (!status)
        status = param_number(loader, emitter, "sun_aperture", 1e-3, 179, &aperture);
    if (!status)
        status = param_boolean(loader, emitter, "complex_sun", &complex_sun);
    if (!status && complex_sun)
        status = loader_warn(loader, emitter, "complex_sun is not supported yet: a simple sun");
    out->albedo = vec(0.3f, 0.3f, 0.3f);
    if (!status && albedo)
        status = param_color(loader, albedo, COLOR_REFLECTANCE, &out->albedo);
    if (!status)
        status = parse_sun_direction(loader, emitter, &out->sun_direction);
    out->turbidity = (float)turbidity;
    out->sun_scale = (float)sun_scale;
    out->sky_scale = (float)sky_scale;
    out->sun_aperture = (float)aperture;
    return status;
}

int parse_sunsky(struct loader *loader, struct xml_node *emitter) {
    struct environment *environment = &loader->scene->environment;
    struct sunsky parameters = {0};
    struct light sun = {.kind = LIGHT_SUN};
    double r[3][3];
    int status = parse_parameters(loader, emitter, &parameters);
    if (!status)
        status = parse_emitter_rotation(loader, emitter, r);
    if (!status)
        status = sunsky_create(&parameters, &loader->sky, &sun, loader->error);
    if (status)
        return status;
    environment->kind = ENVIRONMENT_MAP;
    environment->scale = 1;
    for (int j = 0; j < 3; j++) {
        /* The map's y is up, the emitter's z. */
        environment->to_local[j] = (float)r[j][0];
        environment->to_local[3 + j] = (float)r[j][2];
        environment->to_local[6 + j] = (float)-r[j][1];
    }
    double d[3] = {(double)sun.direction.x, (double)sun.direction.y, (double)sun.direction.z};
    sun.direction = vec((float)(r[0][0] * d[0] + r[0][1] * d[1] + r[0][2] * d[2]),
                        (float)(r[1][0] * d[0] + r[1][1] * d[1] + r[1][2] * d[2]),
                        (float)(r[2][0] * d[0] + r[2][1] * d[1] + r[2][2] * d[2]));
    return max_component(sun.intensity) > 0 ? add_light(loader, &sun) : FEWRAY_OK;
}
