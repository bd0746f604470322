/* SPDX-License-Identifier: Apache-2.0 */
/* From a .gltf or .glb file to its JSON, checked. */

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/assimp/gltf.h"
#include "guide/scene/file_bytes.h"

#define GLB_MAGIC 0x46546C67u /* "glTF" */
#define GLB_JSON  0x4E4F534Au /* "JSON" */
#define GLB_BODY  0x004E4942u /* "BIN" */

/* assimp descends nodes by recursion. */
#define MAX_DEPTH 500

static uint32_t word(const char *bytes) {
    uint32_t value;
    memcpy(&value, bytes, sizeof(value));
    return value;
}

/* The JSON's place in the file: all of a .gltf, the first chunk of a .glb. */
static int find_json(const char *path, const struct file_bytes *file, const char **text,
                     size_t *size, struct fewray_error *error) {
    *text = file->data;
    *size = file->size;
    if (file->size < 20 || word(file->data) != GLB_MAGIC)
        return FEWRAY_OK;
    if (word(file->data + 4) != 2)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                           "glTF version %u is not supported: only version 2 is",
                           word(file->data + 4));
    *size = word(file->data + 12);
    *text = file->data + 20;
    if (word(file->data + 16) != GLB_JSON || *size > file->size - 20)
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                           "the glb file is cut off or damaged: it has no whole JSON chunk");
    return FEWRAY_OK;
}

/* Bytes of the binary chunk behind the JSON; 0: there is none. */
static size_t find_body(const struct file_bytes *file, const char *text, size_t size) {
    if (text == file->data)
        return 0;
    const size_t at = (size_t)(text - file->data) + size;
    if (file->size - at < 8 || word(file->data + at + 4) != GLB_BODY)
        return 0;
    const size_t body = word(file->data + at);
    return body <= file->size - at - 8 ? body : 0;
}

static int check_version(const char *path, const json_t *gltf, struct fewray_error *error) {
    const char *version =
        json_string_value(json_object_get(json_object_get(gltf, "asset"), "version"));
    if (!version)
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                           "not a glTF file: it has no asset.version");
    if (version[0] != '2')
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                           "glTF version %.20s is not supported: only version 2 is", version);
    return FEWRAY_OK;
}

static int check_extensions(const char *path, const json_t *gltf, struct fewray_error *error) {
    static const char *const known[] = {"KHR_lights_punctual",
                                        "KHR_materials_emissive_strength",
                                        "KHR_materials_transmission",
                                        "KHR_materials_ior",
                                        "KHR_materials_clearcoat",
                                        "KHR_materials_unlit",
                                        "KHR_texture_transform",
                                        "KHR_draco_mesh_compression",
                                        "KHR_materials_volume",
                                        "KHR_materials_specular",
                                        "KHR_materials_sheen",
                                        "KHR_materials_iridescence",
                                        "KHR_materials_variants",
                                        "KHR_materials_anisotropy",
                                        "KHR_materials_dispersion",
                                        "KHR_xmp_json_ld",
                                        NULL};
    size_t i;
    json_t *value;
    json_array_foreach(json_object_get(gltf, "extensionsRequired"), i, value) {
        const char *name = json_string_value(value);
        int k = 0;
        while (name && known[k] && strcmp(known[k], name))
            k++;
        if (!name || !known[k])
            return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                               "the file needs the extension %.100s, which is not supported",
                               name ? name : "(no name)");
    }
    return FEWRAY_OK;
}

/* Each node is reached once at most, and not too deep. */
static bool check_node(const json_t *nodes, const json_t *index, int depth, bool *seen) {
    const json_t *node = NULL;
    size_t i;
    json_t *child;
    if (json_is_integer(index) && json_integer_value(index) >= 0)
        node = json_array_get(nodes, (size_t)json_integer_value(index));
    if (!json_is_object(node) || depth > MAX_DEPTH || seen[json_integer_value(index)])
        return false;
    seen[json_integer_value(index)] = true;
    json_array_foreach(json_object_get(node, "children"), i, child) {
        if (!check_node(nodes, child, depth + 1, seen))
            return false;
    }
    return true;
}

/* Every node, for assimp reads those out of the scene as well where a skin names them. */
static int check_nodes(const char *path, const json_t *gltf, struct fewray_error *error) {
    const json_t *nodes = json_object_get(gltf, "nodes"), *scene = gltf_scene(gltf);
    size_t i;
    json_t *root;
    if (!scene || json_array_size(json_object_get(scene, "nodes")) == 0)
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0, "the file has no scene with nodes");
    bool *seen = calloc(json_array_size(nodes) + 1, sizeof(*seen)), sound = true;
    if (!seen)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    json_array_foreach(json_object_get(scene, "nodes"), i, root) {
        sound = sound && check_node(nodes, root, 0, seen);
    }
    free(seen);
    if (!sound)
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                           "its nodes are not a tree of at most %d levels", MAX_DEPTH);
    return FEWRAY_OK;
}

/* assimp reads integer texture coordinates and skins without matrices out of bounds. */
static int check_for_assimp(const char *path, const json_t *gltf, struct fewray_error *error) {
    const json_t *accessors = json_object_get(gltf, "accessors");
    size_t m, p;
    json_t *mesh, *primitive, *skin, *index;
    const char *key;
    json_array_foreach(json_object_get(gltf, "skins"), m, skin) {
        if (!json_is_integer(json_object_get(skin, "inverseBindMatrices")))
            return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                               "a skin without inverseBindMatrices is not supported");
    }
    json_array_foreach(json_object_get(gltf, "meshes"), m, mesh) {
        json_array_foreach(json_object_get(mesh, "primitives"), p, primitive) {
            json_object_foreach(json_object_get(primitive, "attributes"), key, index) {
                const json_t *accessor =
                    json_is_integer(index) && json_integer_value(index) >= 0
                        ? json_array_get(accessors, (size_t)json_integer_value(index))
                        : NULL;
                if ((!strncmp(key, "TEXCOORD", 8) || !strcmp(key, "POSITION") ||
                     !strcmp(key, "NORMAL")) &&
                    json_integer_value(json_object_get(accessor, "componentType")) != 5126)
                    return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                                       "%.40s of mesh %zu is not of floats: not supported", key, m);
            }
        }
    }
    return FEWRAY_OK;
}

int gltf_read(const char *path, json_t **out, struct fewray_error *error) {
    struct file_bytes file;
    const char *text;
    size_t size, body = 0;
    json_error_t reason;
    *out = NULL;
    int status = file_read(path, &file, error);
    if (status)
        return status;
    status = find_json(path, &file, &text, &size, error);
    json_t *gltf = status ? NULL : json_loadb(text, size, 0, &reason);
    if (!status)
        body = find_body(&file, text, size);
    file_free(&file);
    if (!status && !json_is_object(gltf))
        status = fewray_fail(error, FEWRAY_ERROR_FORMAT, path, gltf ? 0 : reason.line,
                             "not a glTF file: %.200s", gltf ? "no JSON object" : reason.text);
    if (!status)
        status = check_version(path, gltf, error);
    if (!status)
        status = gltf_check_types(path, gltf, error);
    if (!status)
        status = check_extensions(path, gltf, error);
    if (!status)
        status = check_nodes(path, gltf, error);
    if (!status)
        status = check_for_assimp(path, gltf, error);
    if (!status)
        status = gltf_check_bounds(path, gltf, body, error);
    if (status)
        json_decref(gltf);
    else
        *out = gltf;
    return status;
}
