/* SPDX-License-Identifier: Apache-2.0 */
/* Emitters: area within a shape; points and directions; constant or a map around the scene. */

#include <string.h>

#include "guide/scene/memory.h"
#include "guide/scene/params.h"
#include "guide/scene/transform.h"

static const double radians = 3.14159265358979323846 / 180;

/* They only steer how Mitsuba samples emitters. */
static const char *const ignored[] = {"sampling_weight", "mis_compensation", NULL};

static int leave_out(struct loader *loader, struct xml_node *emitter) {
    params_ignore_all(emitter);
    return loader_warn(loader, emitter, "emitter '%s' is left out", xml_attribute(emitter, "type"));
}

int parse_area_emitter(struct loader *loader, struct xml_node *emitter, int *texture) {
    static const char *const outside[] = {"constant",    "envmap", "point",        "spot",
                                          "directional", "sunsky", "timed_sunsky", NULL};
    const char *type = xml_attribute(emitter, "type");
    *texture = -1;
    for (int i = 0; outside[i]; i++)
        if (!strcmp(type, outside[i]))
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter,
                               "emitter '%s' can't stand in a shape: move it out", type);
    if (strcmp(type, "area") && loader->lenient)
        return leave_out(loader, emitter);
    if (strcmp(type, "area"))
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, emitter,
                           "emitter '%s' in a shape is not supported yet: use area", type);
    params_ignore(emitter, ignored);
    int status = parse_radiance(loader, emitter, "radiance", vec(1, 1, 1), texture);
    if (status)
        return status;
    const struct texture *radiance = &loader->scene->textures[*texture];
    if (radiance->kind == TEXTURE_CONSTANT && !(max_component(radiance->color0) > 0))
        *texture = -1;
    return params_finish(loader, emitter);
}

/* --- lights without a surface */

int add_light(struct loader *loader, const struct light *light) {
    struct fewray_scene *scene = loader->scene;
    if (!array_reserve((void **)&scene->lights, &loader->light_capacity,
                       (size_t)scene->light_count + 1, sizeof(*scene->lights)))
        return loader_fail_memory(loader);
    scene->lights[scene->light_count++] = *light;
    return FEWRAY_OK;
}

/* The parameter `name`, or this column of to_world, but not both. */
static int parse_place(struct loader *loader, struct xml_node *emitter, const char *name,
                       int column, double out[3]) {
    struct xml_node *given = param_find(emitter, name);
    struct transform to_world;
    int status = param_transform(loader, emitter, "to_world", &to_world);
    if (!status && given && param_find(emitter, "to_world"))
        status =
            loader_fail(loader, FEWRAY_ERROR_FORMAT, given, "both %s and to_world are given", name);
    for (int i = 0; i < 3; i++)
        out[i] = status ? 0 : to_world.m[i][column];
    return status ? status : param_point(loader, emitter, name, out);
}

/* At a position, or where to_world puts the origin. */
static int parse_point(struct loader *loader, struct xml_node *emitter, struct light *light) {
    double p[3];
    int status = parse_place(loader, emitter, "position", 3, p);
    light->position = vec((float)p[0], (float)p[1], (float)p[2]);
    return status ? status : param_radiance(loader, emitter, "intensity", &light->intensity);
}

/* Along the z axis of to_world. */
static int parse_spot(struct loader *loader, struct xml_node *emitter, struct light *light) {
    struct xml_node *texture = param_find(emitter, "texture");
    struct transform to_world;
    double r[3][3], cutoff = 20, beam_width;
    if (texture)
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, texture,
                           "a spot with a texture is not supported yet");
    int status = param_transform(loader, emitter, "to_world", &to_world);
    if (!status)
        status = parse_emitter_rotation(loader, emitter, r);
    if (!status)
        status = param_number(loader, emitter, "cutoff_angle", 1e-3, 180, &cutoff);
    beam_width = 0.75 * cutoff;
    if (!status)
        status = param_number(loader, emitter, "beam_width", 0, cutoff, &beam_width);
    if (status)
        return status;
    light->position =
        vec((float)to_world.m[0][3], (float)to_world.m[1][3], (float)to_world.m[2][3]);
    light->direction = vec((float)r[0][2], (float)r[1][2], (float)r[2][2]);
    light->cutoff = (float)(cutoff * radians);
    light->beam_width = (float)(beam_width * radians);
    return param_radiance(loader, emitter, "intensity", &light->intensity);
}

