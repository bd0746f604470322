/* SPDX-License-Identifier: Apache-2.0 */
/* Textures, and the images that they show: files beside the scene, or bytes within it. */

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/assets.h"
#include "guide/scene/assimp/import.h"
#include "guide/scene/memory.h"

struct texture import_white(void) {
    return (struct texture){.kind = TEXTURE_CONSTANT,
                            .color0 = {1, 1, 1},
                            .color1 = {1, 1, 1},
                            .factor = {1, 1, 1},
                            .to_uv = {1, 0, 0, 0, 1, 0},
                            .channel = -1};
}

static int add_texture(struct import *import, const struct texture *texture, int image,
                       int *index) {
    struct fewray_scene *scene = import->scene;
    size_t count = (size_t)scene->texture_count + 1;
    if (!array_reserve((void **)&scene->textures, &import->texture_capacity, count,
                       sizeof(*scene->textures)) ||
        !array_reserve((void **)&import->texture_images, &import->texture_image_capacity, count,
                       sizeof(*import->texture_images)))
        return import_fail_memory(import);
    *index = scene->texture_count++;
    scene->textures[*index] = *texture;
    import->texture_images[*index] = image;
    return FEWRAY_OK;
}

int import_constant(struct import *import, struct vec3 color, int *index) {
    struct texture texture = import_white();
    texture.color0 = texture.color1 = color;
    return add_texture(import, &texture, -1, index);
}

static const struct aiTexture *find_embedded(const struct import *import, const char *name) {
    if (name[0] != '*')
        return NULL;
    char *end;
    unsigned long index = strtoul(name + 1, &end, 10);
    if (end == name + 1 || *end || index >= import->source->mNumTextures)
        return NULL;
    return import->source->mTextures[index];
}

static int hex(char c) {
    const char *digits = "0123456789abcdef", *found = c ? strchr(digits, c | 32) : NULL;
    return found ? (int)(found - digits) : -1;
}

/* The file that a name stands for, malloc'd: beside the scene, with %20 and backslashes of other
 * systems undone. */
static char *file_path(const struct import *import, const char *name) {
    const char *slash = strrchr(import->path, '/');
    size_t folder = slash && name[0] != '/' ? (size_t)(slash - import->path) + 1 : 0;
    char *path = malloc(folder + strlen(name) + 1), *to = path;
    if (!path)
        return NULL;
    memcpy(path, import->path, folder);
    for (to += folder; *name; name++) {
        int high = *name == '%' && import->gltf ? hex(name[1]) : -1;
        int low = high >= 0 ? hex(name[2]) : -1;
        *to++ = low >= 0 ? (char)(16 * high + low) : *name == '\\' ? '/' : *name;
        name += low >= 0 ? 2 : 0;
    }
    *to = 0;
    return path;
}

static char *embedded_name(const struct import *import, const char *name) {
    size_t size = strlen(import->path) + strlen(name) + 32;
    char *path = malloc(size);
    if (path)
        snprintf(path, size, "%s, embedded image %s", import->path, name + 1);
    return path;
}

int import_bitmap(struct import *import, const struct texture *texture, const char *name,
                  enum import_image_use use, float parameter, int *index) {
    struct texture bitmap = *texture;
    const struct aiTexture *embedded = find_embedded(import, name);
    if (name[0] == '*' && !embedded)
        return import_fail(import, FEWRAY_ERROR_FORMAT, "it has no embedded image %.40s", name);
    char *path = embedded ? embedded_name(import, name) : file_path(import, name);
    if (!path || !array_reserve((void **)&import->images, &import->image_capacity,
                                (size_t)import->image_count + 1, sizeof(*import->images))) {
        free(path);
        return import_fail_memory(import);
    }
    int image = 0;
    for (; image < import->image_count; image++) {
        const struct import_image *other = &import->images[image];
        if (other->use == use && other->parameter == parameter && !strcmp(other->path, path))
            break;
    }
    if (image < import->image_count)
        free(path);
    else
        import->images[import->image_count++] = (struct import_image){
            .use = use, .parameter = parameter, .path = path, .embedded = embedded};
    bitmap.kind = TEXTURE_BITMAP;
    bitmap.srgb = use == IMPORT_COLOR;
    return add_texture(import, &bitmap, image, index);
}

static float value_at(const struct fewray_image *image, size_t index) {
    return image->floats ? image->floats[index] : (float)image->bytes[index] / 255;
}

/* Keeps 255 where alpha reaches the cutoff; an image without alpha is opaque. */
static bool make_cutoff(struct fewray_image *image, float cutoff) {
    size_t pixels = (size_t)image->width * (size_t)image->height;
    uint8_t *mask = malloc(pixels + 1);
    for (size_t i = 0; mask && i < pixels; i++)
        mask[i] = (image->channels == 4 ? value_at(image, 4 * i + 3) : 1) >= cutoff ? 255 : 0;
    free(image->bytes);
    free(image->floats);
    image->bytes = mask;
    image->floats = NULL;
    image->channels = 1;
    return mask != NULL;
}

