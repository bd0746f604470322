/* SPDX-License-Identifier: Apache-2.0 */
/* Textures: a colour, a bitmap, or a checkerboard. */

#include <string.h>

#include "guide/scene/memory.h"
#include "guide/scene/params.h"
#include "guide/scene/transform.h"

static int add_texture(struct loader *loader, const struct texture *texture, int image,
                       int *index) {
    struct fewray_scene *scene = loader->scene;
    size_t count = (size_t)scene->texture_count + 1;
    if (!array_reserve((void **)&scene->textures, &loader->texture_capacity, count,
                       sizeof(*scene->textures)) ||
        !array_reserve((void **)&loader->texture_images, &loader->texture_image_capacity, count,
                       sizeof(*loader->texture_images)))
        return loader_fail_memory(loader);
    *index = scene->texture_count++;
    scene->textures[*index] = *texture;
    loader->texture_images[*index] = image;
    return FEWRAY_OK;
}

static struct texture constant_texture(struct vec3 color) {
    return (struct texture){
        .kind = TEXTURE_CONSTANT, .color0 = color, .color1 = color, .to_uv = {1, 0, 0, 0, 1, 0}};
}

/* The rows for u and v of a 3D transform; Mitsuba takes its translation from the last column, too.
 */
static int parse_to_uv(struct loader *loader, struct xml_node *node, struct texture *texture) {
    struct transform to_uv;
    int status = param_transform(loader, node, "to_uv", &to_uv);
    for (int i = 0; i < 2 && !status; i++) {
        texture->to_uv[3 * i] = (float)to_uv.m[i][0];
        texture->to_uv[3 * i + 1] = (float)to_uv.m[i][1];
        texture->to_uv[3 * i + 2] = (float)to_uv.m[i][3];
    }
    return status;
}

static int parse_bitmap(struct loader *loader, struct xml_node *node, struct texture *texture,
                        int *image) {
    static const char *const ignored[] = {"format", "accel", NULL};
    const char *filename = NULL, *filter = "bilinear", *wrap = "repeat";
    bool raw = false;
    int status = param_string(loader, node, "filename", &filename);
    if (!status)
        status = param_string(loader, node, "filter_type", &filter);
    if (!status)
        status = param_string(loader, node, "wrap_mode", &wrap);
    if (!status)
        status = param_boolean(loader, node, "raw", &raw);
    if (!status)
        status = parse_to_uv(loader, node, texture);
    if (status)
        return status;
    params_ignore(node, ignored);
    if (!filename || !*filename)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "the bitmap has no filename");
    if (strcmp(filter, "bilinear") && strcmp(filter, "nearest"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(node, "filter_type"),
                           "filter_type = '%s' should be bilinear or nearest", filter);
    if (strcmp(wrap, "repeat")) {
        if (strcmp(wrap, "mirror") && strcmp(wrap, "clamp"))
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(node, "wrap_mode"),
                               "wrap_mode = '%s' should be repeat, mirror or clamp", wrap);
        status = loader_warn(loader, node, "%s: wrap_mode %s is taken as repeat", filename, wrap);
    }
    texture->kind = TEXTURE_BITMAP;
    texture->nearest = !strcmp(filter, "nearest");
    texture->srgb = !raw;
    return status ? status
                  : assets_add(loader, raw ? ASSET_RAW_IMAGE : ASSET_COLOR_IMAGE, filename, node,
                               image);
}

/* color0 where u and v lie in the same half of their squares, color1 where they don't. */
static int parse_checkerboard(struct loader *loader, struct xml_node *node,
                              struct texture *texture) {
    struct xml_node *color0 = param_find(node, "color0"), *color1 = param_find(node, "color1");
    texture->kind = TEXTURE_CHECKERBOARD;
    texture->color0 = vec(0.4f, 0.4f, 0.4f);
    texture->color1 = vec(0.2f, 0.2f, 0.2f);
    int status = color0 ? param_reflectance(loader, color0, &texture->color0) : FEWRAY_OK;
    if (!status && color1)
        status = param_reflectance(loader, color1, &texture->color1);
    return status ? status : parse_to_uv(loader, node, texture);
}

static int parse_texture(struct loader *loader, struct xml_node *node, int *index) {
    struct texture texture = constant_texture(vec(0, 0, 0));
    const char *type = xml_attribute(node, "type");
    int image = -1, status;
    if (node->index >= 0) {
        *index = node->index;
        return FEWRAY_OK;
    }
    if (!strcmp(type, "bitmap"))
        status = parse_bitmap(loader, node, &texture, &image);
    else if (!strcmp(type, "checkerboard"))
        status = parse_checkerboard(loader, node, &texture);
    else
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, node,
                           "texture '%s' is not supported yet: use bitmap or checkerboard", type);
    if (!status)
        status = params_finish(loader, node);
    if (!status)
        status = add_texture(loader, &texture, image, index);
    node->index = status ? -1 : *index;
    return status;
}

int parse_reflectance(struct loader *loader, struct xml_node *bsdf, const char *name,
                      struct vec3 fallback, int *index) {
    struct xml_node *node = param_find(bsdf, name), *object;
    struct vec3 color = fallback;
    if (node) {
        int status = loader_resolve(loader, node, &object);
        if (status)
            return status;
        if (object && !strcmp(object->tag, "texture"))
            return parse_texture(loader, object, index);
        status = param_reflectance(loader, node, &color);
        if (status)
            return status;
    }
    struct texture texture = constant_texture(color);
    return add_texture(loader, &texture, -1, index);
}
