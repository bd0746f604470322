/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_ASSETS_H
#define FEWRAY_GUIDE_SCENE_ASSETS_H

/* The files that a scene refers to: listed while it is parsed, then read together. */

#include "guide/scene/mesh_data.h"

struct loader;
struct xml_node;

enum asset_kind {
    ASSET_OBJ,
    ASSET_PLY,
    ASSET_SERIALIZED,
    ASSET_COLOR_IMAGE, /* stays as it is, but 16-bit pictures become linear */
    ASSET_RAW_IMAGE,   /* values as stored */
    ASSET_ENVIRONMENT  /* becomes linear float RGB */
};

struct asset {
    enum asset_kind kind;
    int part; /* which of the meshes of a file that holds several */
    char *path;
    uint32_t path_hash;
    const struct xml_node *node; /* the first that refers to it */
    int users;
    struct mesh_data mesh;
    struct fewray_image *image;
    size_t mended; /* values of an image that were NaN, infinite or negative, and are 0 now */
    int status;
    struct fewray_error error;
};

struct assets {
    struct asset *items;
    size_t count, capacity;
};

/* *index of the file, which is listed once for each kind. filename is relative to the scene. */
int assets_add(struct loader *loader, enum asset_kind kind, const char *filename,
               const struct xml_node *node, int *index);

/* Likewise of one of the file's parts. */
int assets_add_part(struct loader *loader, enum asset_kind kind, const char *filename, int part,
                    const struct xml_node *node, int *index);

/* Reads all files, in parallel. Of several failures it reports the one that the scene names first.
 */
int assets_read(struct loader *loader);

void assets_free(struct assets *assets);

/* Makes an image that was read what its kind promises. Returns false without memory. */
bool asset_convert_image(struct asset *asset);

#endif
