/* SPDX-License-Identifier: Apache-2.0 */
/* Wavefront OBJ: one pass over the text. */

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/file_bytes.h"
#include "guide/scene/memory.h"
#include "guide/scene/mesh_data.h"
#include "guide/scene/number.h"

#define NO_VERTEX UINT32_MAX
/* How far an equal corner is looked for: longer chains occur only in files that are made to be
 * slow. */
#define MAX_CHAIN 256

struct values {
    float *data;
    size_t count, capacity; /* in tuples, in floats */
};

/* A vertex of the mesh: the 0-based position, uv and normal (-1 = none) of a face's corner. */
struct corner {
    int32_t v, vt, vn;
    uint32_t next; /* vertex with the same v, or NO_VERTEX: equal corners are found in this chain */
};

struct obj {
    const char *path;
    int line;
    struct values v, vt, vn;
    struct corner *corners;
    size_t corner_count, corner_capacity;
    uint32_t *first; /* of each v: head of its chain */
    size_t first_count, first_capacity;
    uint32_t *indices;
    size_t index_count, index_capacity;
    bool lacks_uvs, lacks_normals; /* some corner does */
    struct fewray_error *error;
};

static int fail(const struct obj *obj, const char *what) {
    return fewray_fail(obj->error, FEWRAY_ERROR_FORMAT, obj->path, obj->line, "%s", what);
}

static int fail_memory(const struct obj *obj) {
    return fewray_fail(obj->error, FEWRAY_ERROR_MEMORY, obj->path, obj->line, "out of memory");
}

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

/* Over blanks, and over a line's end that a backslash hides. */
static const char *skip_blanks(struct obj *obj, const char *c) {
    for (;;) {
        if (is_blank(*c))
            c++;
        else if (c[0] == '\\' && c[1] == '\n')
            c += 2, obj->line++;
        else if (c[0] == '\\' && c[1] == '\r' && c[2] == '\n')
            c += 3, obj->line++;
        else
            return c;
    }
}

/* "nan" or "inf", as exporters write for the normals of degenerate faces. */
static bool is_not_finite(const char *c) {
    c += *c == '-' || *c == '+';
    return *c == 'n' || *c == 'N' || *c == 'i' || *c == 'I';
}

static bool ends_line(char c) {
    return !c || c == '\n' || c == '#';
}

/* Reads count numbers, the first needed of which must be there, into the next tuple of values. */
static int read_tuple(struct obj *obj, const char **cursor, struct values *values, int count,
                      int needed) {
    const char *c = *cursor;
    bool is_position = values == &obj->v;
    if (!array_reserve((void **)&values->data, &values->capacity,
                       (values->count + 1) * (size_t)count, sizeof(float)))
        return fail_memory(obj);
    float *to = values->data + values->count * (size_t)count;
    for (int i = 0; i < count; i++) {
        double value = 0;
        c = skip_blanks(obj, c);
        if (ends_line(*c)) {
            if (i < needed)
                return fail(obj, "a number is missing");
        } else if (number_read(&c, &value)) {
            if (!ends_line(*c) && !is_blank(*c) && *c != '\\')
                return fail(obj, "a number is malformed");
        } else if (is_not_finite(c)) {
            /* Mended when the mesh is built, where it isn't a position. */
            value = NAN;
            while (!ends_line(*c) && !is_blank(*c))
                c++;
        } else {
            return fail(obj, "a number is malformed");
        }
        if (is_position && !(fabs(value) <= FLT_MAX))
            return fail(obj, "a vertex is not finite");
        to[i] = (float)value;
    }
    if (++values->count > MESH_MAX_COUNT)
        return fail(obj, "the mesh is too large");
    *cursor = c;
    return FEWRAY_OK;
}

/* A 1-based or negative index of count values so far, as 0-based. */
static int read_index(const struct obj *obj, const char **cursor, size_t count, int32_t *out) {
    int64_t index;
    if (!number_read_integer(cursor, &index))
        return fail(obj, "a face's index is missing");
    int64_t zero_based = index > 0 ? index - 1 : (int64_t)count + index;
    if (index == 0 || zero_based < 0 || zero_based >= (int64_t)count)
        return fewray_fail(obj->error, FEWRAY_ERROR_FORMAT, obj->path, obj->line,
                           "a face's index %lld is out of range: there are %zu so far",
                           (long long)index, count);
    *out = (int32_t)zero_based;
    return FEWRAY_OK;
}

/* The mesh's vertex for a corner: an equal one, or a new one. */
static int add_corner(struct obj *obj, struct corner corner, uint32_t *vertex) {
    if (obj->first_count < obj->v.count) {
        if (!array_reserve((void **)&obj->first, &obj->first_capacity, obj->v.count,
                           sizeof(*obj->first)))
            return fail_memory(obj);
        memset(obj->first + obj->first_count, 0xff,
               (obj->v.count - obj->first_count) * sizeof(*obj->first));
        obj->first_count = obj->v.count;
    }
    uint32_t *head = &obj->first[corner.v];
    uint32_t i = *head;
    for (int step = 0; i != NO_VERTEX && step < MAX_CHAIN; i = obj->corners[i].next, step++)
        if (obj->corners[i].vt == corner.vt && obj->corners[i].vn == corner.vn) {
            *vertex = i;
            return FEWRAY_OK;
        }
    if (!array_reserve((void **)&obj->corners, &obj->corner_capacity, obj->corner_count + 1,
                       sizeof(*obj->corners)))
        return fail_memory(obj);
    if (obj->corner_count >= MESH_MAX_COUNT)
        return fail(obj, "the mesh is too large");
    corner.next = *head;
    *head = *vertex = (uint32_t)obj->corner_count;
    obj->corners[obj->corner_count++] = corner;
    return FEWRAY_OK;
}

