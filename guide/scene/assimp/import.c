/* SPDX-License-Identifier: Apache-2.0 */
/* glTF and OBJ scenes: the main path, and messages. */

#include "guide/scene/assimp/import.h"
#include "guide/scene/assimp/import_scene.h"

#include <assimp/postprocess.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "features/module.h"
#include "guide/scene/file_bytes.h"
#include "guide/scene/memory.h"

static const char *suffix(const char *path) {
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    return dot ? dot : "";
}

static bool is_obj(const char *path) {
    return !strcasecmp(suffix(path), ".obj");
}

bool import_knows(const char *path) {
    return is_obj(path) || !strcasecmp(suffix(path), ".gltf") || !strcasecmp(suffix(path), ".glb");
}

int import_fail(struct import *import, enum fewray_status status, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    return fewray_fail(import->error, status, import->path, 0, "%s", text);
}

int import_fail_memory(struct import *import) {
    return import_fail(import, FEWRAY_ERROR_MEMORY, "out of memory");
}

int import_warn(struct import *import, const char *format, ...) {
    struct fewray_scene *scene = import->scene;
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    size_t size = strlen(import->path) + strlen(text) + 3;
    char *line = malloc(size);
    if (!line || !array_reserve((void **)&scene->warnings, &import->warning_capacity,
                                (size_t)scene->warning_count + 1, sizeof(*scene->warnings))) {
        free(line);
        return import_fail_memory(import);
    }
    snprintf(line, size, "%s: %s", import->path, text);
    for (char *c = line; *c; c++)
        if ((unsigned char)*c < ' ')
            *c = ' ';
    for (int i = 0; i < scene->warning_count; i++)
        if (!strcmp(scene->warnings[i], line)) {
            free(line);
            return FEWRAY_OK;
        }
    scene->warnings[scene->warning_count++] = line;
    return FEWRAY_OK;
}

static int read_source(struct import *import) {
    unsigned flags = aiProcess_Triangulate | aiProcess_FlipUVs;
    int status = FEWRAY_OK;
    if (access(import->path, R_OK))
        return import_fail(import, FEWRAY_ERROR_IO, "can't read the file");
    if ((status = file_check_regular(import->path, import->error)))
        return status;
    if (is_obj(import->path)) {
        flags |= aiProcess_JoinIdenticalVertices;
        status = import_check_mtl(import);
    } else {
        status = gltf_read(import->path, &import->gltf, import->error);
    }
    if (status)
        return status;
    import->source = import->assimp->import_file(import->path, flags);
    if (!import->source)
        return import_fail(import, FEWRAY_ERROR_FORMAT, "can't read the scene: %.400s",
                           import->assimp->error_string());
    if (!import->source->mRootNode)
        return import_fail(import, FEWRAY_ERROR_FORMAT, "the scene is empty");
    return FEWRAY_OK;
}

static int create(struct import *import) {
    import->scene = calloc(1, sizeof(*import->scene));
    if (!import->scene || !(import->scene->path = strdup(import->path)))
        return import_fail_memory(import);
    import->scene->max_depth = 8;
    import->scene->rr_depth = 5;
    import->scene->sample_count = 4;
    return FEWRAY_OK;
}

static int convert(struct import *import) {
    size_t meshes = import->source->mNumMeshes;
    import->materials =
        calloc(import->source->mNumMaterials + (size_t)1, sizeof(*import->materials));
    import->mesh_uses = calloc(meshes + 1, sizeof(int));
    import->mesh_groups = calloc(meshes + 1, sizeof(int));
    if (!import->materials || !import->mesh_uses || !import->mesh_groups)
        return import_fail_memory(import);
    int status = import_nodes(import);
    if (!status)
        status = import_read_images(import);
    return status ? status : import_view(import);
}

static void finish(struct import *import) {
    if (import->source)
        import->assimp->release(import->source);
    for (int i = 0; i < import->image_count; i++) {
        free(import->images[i].path);
        fewray_image_destroy(&import->images[i].image);
    }
    json_decref(import->gltf);
    free(import->images);
    free(import->texture_images);
    free(import->materials);
    free(import->mesh_uses);
    free(import->mesh_groups);
    fewray_scene_destroy(&import->scene);
}

int import_scene(const char *path, int threads, struct fewray_scene **out,
                 struct fewray_error *error) {
    struct import import = {.path = path, .error = error, .threads = threads};
    *out = NULL;
    import.assimp = fewray_module_symbol("assimp", "fewray_assimp", error);
    int status = import.assimp ? create(&import) : FEWRAY_ERROR_UNSUPPORTED;
    if (!status)
        status = read_source(&import);
    if (!status)
        status = convert(&import);
    if (!status) {
        *out = import.scene;
        import.scene = NULL;
    }
    finish(&import);
    return status;
}
