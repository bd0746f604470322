/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_PLY_HEADER_H
#define FEWRAY_GUIDE_SCENE_PLY_HEADER_H

/* What a PLY file says about its own layout. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fewray/features.h"

#define PLY_MAX_PROPERTIES 64
#define PLY_MAX_ELEMENTS   16

enum ply_type {
    PLY_NONE,
    PLY_INT8,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_FLOAT,
    PLY_DOUBLE
};

struct ply_property {
    char name[32];
    enum ply_type type;
    enum ply_type count_type; /* of a list; PLY_NONE: a single value */
};

struct ply_element {
    char name[32];
    uint64_t count;
    int property_count;
    struct ply_property properties[PLY_MAX_PROPERTIES];
    bool has_list;
    size_t stride; /* bytes an item in a binary file, where it has no list */
};

struct ply_header {
    bool ascii;
    int element_count;
    struct ply_element elements[PLY_MAX_ELEMENTS];
    size_t size; /* bytes, of the header itself */
    int lines;
};

size_t ply_type_size(enum ply_type type);

/* Index of the first of the element's properties with one of the names (NULL at the end), or -1. */
int ply_find_property(const struct ply_element *element, const char *const *names);

/* Reads the header at the start of data. */
int ply_read_header(const char *path, const char *data, size_t size, struct ply_header *out,
                    struct fewray_error *error);

#endif
