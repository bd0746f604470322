/* SPDX-License-Identifier: Apache-2.0 */
/* Types of glTF's members (glTF 2.0, appendix "JSON Schema Reference"), before assimp reads them:
 * it aborts the process where one is of another type. */

#include <string.h>

#include "guide/scene/assimp/gltf.h"

#define MAX_DEPTH 64

enum type { NUMBER, INTEGER, STRING, OBJECT, NUMBERS, INTEGERS, OBJECTS };
static const char *const type_names[] = {
    [NUMBER] = "a number",
    [INTEGER] = "a whole number, 0 or more",
    [STRING] = "a string",
    [OBJECT] = "an object",
    [NUMBERS] = "an array of numbers, as many as glTF says",
    [INTEGERS] = "an array of whole numbers, 0 or more",
    [OBJECTS] = "an array of objects",
};

/* Members that have different types in different places come with the name of the object around
 * (of the array, for objects in one), and stand before those without. */
static const struct rule {
    const char *parent, *key;
    enum type type;
    size_t count; /* of NUMBERS; 0: any */
} rules[] = {
    {"", "nodes", OBJECTS, 0},
    {"scenes", "nodes", INTEGERS, 0},
    {"nodes", "scale", NUMBERS, 3},
    {"nodes", "rotation", NUMBERS, 4},
    {"nodes", "weights", NUMBERS, 0},
    {"KHR_texture_transform", "scale", NUMBERS, 2},
    {"KHR_texture_transform", "rotation", NUMBER, 0},
    {"sparse", "indices", OBJECT, 0},
    {"sparse", "values", OBJECT, 0},
    {"channels", "target", OBJECT, 0},
    {"KHR_materials_pbrSpecularGlossiness", "specularFactor", NUMBERS, 3},
    {"lights", "color", NUMBERS, 3},
    {"lights", "spot", OBJECT, 0},
    {"", "scene", INTEGER, 0},
    {NULL, "accessors", OBJECTS, 0},
    {NULL, "animations", OBJECTS, 0},
    {NULL, "asset", OBJECT, 0},
    {NULL, "attenuationColor", NUMBERS, 3},
    {NULL, "attributes", OBJECT, 0},
    {NULL, "baseColorFactor", NUMBERS, 4},
    {NULL, "baseColorTexture", OBJECT, 0},
    {NULL, "buffer", INTEGER, 0},
    {NULL, "bufferView", INTEGER, 0},
    {NULL, "bufferViews", OBJECTS, 0},
    {NULL, "buffers", OBJECTS, 0},
    {NULL, "byteLength", INTEGER, 0},
    {NULL, "byteOffset", INTEGER, 0},
    {NULL, "byteStride", INTEGER, 0},
    {NULL, "camera", INTEGER, 0},
    {NULL, "cameras", OBJECTS, 0},
    {NULL, "channels", OBJECTS, 0},
    {NULL, "children", INTEGERS, 0},
    {NULL, "clearcoatFactor", NUMBER, 0},
    {NULL, "clearcoatNormalTexture", OBJECT, 0},
    {NULL, "clearcoatRoughnessTexture", OBJECT, 0},
    {NULL, "clearcoatTexture", OBJECT, 0},
    {NULL, "componentType", INTEGER, 0},
    {NULL, "count", INTEGER, 0},
    {NULL, "diffuseFactor", NUMBERS, 4},
    {NULL, "diffuseTexture", OBJECT, 0},
    {NULL, "emissiveFactor", NUMBERS, 3},
    {NULL, "emissiveTexture", OBJECT, 0},
    {NULL, "extensions", OBJECT, 0},
    {NULL, "images", OBJECTS, 0},
    {NULL, "index", INTEGER, 0},
    {NULL, "indices", INTEGER, 0},
    {NULL, "inverseBindMatrices", INTEGER, 0},
    {NULL, "joints", INTEGERS, 0},
    {NULL, "light", INTEGER, 0},
    {NULL, "lights", OBJECTS, 0},
    {NULL, "material", INTEGER, 0},
    {NULL, "materials", OBJECTS, 0},
    {NULL, "matrix", NUMBERS, 16},
    {NULL, "max", NUMBERS, 0},
    {NULL, "mesh", INTEGER, 0},
    {NULL, "meshes", OBJECTS, 0},
    {NULL, "metallicFactor", NUMBER, 0},
    {NULL, "metallicRoughnessTexture", OBJECT, 0},
    {NULL, "mimeType", STRING, 0},
    {NULL, "min", NUMBERS, 0},
    {NULL, "mode", INTEGER, 0},
    {NULL, "name", STRING, 0},
    {NULL, "normalTexture", OBJECT, 0},
    {NULL, "occlusionTexture", OBJECT, 0},
    {NULL, "offset", NUMBERS, 2},
    {NULL, "orthographic", OBJECT, 0},
    {NULL, "pbrMetallicRoughness", OBJECT, 0},
    {NULL, "perspective", OBJECT, 0},
    {NULL, "primitives", OBJECTS, 0},
    {NULL, "roughnessFactor", NUMBER, 0},
    {NULL, "sampler", INTEGER, 0},
    {NULL, "samplers", OBJECTS, 0},
    {NULL, "scenes", OBJECTS, 0},
    {NULL, "sheenColorFactor", NUMBERS, 3},
    {NULL, "sheenColorTexture", OBJECT, 0},
    {NULL, "sheenRoughnessTexture", OBJECT, 0},
    {NULL, "skeleton", INTEGER, 0},
    {NULL, "skin", INTEGER, 0},
    {NULL, "skins", OBJECTS, 0},
    {NULL, "source", INTEGER, 0},
    {NULL, "sparse", OBJECT, 0},
    {NULL, "specularGlossinessTexture", OBJECT, 0},
    {NULL, "targets", OBJECTS, 0},
    {NULL, "texCoord", INTEGER, 0},
    {NULL, "textures", OBJECTS, 0},
    {NULL, "thicknessTexture", OBJECT, 0},
    {NULL, "translation", NUMBERS, 3},
    {NULL, "transmissionTexture", OBJECT, 0},
    {NULL, "type", STRING, 0},
    {NULL, "uri", STRING, 0},
    {"meshes", "weights", NUMBERS, 0},
};

