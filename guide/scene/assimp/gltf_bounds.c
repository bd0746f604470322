/* SPDX-License-Identifier: Apache-2.0 */
/* Whether a glTF's accessors lie within its buffers and have the types that their uses need (glTF
 * 2.0, 3.6 to 3.11): assimp 5.2 trusts most of it, and reads or writes beyond its arrays. */

#include <stdio.h>
#include <string.h>

#include "guide/scene/assimp/gltf.h"
#include "guide/scene/file_bytes.h"

/* Component types, by OpenGL's numbers, as bits. */
enum component {
    BYTE = 1 << 0,
    UNSIGNED_BYTE = 1 << 1,
    SHORT = 1 << 2,
    UNSIGNED_SHORT = 1 << 3,
    UNSIGNED_INT = 1 << 5,
    FLOAT = 1 << 6,
    ANY_COMPONENT = BYTE | UNSIGNED_BYTE | SHORT | UNSIGNED_SHORT | UNSIGNED_INT | FLOAT
};
enum { FIRST_COMPONENT = 5120, LAST_COMPONENT = 5126 };

struct bounds {
    const char *path;
    const json_t *gltf;
    struct fewray_error *error;
};

static int64_t number(const json_t *object, const char *key) {
    return json_integer_value(json_object_get(object, key)); /* 0 where there is none */
}

static int fail(const struct bounds *in, const char *what, size_t index, const char *why) {
    return fewray_fail(in->error, FEWRAY_ERROR_FORMAT, in->path, 0, "%s %zu %s", what, index, why);
}

/* The object that a member of another one names by its index; NULL: there is no such. */
static const json_t *named(const struct bounds *in, const char *array, const json_t *index) {
    return json_is_integer(index)
               ? json_array_get(json_object_get(in->gltf, array), (size_t)json_integer_value(index))
               : NULL;
}

/* Bytes of a component, 0 for none of glTF's. */
static int component_bytes(const json_t *accessor) {
    static const int bytes[] = {1, 1, 2, 2, 0, 4, 4};
    const int64_t type = number(accessor, "componentType");
    return type < FIRST_COMPONENT || type > LAST_COMPONENT ? 0 : bytes[type - FIRST_COMPONENT];
}

static int component_bit(const json_t *accessor) {
    return component_bytes(accessor) ? 1 << (number(accessor, "componentType") - FIRST_COMPONENT)
                                     : 0;
}

