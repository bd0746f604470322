/* SPDX-License-Identifier: Apache-2.0 */
/* Sensors of perspective and thin lenses, their film and sampler. */

#include <string.h>

#include "guide/scene/number.h"
#include "guide/scene/params.h"
#include "guide/scene/plugins.h"
#include "guide/scene/transform.h"

/* Film sizes beyond this are a mistake, and would overflow pixel counts. */
#define MAX_FILM 65536
/* Tangent of half the field of view; floats can't tell what is much more from 180 degrees. */
#define MAX_HALF_WIDTH 1e6f

static int warn_rfilter(struct loader *loader, struct xml_node *rfilter) {
    const char *type = xml_attribute(rfilter, "type");
    params_ignore_all(rfilter);
    if (!strcmp(type, "box"))
        return FEWRAY_OK;
    return loader_warn(loader, rfilter, "rfilter '%s' is rendered as a box filter", type);
}

static int parse_film(struct loader *loader, struct xml_node *film) {
    static const char *const ignored[] = {
        "pixel_format", "component_format", "file_format",        "sample_border",
        "compensate",   "banner",           "high_quality_edges", NULL};
    static const char *const crops[] = {"crop_width", "crop_height", "crop_offset_x",
                                        "crop_offset_y", NULL};
    struct camera *camera = &loader->scene->camera;
    const char *type = xml_attribute(film, "type");
    if (strcmp(type, "hdrfilm"))
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, film,
                           "film '%s' is not supported yet: use hdrfilm", type);
    for (int i = 0; crops[i]; i++) {
        struct xml_node *crop = param_find(film, crops[i]);
        if (crop)
            return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, crop,
                               "%s: cropped films are not supported yet", crops[i]);
    }
    int status = param_integer(loader, film, "width", 1, &camera->width);
    if (!status)
        status = param_integer(loader, film, "height", 1, &camera->height);
    if (!status && (camera->width > MAX_FILM || camera->height > MAX_FILM))
        status = loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, film,
                             "a film of %d x %d pixels: at most %d a side", camera->width,
                             camera->height, MAX_FILM);
    params_ignore(film, ignored);
    for (struct xml_node *child = film->first_child; child && !status; child = child->next) {
        struct xml_node *object;
        status = loader_resolve(loader, child, &object);
        if (!status && object && !strcmp(object->tag, "rfilter")) {
            child->used = true;
            status = warn_rfilter(loader, object);
        }
    }
    return status ? status : params_finish(loader, film);
}

static int parse_sampler(struct loader *loader, struct xml_node *sampler) {
    static const char *const ignored[] = {"seed", "jitter", NULL};
    params_ignore(sampler, ignored);
    int status = param_integer(loader, sampler, "sample_count", 1, &loader->scene->sample_count);
    return status ? status : params_finish(loader, sampler);
}

/* The field of view along x, radians, from one along another axis; as Mitsuba's parse_fov(). */
static double horizontal_fov(double fov, const char *axis, double aspect) {
    double tangent = tan(fov / 2);
    if (!strcmp(axis, "y") || (!strcmp(axis, "smaller") && aspect > 1) ||
        (!strcmp(axis, "larger") && aspect <= 1))
        return 2 * atan(tangent * aspect);
    if (!strcmp(axis, "diagonal"))
        return 2 * atan(tangent / sqrt(1 + 1 / (aspect * aspect)));
    return fov;
}

/* A 35 mm film's diagonal over the focal length ("50mm"). */
static int parse_focal_length(struct loader *loader, struct xml_node *sensor, double *fov) {
    const char *text = "50mm";
    double length_mm = 0;
    int status = param_string(loader, sensor, "focal_length", &text);
    if (status)
        return status;
    const char *end = text;
    if (!number_read(&end, &length_mm) || (*end && strcmp(end, "mm")) ||
        !(length_mm > 0 && length_mm < 1e6))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(sensor, "focal_length"),
                           "focal_length = '%s' should look like 50mm", text);
    *fov = 2 * atan(sqrt(36.0 * 36.0 + 24.0 * 24.0) / (2 * length_mm));
    return FEWRAY_OK;
}