static bool is_of(const json_t *value, enum type type, size_t count) {
    size_t i;
    json_t *element;
    switch (type) {
    case NUMBER:
        return json_is_number(value);
    case INTEGER:
        return json_is_integer(value) && json_integer_value(value) >= 0 &&
               json_integer_value(value) <= 0xffffffffLL;
    case STRING:
        return json_is_string(value);
    case OBJECT:
        return json_is_object(value);
    default:
        break;
    }
    if (!json_is_array(value) || (count > 0 && json_array_size(value) != count))
        return false;
    json_array_foreach(value, i, element) {
        if (!is_of(element, type == NUMBERS ? NUMBER : type == INTEGERS ? INTEGER : OBJECT, 0))
            return false;
    }
    return true;
}

static const struct rule *find_rule(const char *parent, const char *key) {
    for (size_t i = 0; i < sizeof(rules) / sizeof(*rules); i++)
        if (!strcmp(rules[i].key, key) && (!rules[i].parent || !strcmp(rules[i].parent, parent)))
            return &rules[i];
    return NULL;
}

/* Attributes of a primitive and of its morph targets are all accessors, whatever their names. */
static bool holds_integers(const char *name) {
    return !strcmp(name, "attributes") || !strcmp(name, "targets");
}

static int check_object(const char *path, const json_t *object, const char *name, int depth,
                        struct fewray_error *error);

static int check_value(const char *path, const json_t *value, const char *name, int depth,
                       struct fewray_error *error) {
    size_t i;
    json_t *element;
    int status = FEWRAY_OK;
    if (json_is_object(value))
        return check_object(path, value, name, depth + 1, error);
    json_array_foreach(value, i, element) {
        if (!status && json_is_object(element))
            status = check_object(path, element, name, depth + 1, error);
    }
    return status;
}

static int check_object(const char *path, const json_t *object, const char *name, int depth,
                        struct fewray_error *error) {
    const char *key;
    json_t *value;
    if (depth > MAX_DEPTH)
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0, "its JSON is nested too deeply");
    json_object_foreach((json_t *)object, key, value) {
        static const struct rule accessor = {"attributes", "", INTEGER, 0};
        const struct rule *rule = holds_integers(name) ? &accessor : find_rule(name, key);
        if (!strcmp(key, "extras"))
            continue;
        if (rule && !is_of(value, rule->type, rule->count))
            return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0, "%.60s of %.60s must be %s",
                               key, name[0] ? name : "the file", type_names[rule->type]);
        int status = check_value(path, value, key, depth, error);
        if (status)
            return status;
    }
    return FEWRAY_OK;
}

int gltf_check_types(const char *path, const json_t *gltf, struct fewray_error *error) {
    return check_object(path, gltf, "", 0, error);
}
