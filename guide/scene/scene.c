/* SPDX-License-Identifier: Apache-2.0 */
/* A scene's end, and what it holds in numbers. */

#include "guide/scene/scene.h"

#include <stdlib.h>

void fewray_scene_destroy(struct fewray_scene **scene) {
    struct fewray_scene *s = *scene;
    if (!s)
        return;
    for (int i = 0; i < s->mesh_count; i++) {
        free(s->meshes[i].id);
        free(s->meshes[i].positions);
        free(s->meshes[i].normals);
        free(s->meshes[i].uvs);
        free(s->meshes[i].indices);
    }
    for (int i = 0; i < s->image_count; i++)
        fewray_image_destroy(&s->images[i]);
    for (int i = 0; i < s->warning_count; i++)
        free(s->warnings[i]);
    free(s->meshes);
    free(s->images);
    free(s->warnings);
    free(s->textures);
    free(s->bsdfs);
    free(s->path);
    free(s);
    *scene = NULL;
}

struct fewray_scene_summary fewray_scene_summarize(const struct fewray_scene *scene) {
    struct fewray_scene_summary summary = {
        .width = scene->camera.width,
        .height = scene->camera.height,
        .max_depth = scene->max_depth,
        .sample_count = scene->sample_count,
        .meshes = scene->mesh_count,
        .materials = scene->bsdf_count,
        .emitters = scene->environment.kind != ENVIRONMENT_NONE,
        .warning_count = scene->warning_count,
        .warnings = (const char *const *)scene->warnings,
    };
    for (int i = 0; i < scene->mesh_count; i++) {
        summary.triangles += scene->meshes[i].triangle_count;
        summary.emitters += scene->meshes[i].emissive;
    }
    for (int i = 0; i < scene->texture_count; i++)
        summary.textures += scene->textures[i].kind != TEXTURE_CONSTANT;
    return summary;
}
