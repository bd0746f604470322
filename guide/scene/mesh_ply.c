/* SPDX-License-Identifier: Apache-2.0 */
/* PLY meshes, straight from the file in memory. */

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/file_bytes.h"
#include "guide/scene/memory.h"
#include "guide/scene/mesh_data.h"
#include "guide/scene/number.h"
#include "guide/scene/ply_header.h"

#define MAX_TOKEN 64
/* A list longer than this is damage, not a polygon. */
#define MAX_POLYGON 65536

struct ply {
    const char *path;
    struct ply_header header;
    const char *cursor, *end; /* of the data behind the header */
    struct mesh_data *out;
    size_t index_count, index_capacity;
    struct fewray_error *error;
};

/* Where the values of interest stand among a vertex's properties; -1 = none. */
struct vertex_layout {
    int position[3], normal[3], uv[2];
    bool has_normals, has_uvs;
};

static int fail(const struct ply *ply, const char *what) {
    return fewray_fail(ply->error, FEWRAY_ERROR_FORMAT, ply->path, 0, "%s", what);
}

static int fail_memory(const struct ply *ply) {
    return fewray_fail(ply->error, FEWRAY_ERROR_MEMORY, ply->path, 0, "out of memory");
}

/* --- single values */

/* A binary value; the caller has checked that its bytes are there. */
static double decode(const char *from, enum ply_type type) {
    union {
        int8_t i8;
        uint8_t u8;
        int16_t i16;
        uint16_t u16;
        int32_t i32;
        uint32_t u32;
        float f;
        double d;
    } value;
    memcpy(&value, from, ply_type_size(type));
    switch (type) {
    case PLY_INT8:
        return value.i8;
    case PLY_UINT8:
        return value.u8;
    case PLY_INT16:
        return value.i16;
    case PLY_UINT16:
        return value.u16;
    case PLY_INT32:
        return value.i32;
    case PLY_UINT32:
        return value.u32;
    case PLY_FLOAT:
        return value.f;
    default:
        return value.d;
    }
}

/* The next word as a number: NAN for "nan" and "inf". */
static bool next_ascii(struct ply *ply, double *out) {
    char token[MAX_TOKEN];
    size_t length = 0;
    while (ply->cursor < ply->end && isspace((unsigned char)*ply->cursor))
        ply->cursor++;
    while (ply->cursor < ply->end && !isspace((unsigned char)*ply->cursor)) {
        if (length == MAX_TOKEN - 1)
            return false;
        token[length++] = *ply->cursor++;
    }
    token[length] = 0;
    const char *text = token;
    if (number_read(&text, out))
        return !*text;
    *out = NAN;
    text += *text == '-' || *text == '+';
    return *text && strchr("nNiI", *text);
}

static bool next_value(struct ply *ply, enum ply_type type, double *out) {
    if (ply->header.ascii)
        return next_ascii(ply, out);
    size_t size = ply_type_size(type);
    if ((size_t)(ply->end - ply->cursor) < size)
        return false;
    *out = decode(ply->cursor, type);
    ply->cursor += size;
    return true;
}

/* Whether count items can be in what is left of the file: before memory is taken for them. */
static bool has_room(const struct ply *ply, const struct ply_element *element) {
    size_t left = (size_t)(ply->end - ply->cursor), least = 0;
    for (int i = 0; i < element->property_count; i++) {
        const struct ply_property *property = &element->properties[i];
        /* A word of one digit and a blank, a list's count alone, or a binary value. */
        least += ply->header.ascii      ? 2
                 : property->count_type ? ply_type_size(property->count_type)
                                        : ply_type_size(property->type);
    }
    if (least == 0)
        return element->count <= MESH_MAX_COUNT;
    return element->count <= (left + 1) / least;
}

/* --- vertices */

static bool find_all(const struct ply_element *element, const char *const *const *names, int count,
                     int *out) {
    bool all = true;
    for (int i = 0; i < count; i++) {
        out[i] = ply_find_property(element, names[i]);
        all = all && out[i] >= 0 && !element->properties[out[i]].count_type;
    }
    return all;
}