/* Into a direction, or along the z axis of to_world. */
static int parse_directional(struct loader *loader, struct xml_node *emitter, struct light *light) {
    double d[3];
    int status = parse_place(loader, emitter, "direction", 2, d);
    double size = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    if (!status && !(size > 1e-30 && size < 1e30))
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter, "the light's direction is zero");
    if (status)
        return status;
    light->direction = vec((float)(d[0] / size), (float)(d[1] / size), (float)(d[2] / size));
    return param_radiance(loader, emitter, "irradiance", &light->intensity);
}

static int parse_light(struct loader *loader, struct xml_node *emitter, enum light_kind kind) {
    struct light light = {.kind = kind, .intensity = {1, 1, 1}};
    int status = kind == LIGHT_POINT  ? parse_point(loader, emitter, &light)
                 : kind == LIGHT_SPOT ? parse_spot(loader, emitter, &light)
                                      : parse_directional(loader, emitter, &light);
    if (status || !(max_component(light.intensity) > 0))
        return status;
    return add_light(loader, &light);
}

/* --- the environment */

int parse_emitter_rotation(struct loader *loader, struct xml_node *emitter, double rotation[3][3]) {
    struct transform to_world;
    int status = param_transform(loader, emitter, "to_world", &to_world);
    if (status)
        return status;
    double size = cbrt(fabs(transform_determinant(&to_world)));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double product = 0;
            for (int k = 0; k < 3; k++)
                product += to_world.m[k][i] * to_world.m[k][j];
            if (!(size > 0) || !(fabs(product / (size * size) - (i == j)) <= 1e-3))
                return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED,
                                   param_find(emitter, "to_world"),
                                   "the to_world of emitter '%s' must be a rotation",
                                   xml_attribute(emitter, "type"));
            rotation[i][j] = to_world.m[i][j] / size;
        }
    return FEWRAY_OK;
}

static int parse_envmap(struct loader *loader, struct xml_node *emitter) {
    struct environment *environment = &loader->scene->environment;
    const char *filename = NULL;
    double factor = 1, rotation[3][3];
    int status = param_string(loader, emitter, "filename", &filename);
    if (!status)
        status = param_number(loader, emitter, "scale", 0, 1e30, &factor);
    if (!status)
        status = parse_emitter_rotation(loader, emitter, rotation);
    if (status)
        return status;
    if (!filename || !*filename)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter, "the envmap has no filename");
    for (int i = 0; i < 9; i++)
        environment->to_local[i] = (float)rotation[i % 3][i / 3]; /* the inverse */
    environment->kind = ENVIRONMENT_MAP;
    environment->scale = (float)factor;
    return assets_add(loader, ASSET_ENVIRONMENT, filename, emitter, &loader->environment_image);
}

static int parse_constant(struct loader *loader, struct xml_node *emitter) {
    struct environment *environment = &loader->scene->environment;
    environment->kind = ENVIRONMENT_CONSTANT;
    environment->radiance = vec(1, 1, 1);
    return param_radiance(loader, emitter, "radiance", &environment->radiance);
}

static int parse_environment(struct loader *loader, struct xml_node *emitter) {
    const char *type = xml_attribute(emitter, "type");
    if (loader->scene->environment.kind != ENVIRONMENT_NONE)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter,
                           "a second environment emitter: there can be only one");
    return !strcmp(type, "constant") ? parse_constant(loader, emitter)
           : !strcmp(type, "envmap") ? parse_envmap(loader, emitter)
                                     : parse_sunsky(loader, emitter);
}

int parse_emitter(struct loader *loader, struct xml_node *emitter) {
    const char *type = xml_attribute(emitter, "type");
    int status;
    params_ignore(emitter, ignored);
    if (!strcmp(type, "area"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter,
                           "an area emitter must stand within a shape");
    if (!strcmp(type, "point"))
        status = parse_light(loader, emitter, LIGHT_POINT);
    else if (!strcmp(type, "spot"))
        status = parse_light(loader, emitter, LIGHT_SPOT);
    else if (!strcmp(type, "directional"))
        status = parse_light(loader, emitter, LIGHT_DIRECTIONAL);
    else if (!strcmp(type, "constant") || !strcmp(type, "envmap") || !strcmp(type, "sunsky"))
        status = parse_environment(loader, emitter);
    else
        status = loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, emitter,
                             "emitter '%s' is not supported yet (--lenient leaves it out)", type);
    if (status == FEWRAY_ERROR_UNSUPPORTED && loader->lenient)
        return leave_out(loader, emitter);
    return status ? status : params_finish(loader, emitter);
}
