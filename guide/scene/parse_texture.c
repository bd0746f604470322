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
    return (struct texture){.kind = TEXTURE_CONSTANT,
                            .color0 = color,
                            .color1 = color,
                            .factor = {1, 1, 1},
                            .to_uv = {1, 0, 0, 0, 1, 0},
                            .channel = -1};
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
    if (!strcmp(wrap, "mirror"))
        texture->wrap = WRAP_MIRROR;
    else if (!strcmp(wrap, "clamp"))
        texture->wrap = WRAP_CLAMP;
    else if (strcmp(wrap, "repeat"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(node, "wrap_mode"),
                           "wrap_mode = '%s' should be repeat, mirror or clamp", wrap);
    texture->kind = TEXTURE_BITMAP;
    texture->nearest = !strcmp(filter, "nearest");
    texture->srgb = !raw;
    return assets_add(loader, raw ? ASSET_RAW_IMAGE : ASSET_COLOR_IMAGE, filename, node, image);
}

/* Colours of what shines have no limit. */
static enum color_use use_of_colors(const struct xml_node *node) {
    for (; node; node = node->parent)
        if (!strcmp(node->tag, "emitter"))
            return COLOR_UNBOUNDED;
    return COLOR_REFLECTANCE;
}

/* color0 where u and v lie in the same half of their squares, color1 where they don't. */
static int parse_checkerboard(struct loader *loader, struct xml_node *node,
                              struct texture *texture) {
    struct xml_node *color0 = param_find(node, "color0"), *color1 = param_find(node, "color1");
    enum color_use use = use_of_colors(node);
    texture->kind = TEXTURE_CHECKERBOARD;
    texture->color0 = vec(0.4f, 0.4f, 0.4f);
    texture->color1 = vec(0.2f, 0.2f, 0.2f);
    int status = color0 ? param_color(loader, color0, use, &texture->color0) : FEWRAY_OK;
    if (!status && color1)
        status = param_color(loader, color1, use, &texture->color1);
    return status ? status : parse_to_uv(loader, node, texture);
}

/* A texture that isn't supported is the grey of BSDFs without a colour. */
static int parse_other(struct loader *loader, struct xml_node *node, struct texture *texture) {
    const char *type = xml_attribute(node, "type");
    if (!loader->lenient)
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, node,
                           "texture '%s' is not supported yet: use bitmap or checkerboard", type);
    *texture = constant_texture(vec(0.5f, 0.5f, 0.5f));
    params_ignore_all(node);
    return loader_warn(loader, node, "texture '%s' is drawn as a grey", type);
}

int parse_texture(struct loader *loader, struct xml_node *node, int *index) {
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
        status = parse_other(loader, node, &texture);
    if (!status)
        status = params_finish(loader, node);
    if (!status)
        status = add_texture(loader, &texture, image, index);
    node->index = status ? -1 : *index;
    return status;
}

static bool is_equal(struct vec3 a, struct vec3 b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

int make_constant_texture(struct loader *loader, struct vec3 color, int *index) {
    enum { LOOK_BACK = 256 }; /* so that many materials don't take quadratic time */
    const struct fewray_scene *scene = loader->scene;
    struct texture texture = constant_texture(color);
    for (int i = scene->texture_count - 1; i >= 0 && i >= scene->texture_count - LOOK_BACK; i--)
        if (scene->textures[i].kind == TEXTURE_CONSTANT &&
            is_equal(scene->textures[i].color0, color)) {
            *index = i;
            return FEWRAY_OK;
        }
    return add_texture(loader, &texture, -1, index);
}

static int parse_color_texture(struct loader *loader, struct xml_node *plugin, const char *name,
                               enum color_use use, struct vec3 color, int *index) {
    struct xml_node *node = param_find(plugin, name), *object;
    if (node) {
        int status = loader_resolve(loader, node, &object);
        if (status)
            return status;
        if (object && !strcmp(object->tag, "texture"))
            return parse_texture(loader, object, index);
        status = param_color(loader, node, use, &color);
        if (status)
            return status;
    }
    return make_constant_texture(loader, color, index);
}

int parse_reflectance(struct loader *loader, struct xml_node *bsdf, const char *name,
                      struct vec3 fallback, int *index) {
    return parse_color_texture(loader, bsdf, name, COLOR_REFLECTANCE, fallback, index);
}

int parse_grey(struct loader *loader, struct xml_node *bsdf, const char *name, float fallback,
               int *index) {
    return parse_color_texture(loader, bsdf, name, COLOR_UNBOUNDED,
                               vec(fallback, fallback, fallback), index);
}

int parse_radiance(struct loader *loader, struct xml_node *emitter, const char *name,
                   struct vec3 fallback, int *index) {
    return parse_color_texture(loader, emitter, name, COLOR_EMISSION, fallback, index);
}
