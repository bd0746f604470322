/* SPDX-License-Identifier: Apache-2.0 */
/* The JSON of a glTF file. */

#include "guide/scene/assimp/gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/file_bytes.h"

/* glTF 2.0, 3.7.2.1: lumens of a watt of light at 555 nm. */
#define LUMENS_PER_WATT 683.0

/* Member of an object, or NULL; of anything else NULL. */
static const json_t *at(const json_t *array, const json_t *index) {
    if (!json_is_integer(index) || json_integer_value(index) < 0)
        return NULL;
    return json_array_get(array, (size_t)json_integer_value(index));
}

static double number(const json_t *object, const char *key, double fallback) {
    const json_t *value = json_object_get(object, key);
    double x = json_is_number(value) ? json_number_value(value) : fallback;
    return isfinite(x) ? x : fallback;
}

static double item(const json_t *object, const char *key, size_t index, double fallback) {
    const json_t *value = json_array_get(json_object_get(object, key), index);
    double x = json_is_number(value) ? json_number_value(value) : fallback;
    return isfinite(x) ? x : fallback;
}

static const json_t *extension(const json_t *object, const char *name) {
    return json_object_get(json_object_get(object, "extensions"), name);
}

const json_t *gltf_scene(const json_t *gltf) {
    const json_t *index = json_object_get(gltf, "scene"), *scenes = json_object_get(gltf, "scenes");
    return index ? at(scenes, index) : json_array_get(scenes, 0);
}

const json_t *gltf_root(const json_t *gltf, size_t index) {
    return at(json_object_get(gltf, "nodes"),
              json_array_get(json_object_get(gltf_scene(gltf), "nodes"), index));
}

const json_t *gltf_child(const json_t *gltf, const json_t *node, size_t index) {
    return at(json_object_get(gltf, "nodes"),
              json_array_get(json_object_get(node, "children"), index));
}

size_t gltf_child_count(const json_t *parent, const char *key) {
    return json_array_size(json_object_get(parent, key));
}

static const json_t *primitives(const json_t *gltf, const json_t *node) {
    return json_object_get(at(json_object_get(gltf, "meshes"), json_object_get(node, "mesh")),
                           "primitives");
}

size_t gltf_primitive_count(const json_t *gltf, const json_t *node) {
    return json_array_size(primitives(gltf, node));
}

const json_t *gltf_primitive_material(const json_t *gltf, const json_t *node, size_t primitive) {
    return at(json_object_get(gltf, "materials"),
              json_object_get(json_array_get(primitives(gltf, node), primitive), "material"));
}

bool gltf_node_camera(const json_t *gltf, const json_t *node, double *fov_y, double *aspect,
                      bool *orthographic) {
    const json_t *camera = at(json_object_get(gltf, "cameras"), json_object_get(node, "camera"));
    const json_t *perspective = json_object_get(camera, "perspective");
    *orthographic = camera && !perspective;
    *fov_y = number(perspective, "yfov", 0);
    *aspect = number(perspective, "aspectRatio", 0);
    return *fov_y > 1e-4 && *fov_y < 3.14;
}

static struct vec3 axis_of(const struct transform *to_world, int column, double sign) {
    const double(*m)[4] = to_world->m;
    double x = m[0][column], y = m[1][column], z = m[2][column], l = sqrt(x * x + y * y + z * z);
    return l > 0 ? vec((float)(sign * x / l), (float)(sign * y / l), (float)(sign * z / l))
                 : vec(0, 0, (float)sign);
}

bool gltf_node_light(const json_t *gltf, const json_t *node, const struct transform *to_world,
                     struct light *out) {
    const char *name = "KHR_lights_punctual";
    const json_t *light = at(json_object_get(extension(gltf, name), "lights"),
                             json_object_get(extension(node, name), "light"));
    const char *type = json_string_value(json_object_get(light, "type"));
    if (!type)
        return false;
    double intensity = fmax(number(light, "intensity", 1), 0) / LUMENS_PER_WATT;
    float color[3];
    for (size_t i = 0; i < 3; i++)
        color[i] = (float)fmin(intensity * fmax(item(light, "color", i, 1), 0), 1e30);
    *out = (struct light){
        .kind = LIGHT_POINT,
        .position =
            vec((float)to_world->m[0][3], (float)to_world->m[1][3], (float)to_world->m[2][3]),
        .direction = axis_of(to_world, 2, -1),
        .intensity = vec(color[0], color[1], color[2]),
    };
    if (!strcmp(type, "directional")) {
        out->kind = LIGHT_DIRECTIONAL;
    } else if (!strcmp(type, "spot")) {
        const json_t *spot = json_object_get(light, "spot");
        double outer = fmin(fmax(number(spot, "outerConeAngle", 0.78539816339), 1e-3), 1.5707963);
        double inner = fmax(number(spot, "innerConeAngle", 0), 0);
        out->kind = LIGHT_SPOT;
        out->cutoff = (float)outer;
        out->beam_width = (float)fmin(inner, outer * 0.9999);
    }
    return strcmp(type, "point") == 0 || out->kind != LIGHT_POINT;
}

double gltf_emissive_strength(const json_t *material) {
    return fmax(
        number(extension(material, "KHR_materials_emissive_strength"), "emissiveStrength", 1), 0);
}

void gltf_texture_transform(const json_t *material, const char *group, const char *name,
                            float to_uv[6]) {
    const json_t *texture =
        json_object_get(group ? json_object_get(material, group) : material, name);
    const json_t *transform = extension(texture, "KHR_texture_transform");
    double angle = number(transform, "rotation", 0), c = cos(angle), s = sin(angle);
    double scale_u = item(transform, "scale", 0, 1), scale_v = item(transform, "scale", 1, 1);
    const double rows[6] = {c * scale_u,  s * scale_v, item(transform, "offset", 0, 0),
                            -s * scale_u, c * scale_v, item(transform, "offset", 1, 0)};
    for (int i = 0; i < 6; i++)
        to_uv[i] = (float)rows[i];
}

static bool has_targets(const json_t *mesh) {
    size_t i;
    json_t *primitive;
    json_array_foreach(json_object_get(mesh, "primitives"), i, primitive) {
        if (json_object_get(primitive, "targets"))
            return true;
    }
    return false;
}

bool gltf_deforms(const json_t *gltf) {
    size_t i;
    json_t *mesh;
    json_array_foreach(json_object_get(gltf, "meshes"), i, mesh) {
        if (has_targets(mesh))
            return true;
    }
    return json_array_size(json_object_get(gltf, "skins")) > 0;
}