static bool find_layout(const struct ply_element *element, struct vertex_layout *layout) {
    static const char *const x[] = {"x", NULL}, *const y[] = {"y", NULL}, *const z[] = {"z", NULL};
    static const char *const nx[] = {"nx", NULL}, *const ny[] = {"ny", NULL};
    static const char *const nz[] = {"nz", NULL};
    static const char *const u[] = {"u", "s", "texture_u", "s0", NULL};
    static const char *const v[] = {"v", "t", "texture_v", "t0", NULL};
    const char *const *const position[] = {x, y, z}, *const *const normal[] = {nx, ny, nz};
    const char *const *const uv[] = {u, v};
    layout->has_normals = find_all(element, normal, 3, layout->normal);
    layout->has_uvs = find_all(element, uv, 2, layout->uv);
    return find_all(element, position, 3, layout->position);
}

static void store_vertex(struct mesh_data *out, size_t index, const struct vertex_layout *layout,
                         const double *values) {
    for (int i = 0; i < 3; i++)
        out->positions[3 * index + (size_t)i] = (float)values[layout->position[i]];
    for (int i = 0; i < 3 && layout->has_normals; i++)
        out->normals[3 * index + (size_t)i] = (float)values[layout->normal[i]];
    for (int i = 0; i < 2 && layout->has_uvs; i++)
        out->uvs[2 * index + (size_t)i] = (float)values[layout->uv[i]];
}

static bool is_finite_vertex(const struct mesh_data *out, size_t index) {
    const float *p = out->positions + 3 * index;
    return fabsf(p[0]) <= FLT_MAX && fabsf(p[1]) <= FLT_MAX && fabsf(p[2]) <= FLT_MAX;
}

static int read_vertices(struct ply *ply, const struct ply_element *element) {
    struct vertex_layout layout;
    double values[PLY_MAX_PROPERTIES];
    if (element->has_list || !find_layout(element, &layout))
        return fail(ply, "the vertices have no x, y and z");
    if (!has_room(ply, element))
        return fail(ply, "the file is truncated within the vertices");
    if (element->count > MESH_MAX_COUNT)
        return fail(ply, "the mesh is too large");
    if (ply->out->positions)
        return fail(ply, "two elements are named vertex");
    if (!mesh_data_allocate(ply->out, element->count, 0, layout.has_normals, layout.has_uvs))
        return fail_memory(ply);
    for (size_t i = 0; i < element->count; i++) {
        for (int j = 0; j < element->property_count; j++)
            if (!next_value(ply, element->properties[j].type, &values[j]))
                return fewray_fail(ply->error, FEWRAY_ERROR_FORMAT, ply->path, 0,
                                   "vertex %zu is truncated or not a number", i);
        store_vertex(ply->out, i, &layout, values);
        if (!is_finite_vertex(ply->out, i))
            return fewray_fail(ply->error, FEWRAY_ERROR_FORMAT, ply->path, 0,
                               "vertex %zu is not finite", i);
    }
    return FEWRAY_OK;
}

/* --- faces */

static int add_triangle(struct ply *ply, const double corners[3]) {
    struct mesh_data *out = ply->out;
    if (!array_reserve((void **)&out->indices, &ply->index_capacity, ply->index_count + 3,
                       sizeof(*out->indices)))
        return fail_memory(ply);
    if (out->triangle_count == MESH_MAX_COUNT)
        return fail(ply, "the mesh is too large");
    for (int i = 0; i < 3; i++)
        out->indices[ply->index_count++] = (uint32_t)corners[i];
    out->triangle_count++;
    return FEWRAY_OK;
}

static int bad_face(const struct ply *ply, size_t face, const char *what) {
    return fewray_fail(ply->error, FEWRAY_ERROR_FORMAT, ply->path, 0, "face %zu %s", face, what);
}

/* Reads a list of indices as a fan of triangles. */
static int read_polygon(struct ply *ply, const struct ply_property *property, size_t face) {
    double count, corners[3] = {0, 0, 0};
    if (!next_value(ply, property->count_type, &count))
        return bad_face(ply, face, "is truncated");
    if (!(count >= 3 && count <= MAX_POLYGON))
        return bad_face(ply, face, "has fewer than three or too many corners");
    for (int i = 0; i < (int)count; i++) {
        double index;
        if (!next_value(ply, property->type, &index))
            return bad_face(ply, face, "is truncated");
        if (!(index >= 0 && index < ply->out->vertex_count))
            return fewray_fail(ply->error, FEWRAY_ERROR_FORMAT, ply->path, 0,
                               "face %zu: index %.0f is out of range: there are %u vertices", face,
                               index, ply->out->vertex_count);
        if (i > 2)
            corners[1] = corners[2];
        corners[i < 2 ? i : 2] = index;
        if (i >= 2) {
            int status = add_triangle(ply, corners);
            if (status)
                return status;
        }
    }
    return FEWRAY_OK;
}

