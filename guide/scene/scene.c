/* SPDX-License-Identifier: Apache-2.0 */
/* A scene's end, and what it holds in numbers. */

#include "guide/scene/camera_path.h"

#include <stdlib.h>

struct bsdf empty_bsdf(enum bsdf_kind kind) {
    struct bsdf bsdf = {.kind = kind,
                        .nested = {-1, -1},
                        .weight = -1,
                        .reflectance = -1,
                        .specular_reflectance = -1,
                        .specular_transmittance = -1,
                        .alpha_u = -1,
                        .alpha_v = -1,
                        .eta = 1,
                        .bump_scale = 1,
                        .flip_invalid_normals = true,
                        .use_shadowing_function = true};
    for (int i = 0; i < PRINCIPLED_COUNT; i++)
        bsdf.principled[i] = -1;
    return bsdf;
}

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
    free(s->camera_keys);
    free(s->meshes);
    free(s->instances);
    free(s->images);
    free(s->warnings);
    free(s->textures);
    free(s->bsdfs);
    free(s->lights);
    free(s->path);
    free(s);
    *scene = NULL;
}

/* BSDFs that meshes have, without those that are nested in them. */
static int count_materials(const struct fewray_scene *scene) {
    int count = 0;
    bool *counted = calloc((size_t)scene->bsdf_count + 1, sizeof(*counted));
    if (!counted)
        return scene->bsdf_count;
    for (int i = 0; i < scene->mesh_count; i++) {
        bool *mesh = &counted[scene->meshes[i].bsdf];
        count += !*mesh;
        *mesh = true;
    }
    free(counted);
    return count;
}

struct fewray_scene_summary fewray_scene_summarize(const struct fewray_scene *scene) {
    struct fewray_scene_summary summary = {
        .width = scene->camera.width,
        .height = scene->camera.height,
        .max_depth = scene->max_depth,
        .sample_count = scene->sample_count,
        .meshes = scene->mesh_count,
        .materials = count_materials(scene),
        .emitters = (scene->environment.kind != ENVIRONMENT_NONE) + scene->light_count,
        .images = scene->image_count,
        .camera_keys = scene->camera_key_count,
        .uses_frame = scene->uses_frame,
        .unused_textures = scene->unused_textures,
        .warning_count = scene->warning_count,
        .warnings = (const char *const *)scene->warnings,
    };
    for (int i = 0; i < scene->mesh_count; i++) {
        summary.triangles += scene->meshes[i].triangle_count;
        summary.emitters += scene->meshes[i].emission >= 0;
    }
    for (int i = 0; i < scene->texture_count; i++)
        summary.textures += scene->textures[i].kind != TEXTURE_CONSTANT;
    return summary;
}

void fewray_scene_set_time(struct fewray_scene *scene, double seconds) {
    if (scene->camera_key_count > 0)
        camera_path_at(scene->camera_keys, scene->camera_key_count, seconds,
                       scene->camera.to_world);
}

struct fewray_view fewray_scene_view(const struct fewray_scene *scene) {
    const struct camera *camera = &scene->camera;
    struct fewray_view view = {.fov_x = camera->fov_x,
                               .principal_x = camera->principal_x,
                               .principal_y = camera->principal_y};
    for (int i = 0; i < 12; i++)
        view.to_world[i] = camera->to_world[i] + (i % 4 == 3 ? scene->origin[i / 4] : 0);
    return view;
}
