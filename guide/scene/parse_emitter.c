/* SPDX-License-Identifier: Apache-2.0 */
/* Emitters: area within a shape; constant or an environment map around the scene. */

#include <string.h>

#include "guide/scene/params.h"
#include "guide/scene/transform.h"

int parse_area_emitter(struct loader *loader, struct xml_node *emitter, struct vec3 *radiance) {
    const char *type = xml_attribute(emitter, "type");
    if (strcmp(type, "area"))
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, emitter,
                           "emitter '%s' in a shape is not supported%s", type,
                           strcmp(type, "constant") && strcmp(type, "envmap")
                               ? " yet: use area"
                               : ": move it out of the shape");
    *radiance = vec(1, 1, 1);
    int status = param_radiance(loader, emitter, "radiance", radiance);
    return status ? status : params_finish(loader, emitter);
}

/* to_local = the inverse of to_world's rotation. A uniform scale makes no difference to directions;
 * anything else would. */
static int set_rotation(struct loader *loader, struct xml_node *emitter) {
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
                                   "an envmap's to_world must be a rotation");
            loader->scene->environment.to_local[3 * i + j] = (float)(to_world.m[j][i] / size);
        }
    return FEWRAY_OK;
}

static int parse_envmap(struct loader *loader, struct xml_node *emitter) {
    struct environment *environment = &loader->scene->environment;
    const char *filename = NULL;
    double factor = 1;
    int status = param_string(loader, emitter, "filename", &filename);
    if (!status)
        status = param_float(loader, emitter, "scale", &factor);
    if (!status)
        status = set_rotation(loader, emitter);
    if (status)
        return status;
    if (!filename || !*filename)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter, "the envmap has no filename");
    if (!(factor >= 0 && factor <= 1e30))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(emitter, "scale"),
                           "scale = %g must not be negative", factor);
    environment->kind = ENVIRONMENT_MAP;
    environment->scale = (float)factor;
    return assets_add(loader, ASSET_ENVIRONMENT, filename, emitter, &loader->environment_image);
}

int parse_environment(struct loader *loader, struct xml_node *emitter) {
    struct environment *environment = &loader->scene->environment;
    const char *type = xml_attribute(emitter, "type");
    int status;
    if (!strcmp(type, "area"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter,
                           "an area emitter must stand within a shape");
    if (environment->kind != ENVIRONMENT_NONE &&
        (!strcmp(type, "constant") || !strcmp(type, "envmap")))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, emitter,
                           "a second environment emitter: there can be only one");
    if (!strcmp(type, "constant")) {
        environment->kind = ENVIRONMENT_CONSTANT;
        environment->radiance = vec(1, 1, 1);
        status = param_radiance(loader, emitter, "radiance", &environment->radiance);
    } else if (!strcmp(type, "envmap")) {
        status = parse_envmap(loader, emitter);
    } else {
        status =
            loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, emitter,
                        "emitter '%s' is not supported yet: use area, constant or envmap", type);
    }
    return status ? status : params_finish(loader, emitter);
}