static bool skip_property(struct ply *ply, const struct ply_property *property) {
    double count = 1, value;
    if (property->count_type && !next_value(ply, property->count_type, &count))
        return false;
    if (!(count >= 0))
        return false;
    for (double i = 0; i < count; i++)
        if (!next_value(ply, property->type, &value))
            return false;
    return true;
}

/* The faces of nearly every file: a byte 3 and three 32-bit indices each. Reads as many as are so;
 * the rest is for read_faces(). */
static size_t read_plain_triangles(struct ply *ply, const struct ply_element *element) {
    const struct ply_property *list = &element->properties[0];
    const size_t bytes = 13;
    struct mesh_data *out = ply->out;
    size_t face = 0;
    if (ply->header.ascii || element->property_count != 1 || list->count_type != PLY_UINT8 ||
        (list->type != PLY_INT32 && list->type != PLY_UINT32))
        return 0;
    for (; face < element->count && (size_t)(ply->end - ply->cursor) >= bytes; face++) {
        uint32_t corners[3];
        memcpy(corners, ply->cursor + 1, sizeof(corners));
        if (*ply->cursor != 3 || corners[0] >= out->vertex_count ||
            corners[1] >= out->vertex_count || corners[2] >= out->vertex_count)
            break;
        memcpy(out->indices + ply->index_count, corners, sizeof(corners));
        ply->index_count += 3;
        ply->cursor += bytes;
    }
    out->triangle_count = (uint32_t)face;
    return face;
}

static int read_faces(struct ply *ply, const struct ply_element *element) {
    static const char *const names[] = {"vertex_indices", "vertex_index", NULL};
    int list = ply_find_property(element, names);
    if (list < 0 || !element->properties[list].count_type ||
        element->properties[list].type >= PLY_FLOAT)
        return fail(ply, "the faces have no vertex_indices");
    if (!ply->out->positions)
        return fail(ply, "the faces stand before the vertices");
    if (!has_room(ply, element))
        return fail(ply, "the file is truncated within the faces");
    if (element->count > MESH_MAX_COUNT)
        return fail(ply, "the mesh is too large");
    if (ply->index_count)
        return fail(ply, "two elements are named face");
    if (!array_reserve((void **)&ply->out->indices, &ply->index_capacity, 3 * element->count + 3,
                       sizeof(uint32_t)))
        return fail_memory(ply);
    for (size_t i = read_plain_triangles(ply, element); i < element->count; i++)
        for (int j = 0; j < element->property_count; j++) {
            if (j != list) {
                if (!skip_property(ply, &element->properties[j]))
                    return bad_face(ply, i, "is truncated or not a number");
                continue;
            }
            int status = read_polygon(ply, &element->properties[j], i);
            if (status)
                return status;
        }
    return FEWRAY_OK;
}

static int skip_element(struct ply *ply, const struct ply_element *element) {
    if (!has_room(ply, element))
        return fail(ply, "the file is truncated");
    for (uint64_t i = 0; i < element->count; i++)
        for (int j = 0; j < element->property_count; j++)
            if (!skip_property(ply, &element->properties[j]))
                return fewray_fail(ply->error, FEWRAY_ERROR_FORMAT, ply->path, 0,
                                   "element %s is truncated or not a number", element->name);
    return FEWRAY_OK;
}

static int read_elements(struct ply *ply) {
    bool done = false; /* what follows the faces doesn't matter */
    for (int i = 0; i < ply->header.element_count && !done; i++) {
        const struct ply_element *element = &ply->header.elements[i];
        int status;
        if (!strcmp(element->name, "vertex"))
            status = read_vertices(ply, element);
        else if ((done = !strcmp(element->name, "face")))
            status = read_faces(ply, element);
        else
            status = skip_element(ply, element);
        if (status)
            return status;
    }
    if (!ply->out->triangle_count)
        return fail(ply, "the mesh has no faces");
    return FEWRAY_OK;
}

int mesh_read_ply(const char *path, struct mesh_data *out, struct fewray_error *error) {
    struct ply ply = {.path = path, .out = out, .error = error};
    struct file_bytes file;
    *out = (struct mesh_data){0};
    int status = file_read(path, &file, error);
    if (status)
        return status;
    status = ply_read_header(path, file.data, file.size, &ply.header, error);
    if (!status) {
        ply.cursor = file.data + ply.header.size;
        ply.end = file.data + file.size;
        status = read_elements(&ply);
    }
    if (status)
        mesh_data_free(out);
    file_free(&file);
    return status;
}