static int components(const json_t *accessor) {
    static const struct {
        const char *name;
        int count;
    } types[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                 {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    const char *type = json_string_value(json_object_get(accessor, "type"));
    for (size_t i = 0; type && i < sizeof(types) / sizeof(*types); i++)
        if (!strcmp(types[i].name, type))
            return types[i].count;
    return 0;
}

static bool starts_with(const char *text, const char *start) {
    return !strncmp(text, start, strlen(start));
}

/* --- buffers, views, accessors */

/* Whether a buffer's file, beside the scene, can be read at all. */
static int check_uri(const struct bounds *in, const char *uri) {
    char file[4096];
    const char *slash = strrchr(in->path, '/');
    const int folder = slash && uri[0] != '/' ? (int)(slash - in->path) + 1 : 0;
    if (starts_with(uri, "data:"))
        return FEWRAY_OK;
    snprintf(file, sizeof(file), "%.*s%s", folder, in->path, uri);
    return file_check_regular(file, in->error);
}

/* `body`: bytes of a .glb's binary chunk, which is its first buffer where that has no uri. Other
 * buffers' bytes are compared with byteLength by assimp. */
static int check_buffers(const struct bounds *in, size_t body) {
    size_t i;
    json_t *buffer;
    json_array_foreach(json_object_get(in->gltf, "buffers"), i, buffer) {
        const int64_t bytes = number(buffer, "byteLength");
        if (bytes < 1)
            return fail(in, "buffer", i, "has no byteLength");
        if (!json_object_get(buffer, "uri") && (i > 0 || (uint64_t)bytes > body))
            return fail(in, "buffer", i, "is longer than the file's binary chunk");
        const char *uri = json_string_value(json_object_get(buffer, "uri"));
        const int status = uri ? check_uri(in, uri) : FEWRAY_OK;
        if (status)
            return status;
    }
    return FEWRAY_OK;
}

static int check_views(const struct bounds *in) {
    size_t i;
    json_t *view;
    json_array_foreach(json_object_get(in->gltf, "bufferViews"), i, view) {
        const json_t *buffer = named(in, "buffers", json_object_get(view, "buffer"));
        if (!buffer || number(view, "byteLength") < 1 ||
            number(view, "byteOffset") + number(view, "byteLength") > number(buffer, "byteLength"))
            return fail(in, "bufferView", i, "lies beyond its buffer");
        if (number(view, "byteStride") > 252)
            return fail(in, "bufferView", i, "has a byteStride above 252");
    }
    return FEWRAY_OK;
}

static int check_accessors(const struct bounds *in) {
    size_t i;
    json_t *accessor;
    json_array_foreach(json_object_get(in->gltf, "accessors"), i, accessor) {
        const json_t *view = named(in, "bufferViews", json_object_get(accessor, "bufferView"));
        const int64_t item = (int64_t)component_bytes(accessor) * components(accessor);
        const int64_t stride =
            view && number(view, "byteStride") ? number(view, "byteStride") : item;
        if (json_object_get(accessor, "sparse") || !json_object_get(accessor, "bufferView"))
            return fewray_fail(in->error, FEWRAY_ERROR_UNSUPPORTED, in->path, 0,
                               "accessor %zu is sparse or has no bufferView: not supported", i);
        if (!view || item == 0 || number(accessor, "count") < 1 ||
            number(accessor, "byteOffset") + (number(accessor, "count") - 1) * stride + item >
                number(view, "byteLength"))
            return fail(in, "accessor", i, "lies beyond its bufferView, or has no known type");
    }
    return FEWRAY_OK;
}

/* --- uses of accessors */

/* The accessor at an index, where it has one of these components, so many of them and at least so
 * many items; else NULL. */
static const json_t *accessor_as(const struct bounds *in, const json_t *index, int bits, int count,
                                 int64_t items) {
    const json_t *accessor = named(in, "accessors", index);
    return accessor && (component_bit(accessor) & bits) && components(accessor) == count &&
                   number(accessor, "count") >= items
               ? accessor
               : NULL;
}

static bool is_attribute(const struct bounds *in, const char *name, const json_t *index,
                         int64_t vertices) {
    static const struct {
        const char *name;
        int bits, count, other_count;
    } known[] = {{"POSITION", FLOAT, 3, 3},
                 {"NORMAL", FLOAT, 3, 3},
                 {"TANGENT", FLOAT, 4, 3}, /* of a morph target: 3 */
                 {"TEXCOORD", FLOAT, 2, 2},
                 {"COLOR", FLOAT | UNSIGNED_BYTE | UNSIGNED_SHORT, 3, 4},
                 {"JOINTS", UNSIGNED_BYTE | UNSIGNED_SHORT, 4, 4},
                 {"WEIGHTS", FLOAT | UNSIGNED_BYTE | UNSIGNED_SHORT, 4, 4}};
    const json_t *accessor = named(in, "accessors", index);
    for (size_t i = 0; i < sizeof(known) / sizeof(*known); i++)
        if (starts_with(name, known[i].name))
            return (accessor_as(in, index, known[i].bits, known[i].count, vertices) ||
                    accessor_as(in, index, known[i].bits, known[i].other_count, vertices)) &&
                   number(accessor, "count") == vertices;
    return accessor != NULL;
}

static bool are_attributes(const struct bounds *in, const json_t *attributes, int64_t vertices) {
    const char *name;
    json_t *index;
    json_object_foreach((json_t *)attributes, name, index) {
        if (!is_attribute(in, name, index, vertices))
            return false;
    }
    return true;
}

static bool is_primitive(const struct bounds *in, const json_t *primitive) {
    const json_t *attributes = json_object_get(primitive, "attributes");
    const json_t *position = named(in, "accessors", json_object_get(attributes, "POSITION"));
    const json_t *indices = json_object_get(primitive, "indices");
    const int64_t vertices = number(position, "count");
    size_t i;
    json_t *target;
    json_array_foreach(json_object_get(primitive, "targets"), i, target) {
        if (!are_attributes(in, target, vertices))
            return false;
    }
    return (position || json_object_size(attributes) == 0) &&
           are_attributes(in, attributes, vertices) &&
           (!indices ||
            accessor_as(in, indices, UNSIGNED_BYTE | UNSIGNED_SHORT | UNSIGNED_INT, 1, 1));
}

static int check_meshes(const struct bounds *in) {
    size_t m, p;
    json_t *mesh, *primitive;
    json_array_foreach(json_object_get(in->gltf, "meshes"), m, mesh) {
        json_array_foreach(json_object_get(mesh, "primitives"), p, primitive) {
            if (!is_primitive(in, primitive))
                return fail(in, "mesh", m,
                            "has an attribute or indices of another type or count than glTF says");
        }
    }
    return FEWRAY_OK;
}

static int check_skins(const struct bounds *in) {
    size_t i;
    json_t *skin;
    json_array_foreach(json_object_get(in->gltf, "skins"), i, skin) {
        if (!accessor_as(in, json_object_get(skin, "inverseBindMatrices"), FLOAT, 16,
                         (int64_t)json_array_size(json_object_get(skin, "joints"))))
            return fail(in, "skin", i, "has no inverseBindMatrices for each of its joints");
    }
    return FEWRAY_OK;
}

/* A channel's keys: times, and values of what it moves. */
static bool is_channel(const struct bounds *in, const json_t *animation, const json_t *channel) {
    const json_t *samplers = json_object_get(animation, "samplers");
    const json_t *index = json_object_get(channel, "sampler");
    const json_t *sampler =
        json_is_integer(index) ? json_array_get(samplers, (size_t)json_integer_value(index)) : NULL;
    const json_t *target = json_object_get(channel, "target");
    const char *what = json_string_value(json_object_get(target, "path"));
    const char *between = json_string_value(json_object_get(sampler, "interpolation"));
    const json_t *times = accessor_as(in, json_object_get(sampler, "input"), FLOAT, 1, 1);
    const int64_t keys =
        number(times, "count") * (between && !strcmp(between, "CUBICSPLINE") ? 3 : 1);
    const int count = !what ? 0 : !strcmp(what, "rotation") ? 4 : !strcmp(what, "weights") ? 1 : 3;
    const int bits = count == 4 || count == 1 ? ANY_COMPONENT & ~UNSIGNED_INT : FLOAT;
    return times && accessor_as(in, json_object_get(sampler, "output"), bits, count, keys);
}

static int check_animations(const struct bounds *in) {
    size_t a, c;
    json_t *animation, *channel;
    json_array_foreach(json_object_get(in->gltf, "animations"), a, animation) {
        json_array_foreach(json_object_get(animation, "channels"), c, channel) {
            if (!is_channel(in, animation, channel))
                return fail(in, "animation", a, "has a channel without times and as many values");
        }
    }
    return FEWRAY_OK;
}

static int check_images(const struct bounds *in) {
    size_t i;
    json_t *image;
    json_array_foreach(json_object_get(in->gltf, "images"), i, image) {
        const json_t *view = json_object_get(image, "bufferView");
        if (view && !named(in, "bufferViews", view))
            return fail(in, "image", i, "names a bufferView that isn't there");
    }
    return FEWRAY_OK;
}

int gltf_check_bounds(const char *path, const json_t *gltf, size_t body,
                      struct fewray_error *error) {
    const struct bounds in = {path, gltf, error};
    int (*const checks[])(const struct bounds *in) = {check_views, check_accessors,  check_meshes,
                                                      check_skins, check_animations, check_images};
    int status = check_buffers(&in, body);
    for (size_t i = 0; i < sizeof(checks) / sizeof(*checks) && !status; i++)
        status = checks[i](&in);
    return status;
}
