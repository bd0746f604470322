/* SPDX-License-Identifier: Apache-2.0 */
/* Loads a scene: the main path of the loader. */

#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/assimp/import_scene.h"
#include "guide/scene/loader.h"
#include "guide/scene/recentre.h"

static struct fewray_scene *create_scene(const char *path) {
    struct fewray_scene *scene = calloc(1, sizeof(*scene));
    if (!scene)
        return NULL;
    scene->path = strdup(path);
    /* Mitsuba's defaults. */
    scene->max_depth = -1;
    scene->rr_depth = 5;
    scene->sample_count = 4;
    scene->camera.width = 768;
    scene->camera.height = 576;
    if (!scene->path)
        fewray_scene_destroy(&scene);
    return scene;
}

/* Gives the images to the scene, and to the textures and the environment that show them. */
static int hand_over_images(struct loader *loader) {
    struct fewray_scene *scene = loader->scene;
    struct assets *assets = &loader->assets;
    scene->images = calloc(assets->count + 1, sizeof(*scene->images)); /* a sky may be one more */
    if (!scene->images)
        return loader_fail_memory(loader);
    for (int i = 0; i < scene->texture_count; i++)
        if (loader->texture_images[i] >= 0)
            scene->textures[i].image = assets->items[loader->texture_images[i]].image;
    if (loader->environment_image >= 0)
        scene->environment.image = assets->items[loader->environment_image].image;
    if (loader->sky) {
        scene->environment.image = loader->sky;
        scene->images[scene->image_count++] = loader->sky;
        loader->sky = NULL;
    }
    for (size_t i = 0; i < assets->count; i++)
        if (assets->items[i].image) {
            scene->images[scene->image_count++] = assets->items[i].image;
            assets->items[i].image = NULL;
        }
    return FEWRAY_OK;
}

int fewray_scene_load(const char *path, const struct fewray_scene_options *options,
                      struct fewray_scene **out, struct fewray_error *error) {
    static const struct fewray_scene_options defaults = {0};
    struct loader loader = {.path = path,
                            .error = error,
                            .environment_image = -1,
                            .default_bsdf = -1,
                            .black_bsdf = -1,
                            .null_bsdf = -1};
    *out = NULL;
    if (!options)
        options = &defaults;
    loader.lenient = options->lenient;
    loader.threads = options->threads > 0 ? options->threads : omp_get_max_threads();
    if (import_knows(path)) {
        int status = options->define_count > 0
                         ? fewray_fail(error, FEWRAY_ERROR_ARGUMENT, path, 0,
                                       "only XML scenes have parameters to define")
                         : import_scene(path, loader.threads, out, error);
        if (!status)
            scene_recentre(*out, loader.threads);
        return status;
    }

    int status = xml_read(path, options, &loader.document, error);
    if (status)
        goto done;
    loader.scene = create_scene(path);
    if (!loader.scene) {
        status = loader_fail_memory(&loader);
        goto done;
    }
    if ((status = check_elements(&loader)) || (status = parse_scene(&loader)) ||
        (status = assets_read(&loader)) || (status = meshes_build(&loader)) ||
        (status = hand_over_images(&loader)))
        goto done;
    scene_recentre(loader.scene, loader.threads);
    loader.scene->uses_frame = loader.document->uses_frame;
    loader.scene->unused_textures = unused_textures(loader.document);
    *out = loader.scene;
    loader.scene = NULL;
done:
    fewray_scene_destroy(&loader.scene);
    assets_free(&loader.assets);
    fewray_image_destroy(&loader.sky);
    xml_destroy(&loader.document);
    free(loader.shapes);
    free(loader.texture_images);
    return status;
}
