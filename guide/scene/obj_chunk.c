/* SPDX-License-Identifier: Apache-2.0 */
/* The lines of an OBJ file. */

#include "guide/scene/obj_chunk.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/memory.h"
#include "guide/scene/mesh_data.h"
#include "guide/scene/number.h"

struct reader {
    const char *path;
    struct obj_chunk *chunk;
    const struct obj_values *values;
    struct obj_counts so_far; /* of the file; lines: the one being read, from 1 */
};

static int fail(const struct reader *in, const char *what) {
    return fewray_fail(&in->chunk->error, FEWRAY_ERROR_FORMAT, in->path, (int)in->so_far.lines,
                       "%s", what);
}

static int fail_memory(const struct reader *in) {
    return fewray_fail(&in->chunk->error, FEWRAY_ERROR_MEMORY, in->path, 0, "out of memory");
}

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

/* Over blanks, and over a line's end that a backslash hides. */
static const char *skip_blanks(struct reader *in, const char *c) {
    for (;;) {
        if (is_blank(*c))
            c++;
        else if (c[0] == '\\' && c[1] == '\n')
            c += 2, in->so_far.lines++;
        else if (c[0] == '\\' && c[1] == '\r' && c[2] == '\n')
            c += 3, in->so_far.lines++;
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

/* Reads size numbers, the first needed of which must be there, as tuple number *count of values,
 * which has room for limit. */
static int read_tuple(struct reader *in, const char **cursor, float *values, size_t *count,
                      size_t limit, int size, int needed) {
    const char *c = *cursor;
    bool is_position = values == in->values->v;
    if (*count >= limit) /* counted wrongly behind a malformed line, which is to be told instead */
        return fail(in, "a line is malformed");
    float *to = values + *count * (size_t)size;
    for (int i = 0; i < size; i++) {
        double value = 0;
        c = skip_blanks(in, c);
        if (ends_line(*c)) {
            if (i < needed)
                return fail(in, "a number is missing");
        } else if (number_read(&c, &value)) {
            if (!ends_line(*c) && !is_blank(*c) && *c != '\\')
                return fail(in, "a number is malformed");
        } else if (is_not_finite(c)) {
            /* Mended when the mesh is built, where it isn't a position. */
            value = NAN;
            while (!ends_line(*c) && !is_blank(*c))
                c++;
        } else {
            return fail(in, "a number is malformed");
        }
        if (is_position && !(fabs(value) <= FLT_MAX))
            return fail(in, "a vertex is not finite");
        to[i] = (float)value;
    }
    ++*count;
    *cursor = c;
    return FEWRAY_OK;
}

/* A 1-based or negative index of count values so far, as 0-based. */
static int read_index(const struct reader *in, const char **cursor, size_t count, int32_t *out) {
    int64_t index;
    if (!number_read_integer(cursor, &index))
        return fail(in, "a face's index is missing");
    int64_t zero_based = index > 0 ? index - 1 : (int64_t)count + index;
    if (index == 0 || zero_based < 0 || zero_based >= (int64_t)count)
        return fewray_fail(&in->chunk->error, FEWRAY_ERROR_FORMAT, in->path, (int)in->so_far.lines,
                           "a face's index %lld is out of range: there are %zu so far",
                           (long long)index, count);
    *out = (int32_t)zero_based;
    return FEWRAY_OK;
}

/* Reads "v", "v/vt", "v//vn" or "v/vt/vn" as the chunk's next corner. */
static int read_corner(struct reader *in, const char **cursor) {
    struct obj_chunk *chunk = in->chunk;
    struct obj_corner corner = {-1, -1, -1};
    int status = read_index(in, cursor, in->so_far.v, &corner.v);
    if (status)
        return status;
    if (**cursor == '/') {
        ++*cursor;
        if (**cursor != '/') {
            status = read_index(in, cursor, in->so_far.vt, &corner.vt);
            if (status)
                return status;
        }
        if (**cursor == '/') {
            ++*cursor;
            status = read_index(in, cursor, in->so_far.vn, &corner.vn);
            if (status)
                return status;
        }
    }
    chunk->lacks_uvs |= corner.vt < 0;
    chunk->lacks_normals |= corner.vn < 0;
    if (!array_reserve((void **)&chunk->corners, &chunk->corner_capacity, chunk->corner_count + 1,
                       sizeof(*chunk->corners)))
        return fail_memory(in);
    chunk->corners[chunk->corner_count++] = corner;
    return FEWRAY_OK;
}

static int read_face(struct reader *in, const char **cursor) {
    struct obj_chunk *chunk = in->chunk;
    const size_t first = chunk->corner_count;
    for (;;) {
        *cursor = skip_blanks(in, *cursor);
        if (ends_line(**cursor))
            break;
        int status = read_corner(in, cursor);
        if (status)
            return status;
    }
    const size_t corners = chunk->corner_count - first;
    if (corners < 3)
        return fail(in, "a face has fewer than three corners");
    if (chunk->face_count >= chunk->own.f) /* as in read_tuple() */
        return fail(in, "a line is malformed");
    if (corners > MESH_MAX_COUNT)
        return fail(in, "the mesh is too large");
    chunk->faces[chunk->face_count++] = (uint32_t)corners;
    return FEWRAY_OK;
}

/* What a line begins with. */
enum keyword { KEYWORD_OTHER, KEYWORD_V, KEYWORD_VT, KEYWORD_VN, KEYWORD_F };

static enum keyword keyword_of(const char *c) {
    if (c[0] == 'v' && is_blank(c[1]))
        return KEYWORD_V;
    if (c[0] == 'v' && c[1] == 't' && is_blank(c[2]))
        return KEYWORD_VT;
    if (c[0] == 'v' && c[1] == 'n' && is_blank(c[2]))
        return KEYWORD_VN;
    return c[0] == 'f' && is_blank(c[1]) ? KEYWORD_F : KEYWORD_OTHER;
}

/* Reads what stands in a line that matters; *cursor ends somewhere before its end. */
static int read_line(struct reader *in, const char **cursor) {
    const struct obj_values *values = in->values;
    const struct obj_counts *before = &in->chunk->before, *own = &in->chunk->own;
    struct obj_counts *so_far = &in->so_far;
    *cursor = skip_blanks(in, *cursor);
    const enum keyword keyword = keyword_of(*cursor);
    *cursor += keyword == KEYWORD_OTHER ? 0 : keyword == KEYWORD_V || keyword == KEYWORD_F ? 2 : 3;
    switch (keyword) {
    case KEYWORD_V:
        return read_tuple(in, cursor, values->v, &so_far->v, before->v + own->v, 3, 3);
    case KEYWORD_VT:
        return read_tuple(in, cursor, values->vt, &so_far->vt, before->vt + own->vt, 2, 1);
    case KEYWORD_VN:
        return read_tuple(in, cursor, values->vn, &so_far->vn, before->vn + own->vn, 3, 3);
    case KEYWORD_F:
        return read_face(in, cursor);
    default:
        return FEWRAY_OK;
    }
}

/* A line that continues another one is looked at like any other: where that makes a difference, it
 * is malformed. */
void obj_chunk_count(struct obj_chunk *chunk) {
    struct obj_counts own = {0};
    for (const char *c = chunk->begin; c < chunk->end; own.lines++) {
        while (is_blank(*c))
            c++;
        const enum keyword keyword = keyword_of(c);
        own.v += keyword == KEYWORD_V;
        own.vt += keyword == KEYWORD_VT;
        own.vn += keyword == KEYWORD_VN;
        own.f += keyword == KEYWORD_F;
        c = memchr(c, '\n', (size_t)(chunk->end - c));
        c = c ? c + 1 : chunk->end;
    }
    chunk->own = own;
}

void obj_chunk_parse(struct obj_chunk *chunk, const char *path, const struct obj_values *values) {
    struct reader in = {path, chunk, values, chunk->before};
    chunk->faces = malloc((chunk->own.f + 1) * sizeof(*chunk->faces));
    if (!chunk->faces || !array_reserve((void **)&chunk->corners, &chunk->corner_capacity,
                                        3 * chunk->own.f, sizeof(*chunk->corners)))
        chunk->status = fail_memory(&in);
    for (const char *c = chunk->begin; c < chunk->end && !chunk->status;) {
        in.so_far.lines++;
        chunk->status = read_line(&in, &c);
        while (c < chunk->end && *c != '\n')
            c++;
        c++;
    }
}