static int parse_fov(struct loader *loader, struct xml_node *sensor) {
    struct camera *camera = &loader->scene->camera;
    const char *axis = "x";
    double fov = 0;
    struct xml_node *fov_node = param_find(sensor, "fov");
    int status = param_string(loader, sensor, "fov_axis", &axis);
    if (status)
        return status;
    if (fov_node) {
        double degrees = 0;
        if (param_find(sensor, "focal_length"))
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, fov_node,
                               "both fov and focal_length are given");
        status = param_float(loader, sensor, "fov", &degrees);
        if (!status && !(degrees > 0 && degrees < 180))
            status = loader_fail(loader, FEWRAY_ERROR_FORMAT, fov_node,
                                 "fov = %g must lie between 0 and 180 degrees", degrees);
        fov = degrees * (3.14159265358979323846 / 180);
    } else {
        status = parse_focal_length(loader, sensor, &fov);
        axis = "diagonal";
    }
    if (status)
        return status;
    if (strcmp(axis, "x") && strcmp(axis, "y") && strcmp(axis, "diagonal") &&
        strcmp(axis, "smaller") && strcmp(axis, "larger"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(sensor, "fov_axis"),
                           "fov_axis = '%s' should be x, y, diagonal, smaller or larger", axis);
    camera->fov_x =
        (float)horizontal_fov(fov, axis, (double)camera->width / (double)camera->height);
    float half = tanf(0.5f * camera->fov_x);
    if (!(half > 0 && half < MAX_HALF_WIDTH))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, fov_node ? fov_node : sensor,
                           "the field of view is too near to 0 or 180 degrees");
    return FEWRAY_OK;
}

static int parse_camera_transform(struct loader *loader, struct xml_node *sensor) {
    struct xml_node *animation = param_find(sensor, "to_world");
    if (animation && element_kind(animation->tag) == ELEMENT_ANIMATION)
        return parse_camera_animation(loader, animation);
    struct transform to_world;
    int status = param_transform(loader, sensor, "to_world", &to_world);
    if (status)
        return status;
    for (int j = 0; j < 3; j++) {
        double squared = 0;
        for (int i = 0; i < 3; i++)
            squared += to_world.m[i][j] * to_world.m[i][j];
        if (!(fabs(squared - 1) <= 1e-3))
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(sensor, "to_world"),
                               "the sensor's to_world must not scale");
    }
    if (!(fabs(transform_determinant(&to_world)) > 1e-3))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(sensor, "to_world"),
                           "the sensor's to_world is singular: its axes lie in one plane");
    for (int i = 0; i < 12; i++)
        loader->scene->camera.to_world[i] = (float)to_world.m[i / 4][i % 4];
    return FEWRAY_OK;
}

/* The optical axis away from the picture's middle. */
static int parse_offsets(struct loader *loader, struct xml_node *sensor) {
    struct camera *camera = &loader->scene->camera;
    double x = 0, y = 0;
    int status = param_number(loader, sensor, "principal_point_offset_x", -1e3, 1e3, &x);
    if (!status)
        status = param_number(loader, sensor, "principal_point_offset_y", -1e3, 1e3, &y);
    camera->principal_x = (float)x;
    camera->principal_y = (float)y;
    return status;
}

/* Only a thin lens blurs; it is focused on the far clipping plane unless told. */
static int parse_lens(struct loader *loader, struct xml_node *sensor) {
    struct camera *camera = &loader->scene->camera;
    double radius = 0, far_clip = 1e4, distance;
    if (!param_find(sensor, "aperture_radius"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, sensor,
                           "the thinlens has no aperture_radius");
    int status = param_number(loader, sensor, "aperture_radius", 0, 1e30, &radius);
    if (!status)
        status = param_number(loader, sensor, "far_clip", 1e-30, 1e30, &far_clip);
    distance = far_clip;
    if (!status)
        status = param_number(loader, sensor, "focus_distance", 1e-30, 1e30, &distance);
    camera->aperture_radius = (float)radius;
    camera->focus_distance = (float)distance;
    return status;
}

int parse_sensor(struct loader *loader, struct xml_node *sensor) {
    static const char *const ignored[] = {
        "near_clip",         "far_clip", "focus_distance", "shutter_open", "shutter_close",
        "shutter_open_time", NULL};
    const char *type = xml_attribute(sensor, "type");
    bool thin_lens = !strcmp(type, "thinlens");
    if (strcmp(type, "perspective") && !thin_lens)
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, sensor,
                           "sensor '%s' is not supported yet: use perspective or thinlens", type);
    params_ignore(sensor, ignored);
    int status = FEWRAY_OK;
    for (struct xml_node *child = sensor->first_child; child && !status; child = child->next) {
        struct xml_node *object;
        status = loader_resolve(loader, child, &object);
        if (status || !object)
            continue;
        if (!strcmp(object->tag, "film"))
            status = parse_film(loader, object);
        else if (!strcmp(object->tag, "sampler"))
            status = parse_sampler(loader, object);
        else
            continue;
        child->used = true;
    }
    if (!status)
        status = parse_fov(loader, sensor);
    if (!status)
        status = parse_camera_transform(loader, sensor);
    if (!status)
        status = thin_lens ? parse_lens(loader, sensor) : parse_offsets(loader, sensor);
    return status ? status : params_finish(loader, sensor);
}