/* Reads "v", "v/vt", "v//vn" or "v/vt/vn". */
static int read_corner(struct obj *obj, const char **cursor, uint32_t *vertex) {
    struct corner corner = {-1, -1, -1, NO_VERTEX};
    int status = read_index(obj, cursor, obj->v.count, &corner.v);
    if (status)
        return status;
    if (**cursor == '/') {
        ++*cursor;
        if (**cursor != '/') {
            status = read_index(obj, cursor, obj->vt.count, &corner.vt);
            if (status)
                return status;
        }
        if (**cursor == '/') {
            ++*cursor;
            status = read_index(obj, cursor, obj->vn.count, &corner.vn);
            if (status)
                return status;
        }
    }
    obj->lacks_uvs |= corner.vt < 0;
    obj->lacks_normals |= corner.vn < 0;
    return add_corner(obj, corner, vertex);
}

static int read_face(struct obj *obj, const char **cursor) {
    uint32_t first = 0, previous = 0, vertex = 0;
    int corner_count = 0;
    for (;; corner_count++) {
        *cursor = skip_blanks(obj, *cursor);
        if (ends_line(**cursor))
            break;
        int status = read_corner(obj, cursor, &vertex);
        if (status)
            return status;
        if (corner_count == 0)
            first = vertex;
        if (corner_count >= 2) {
            if (!array_reserve((void **)&obj->indices, &obj->index_capacity, obj->index_count + 3,
                               sizeof(*obj->indices)))
                return fail_memory(obj);
            uint32_t *to = obj->indices + obj->index_count;
            to[0] = first, to[1] = previous, to[2] = vertex;
            obj->index_count += 3;
        }
        previous = vertex;
    }
    if (corner_count < 3)
        return fail(obj, "a face has fewer than three corners");
    if (obj->index_count / 3 > MESH_MAX_COUNT)
        return fail(obj, "the mesh is too large");
    return FEWRAY_OK;
}

/* Reads what stands in a line that matters; *cursor ends somewhere before its end. */
static int read_line(struct obj *obj, const char **cursor) {
    const char *c = *cursor = skip_blanks(obj, *cursor);
    if (c[0] == 'v' && is_blank(c[1])) {
        *cursor += 2;
        return read_tuple(obj, cursor, &obj->v, 3, 3);
    }
    if (c[0] == 'v' && c[1] == 't' && is_blank(c[2])) {
        *cursor += 3;
        return read_tuple(obj, cursor, &obj->vt, 2, 1);
    }
    if (c[0] == 'v' && c[1] == 'n' && is_blank(c[2])) {
        *cursor += 3;
        return read_tuple(obj, cursor, &obj->vn, 3, 3);
    }
    if (c[0] == 'f' && is_blank(c[1])) {
        *cursor += 2;
        return read_face(obj, cursor);
    }
    return FEWRAY_OK;
}

static int read_lines(struct obj *obj, const char *text, size_t size) {
    const char *c = text, *end = text + size;
    for (obj->line = 1; c < end; obj->line++) {
        int status = read_line(obj, &c);
        if (status)
            return status;
        while (c < end && *c != '\n')
            c++;
        c++;
    }
    obj->line = 0;
    if (!obj->index_count)
        return fail(obj, "the mesh has no faces");
    return FEWRAY_OK;
}

static int assemble(const struct obj *obj, struct mesh_data *out) {
    if (!mesh_data_allocate(out, obj->corner_count, obj->index_count / 3, !obj->lacks_normals,
                            !obj->lacks_uvs)) {
        mesh_data_free(out);
        return fail_memory(obj);
    }
    memcpy(out->indices, obj->indices, obj->index_count * sizeof(uint32_t));
    for (size_t i = 0; i < obj->corner_count; i++) {
        const struct corner *corner = &obj->corners[i];
        memcpy(out->positions + 3 * i, obj->v.data + 3 * (size_t)corner->v, 3 * sizeof(float));
        if (out->normals)
            memcpy(out->normals + 3 * i, obj->vn.data + 3 * (size_t)corner->vn, 3 * sizeof(float));
        if (out->uvs)
            memcpy(out->uvs + 2 * i, obj->vt.data + 2 * (size_t)corner->vt, 2 * sizeof(float));
    }
    return FEWRAY_OK;
}

int mesh_parse_obj(const char *path, const char *text, size_t size, struct mesh_data *out,
                   struct fewray_error *error) {
    struct obj obj = {.path = path, .error = error};
    *out = (struct mesh_data){0};
    int status = read_lines(&obj, text, size);
    if (!status)
        status = assemble(&obj, out);
    free(obj.v.data);
    free(obj.vt.data);
    free(obj.vn.data);
    free(obj.corners);
    free(obj.first);
    free(obj.indices);
    return status;
}

int mesh_read_obj(const char *path, struct mesh_data *out, struct fewray_error *error) {
    struct file_bytes file;
    *out = (struct mesh_data){0};
    int status = file_read(path, &file, error);
    if (status)
        return status;
    status = mesh_parse_obj(path, file.data, file.size, out, error);
    file_free(&file);
    return status;
}
