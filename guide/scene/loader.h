/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_LOADER_H
#define FEWRAY_GUIDE_SCENE_LOADER_H

/* What the parts of the loader share while a scene is read. The order of work (load.c):
 *
 *     xml_read()          file -> tree of elements
 *     check_elements()    every element, plugin type and number is one that Mitsuba 3 knows
 *     parse_scene()       tree -> camera, textures, BSDFs, environment, and lists of what to read
 * and build assets_read()       mesh and image files, in parallel, each once meshes_build() meshes
 * in world space, in parallel
 */

#include "guide/scene/assets.h"
#include "guide/scene/mesh_build.h"
#include "guide/scene/scene.h"
#include "guide/scene/xml.h"

struct loader {
    const char *path;
    struct xml_document *document;
    struct fewray_scene *scene;
    struct fewray_error *error;
    int threads;

    struct assets assets;
    struct shape *shapes; /* what becomes scene->meshes, in the file's order */
    size_t shape_count, shape_capacity, instance_capacity;
    int *texture_images; /* of each scene texture: index of an asset, -1 = none */
    size_t texture_capacity, texture_image_capacity, bsdf_capacity, warning_capacity;
    size_t light_capacity;
    int environment_image;        /* index of an asset, -1 = none */
    int default_bsdf, black_bsdf; /* of shapes without one; -1 = not needed so far */
    int null_bsdf;                /* of masks; likewise */
    int bsdf_depth;               /* of nested ones being read */
    bool lenient;                 /* what isn't supported is approximated or left out */
    struct fewray_image *sky;     /* of a sunsky; becomes the environment's */
};

/* Sets the error to the node's line and returns status. */
int loader_fail(struct loader *loader, enum fewray_status status, const struct xml_node *node,
                const char *format, ...) __attribute__((format(printf, 4, 5)));
int loader_fail_memory(struct loader *loader);

/* The path of a file that the scene names: in a folder of its <path>s, else beside the scene.
 * malloc'd; NULL: out of memory. */
char *loader_find_file(struct loader *loader, const char *filename);

/* Keeps "FILE:LINE: text" among the scene's warnings, unless the same text is there for another
 * line. */
int loader_warn(struct loader *loader, const struct xml_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The object that a child stands for: itself, or what a <ref> refers to. */
int loader_resolve(struct loader *loader, struct xml_node *child, struct xml_node **object);

/* "bsdf 'plastic' (id 'Wall')", cut to 128 bytes; returns text. */
const char *loader_describe(const struct xml_node *object, char text[128]);

/* The number of the document's bitmap textures that no shape's material uses, so that their files
 * are never opened. After parse_scene(). */
int unused_textures(const struct xml_document *document);

/* Refuses elements, plugin types and values that Mitsuba 3 wouldn't take. */
int check_elements(struct loader *loader);

/* --- parts of the scene */

int parse_scene(struct loader *loader);
int parse_sensor(struct loader *loader, struct xml_node *sensor);
/* The keys of a sensor's <animation>; the camera stands where it is at second 0. */
int parse_camera_animation(struct loader *loader, const struct xml_node *animation);
/* The time of one of its <transform>s, seconds. */
int check_key_time(struct loader *loader, const struct xml_node *node, double *time);
/* A shape of any type, in the scene itself: a shapegroup alone is invisible. */
int parse_shape(struct loader *loader, struct xml_node *shape);
/* A shape that becomes a mesh, of the scene itself (group = -1) or of a group. */
int parse_mesh_shape(struct loader *loader, struct xml_node *shape, int group);
/* A shapegroup that is referred to twice is made once. */
int parse_group(struct loader *loader, struct xml_node *shapegroup, int *group);
int parse_instance(struct loader *loader, struct xml_node *instance);
/* An emitter without a shape: a light or the environment. */
int parse_emitter(struct loader *loader, struct xml_node *emitter);
int parse_sunsky(struct loader *loader, struct xml_node *emitter);
int add_light(struct loader *loader, const struct light *light);
/* The rotation in an emitter's to_world, whose uniform scale makes no difference; anything else is
 * refused. */
int parse_emitter_rotation(struct loader *loader, struct xml_node *emitter, double rotation[3][3]);
/* *texture: the radiance of an area emitter inside a shape; -1 = black. */
int parse_area_emitter(struct loader *loader, struct xml_node *emitter, int *texture);
/* *index: of the scene's BSDFs. A BSDF that is referred to twice is made once. */
int parse_bsdf(struct loader *loader, struct xml_node *bsdf, int *index);
/* A BSDF of one grey, one-sided; *index of it. */
int make_grey_bsdf(struct loader *loader, float reflectance, int *index);
/* *index: of the scene's textures. One that is referred to twice is made once. */
int parse_texture(struct loader *loader, struct xml_node *texture, int *index);
/* One colour; an equal one is used again if it isn't old. */
int make_constant_texture(struct loader *loader, struct vec3 color, int *index);
/* *index: of the scene's textures, made of the parameter's colour or texture; of fallback where it
 * has none. */
int parse_reflectance(struct loader *loader, struct xml_node *bsdf, const char *name,
                      struct vec3 fallback, int *index);
/* Likewise of an emitter's radiance. */
int parse_radiance(struct loader *loader, struct xml_node *emitter, const char *name,
                   struct vec3 fallback, int *index);
/* Likewise of a number, colour (grey by its luminance) or texture; any value >= 0. */
int parse_grey(struct loader *loader, struct xml_node *bsdf, const char *name, float fallback,
               int *index);

#endif