static bool scale_normals(struct fewray_image *image, float factor) {
    size_t pixels = (size_t)image->width * (size_t)image->height,
           channels = (size_t)image->channels;
    float *scaled = malloc(pixels * 3 * sizeof(float) + 1);
    for (size_t i = 0; scaled && i < pixels; i++) {
        float n[3];
        for (size_t c = 0; c < 3; c++)
            n[c] = 2 * value_at(image, i * channels + (channels < 3 ? 0 : c)) - 1;
        struct vec3 unit = normalize(vec(factor * n[0], factor * n[1], n[2]));
        scaled[3 * i] = 0.5f * unit.x + 0.5f;
        scaled[3 * i + 1] = 0.5f * unit.y + 0.5f;
        scaled[3 * i + 2] = 0.5f * unit.z + 0.5f;
    }
    free(image->bytes);
    free(image->floats);
    image->bytes = NULL;
    image->floats = scaled;
    image->channels = 3;
    return scaled != NULL;
}

/* Four bytes a pixel, blue first, as assimp keeps uncompressed images. */
static int copy_texels(const struct aiTexture *source, struct import_image *item) {
    size_t pixels = (size_t)source->mWidth * source->mHeight;
    struct fewray_image *image = calloc(1, sizeof(*image));
    item->image = image;
    if (!image || pixels == 0 || pixels > (size_t)1 << 28 || !(image->bytes = malloc(4 * pixels)))
        return fewray_fail(&item->error, FEWRAY_ERROR_FORMAT, item->path, 0,
                           "an image of %u x %u pixels can't be used", source->mWidth,
                           source->mHeight);
    image->width = (int)source->mWidth;
    image->height = (int)source->mHeight;
    image->channels = 4;
    for (size_t i = 0; i < pixels; i++) {
        const struct aiTexel *t = &source->pcData[i];
        const uint8_t rgba[4] = {t->r, t->g, t->b, t->a};
        memcpy(image->bytes + 4 * i, rgba, 4);
    }
    return FEWRAY_OK;
}

static int read_image(struct import_image *item) {
    const struct aiTexture *embedded = item->embedded;
    int status;
    if (!embedded)
        status = fewray_image_read(item->path, &item->image, &item->error);
    else if (embedded->mHeight == 0)
        status = fewray_image_read_memory(item->path, embedded->pcData, embedded->mWidth,
                                          &item->image, &item->error);
    else
        status = copy_texels(embedded, item);
    if (status)
        return status;
    /* Float values of an embedded image were 16-bit PNG. */
    struct asset asset = {.kind = item->use == IMPORT_COLOR ? ASSET_COLOR_IMAGE : ASSET_RAW_IMAGE,
                          .path = embedded ? (char *)"embedded.png" : item->path,
                          .image = item->image};
    bool done = asset_convert_image(&asset);
    if (done && item->use == IMPORT_CUTOFF)
        done = make_cutoff(item->image, item->parameter);
    if (done && item->use == IMPORT_NORMALS)
        done = scale_normals(item->image, item->parameter);
    return done ? FEWRAY_OK
                : fewray_fail(&item->error, FEWRAY_ERROR_MEMORY, item->path, 0, "out of memory");
}

/* A channel that the image lacks: alpha is 1 then, all others are the grey. */
static void fit_channel(struct texture *texture, enum import_image_use use) {
    if (texture->channel < texture->image->channels)
        return;
    if (texture->channel == 3 && use != IMPORT_OPACITY) {
        texture->kind = TEXTURE_CONSTANT;
        texture->color0 = texture->color1 = texture->factor;
    }
    texture->channel = 0;
}

int import_read_images(struct import *import) {
    struct fewray_scene *scene = import->scene;
#pragma omp parallel for schedule(dynamic, 1) num_threads(import->threads)
    for (int i = 0; i < import->image_count; i++)
        import->images[i].status = read_image(&import->images[i]);
    for (int i = 0; i < import->image_count; i++) {
        const struct import_image *item = &import->images[i];
        if (item->status)
            return fewray_fail(import->error, item->status, item->path, 0, "%s", item->error.what);
    }
    scene->images = calloc((size_t)import->image_count + 1, sizeof(*scene->images));
    if (!scene->images)
        return import_fail_memory(import);
    for (int i = 0; i < scene->texture_count; i++)
        if (import->texture_images[i] >= 0) {
            const struct import_image *item = &import->images[import->texture_images[i]];
            scene->textures[i].image = item->image;
            fit_channel(&scene->textures[i], item->use);
        }
    for (int i = 0; i < import->image_count; i++) {
        scene->images[scene->image_count++] = import->images[i].image;
        import->images[i].image = NULL;
    }
    return FEWRAY_OK;
}
