/* SPDX-License-Identifier: Apache-2.0 */
/* Wavefront OBJ: the text is split into chunks of whole lines, which are counted, then parsed, each
 * by whoever of the surrounding team has time. The chunks don't depend on the number of threads. */

#include <stdlib.h>
#include <string.h>

#include "guide/scene/file_bytes.h"
#include "guide/scene/memory.h"
#include "guide/scene/mesh_data.h"
#include "guide/scene/obj_chunk.h"
#include "guide/scene/team.h"

#define CHUNK_BYTES ((size_t)1 << 18)
#define NO_VERTEX   UINT32_MAX
/* How far an equal corner is looked for: longer chains occur only in files that are made to be
 * slow. */
#define MAX_CHAIN 256

/* A vertex of the mesh, in a chain of those with the same position. */
struct vertex {
    struct obj_corner corner;
    uint32_t next; /* or NO_VERTEX */
};

struct obj {
    const char *path;
    struct obj_chunk *chunks;
    size_t chunk_count;
    struct obj_counts counts; /* of the file */
    struct obj_values values;
    struct vertex *vertices;
    size_t vertex_count, vertex_capacity;
    uint32_t *first; /* (counts.v): head of each position's chain */
    struct fewray_error *error;
};

static int fail(const struct obj *obj, const char *what) {
    return fewray_fail(obj->error, FEWRAY_ERROR_FORMAT, obj->path, 0, "%s", what);
}

static int fail_memory(const struct obj *obj) {
    return fewray_fail(obj->error, FEWRAY_ERROR_MEMORY, obj->path, 0, "out of memory");
}

/* The end of the line around c, which no backslash hides. */
static const char *find_line_end(const char *c, const char *begin, const char *end) {
    while (c < end) {
        c = memchr(c, '\n', (size_t)(end - c));
        if (!c)
            return end;
        const char *last = c > begin && c[-1] == '\r' ? c - 1 : c;
        c++;
        if (last == begin || last[-1] != '\\')
            return c;
    }
    return end;
}

static int split(struct obj *obj, const char *text, size_t size) {
    const char *end = text + size;
    obj->chunks = calloc(size / CHUNK_BYTES + 1, sizeof(*obj->chunks));
    if (!obj->chunks)
        return fail_memory(obj);
    for (const char *c = text; c < end;) {
        struct obj_chunk *chunk = &obj->chunks[obj->chunk_count++];
        chunk->begin = c;
        c = (size_t)(end - c) > CHUNK_BYTES ? find_line_end(c + CHUNK_BYTES - 1, text, end) : end;
        chunk->end = c;
    }
    return FEWRAY_OK;
}

static int count(struct obj *obj) {
    struct obj_counts sum = {0};
#pragma omp taskloop num_tasks(team_tasks())
    for (size_t i = 0; i < obj->chunk_count; i++)
        obj_chunk_count(&obj->chunks[i]);
    for (size_t i = 0; i < obj->chunk_count; i++) {
        const struct obj_counts *own = &obj->chunks[i].own;
        obj->chunks[i].before = sum;
        sum.lines += own->lines;
        sum.v += own->v;
        sum.vt += own->vt;
        sum.vn += own->vn;
    }
    obj->counts = sum;
    if (sum.v > MESH_MAX_COUNT || sum.vt > MESH_MAX_COUNT || sum.vn > MESH_MAX_COUNT)
        return fail(obj, "the mesh is too large");
    obj->values = (struct obj_values){malloc((3 * sum.v + 1) * sizeof(float)),
                                      malloc((2 * sum.vt + 1) * sizeof(float)),
                                      malloc((3 * sum.vn + 1) * sizeof(float))};
    return obj->values.v && obj->values.vt && obj->values.vn ? FEWRAY_OK : fail_memory(obj);
}

/* Of several failures the first in the file is told. */
static int parse(struct obj *obj) {
#pragma omp taskloop num_tasks(team_tasks())
    for (size_t i = 0; i < obj->chunk_count; i++)
        obj_chunk_parse(&obj->chunks[i], obj->path, &obj->values);
    for (size_t i = 0; i < obj->chunk_count; i++)
        if (obj->chunks[i].status) {
            if (obj->error)
                *obj->error = obj->chunks[i].error;
            return obj->chunks[i].status;
        }
    return FEWRAY_OK;
}

/* The mesh's vertex for a corner: an equal one, or a new one. */
static int find_vertex(struct obj *obj, const struct obj_corner *corner, uint32_t *vertex) {
    uint32_t *head = &obj->first[corner->v], i = *head;
    for (int step = 0; i != NO_VERTEX && step < MAX_CHAIN; i = obj->vertices[i].next, step++)
        if (obj->vertices[i].corner.vt == corner->vt && obj->vertices[i].corner.vn == corner->vn) {
            *vertex = i;
            return FEWRAY_OK;
        }
    if (!array_reserve((void **)&obj->vertices, &obj->vertex_capacity, obj->vertex_count + 1,
                       sizeof(*obj->vertices)))
        return fail_memory(obj);
    if (obj->vertex_count >= MESH_MAX_COUNT)
        return fail(obj, "the mesh is too large");
    obj->vertices[obj->vertex_count] = (struct vertex){*corner, *head};
    *head = *vertex = (uint32_t)obj->vertex_count++;
    return FEWRAY_OK;
}

/* Finds the vertices in the order of the faces; each corner's v becomes its vertex. */
static int join_corners(struct obj *obj) {
    obj->first = malloc((obj->counts.v + 1) * sizeof(*obj->first));
    if (!obj->first)
        return fail_memory(obj);
    memset(obj->first, 0xff, obj->counts.v * sizeof(*obj->first));
    for (size_t i = 0; i < obj->chunk_count; i++) {
        struct obj_chunk *chunk = &obj->chunks[i];
        for (size_t j = 0; j < chunk->corner_count; j++) {
            uint32_t vertex = NO_VERTEX;
            int status = find_vertex(obj, &chunk->corners[j], &vertex);
            if (status)
                return status;
            chunk->corners[j].v = (int32_t)vertex;
        }
    }
    return FEWRAY_OK;
}

static void fill_vertex(const struct obj *obj, size_t i, struct mesh_data *out) {
    const struct obj_corner *corner = &obj->vertices[i].corner;
    memcpy(out->positions + 3 * i, obj->values.v + 3 * (size_t)corner->v, 3 * sizeof(float));
    if (out->normals)
        memcpy(out->normals + 3 * i, obj->values.vn + 3 * (size_t)corner->vn, 3 * sizeof(float));
    if (out->uvs)
        memcpy(out->uvs + 2 * i, obj->values.vt + 2 * (size_t)corner->vt, 2 * sizeof(float));
}

/* Fans of triangles from the chunk's polygons; returns the end of what was written. */
static uint32_t *write_triangles(const struct obj_chunk *chunk, uint32_t *to) {
    const struct obj_corner *corner = chunk->corners;
    for (size_t i = 0; i < chunk->face_count; corner += chunk->faces[i++])
        for (uint32_t j = 2; j < chunk->faces[i]; j++) {
            *to++ = (uint32_t)corner[0].v;
            *to++ = (uint32_t)corner[j - 1].v;
            *to++ = (uint32_t)corner[j].v;
        }
    return to;
}

static int assemble(const struct obj *obj, struct mesh_data *out) {
    bool lacks_uvs = false, lacks_normals = false;
    size_t triangles = 0;
    for (size_t i = 0; i < obj->chunk_count; i++) {
        lacks_uvs |= obj->chunks[i].lacks_uvs;
        lacks_normals |= obj->chunks[i].lacks_normals;
        triangles += obj->chunks[i].corner_count - 2 * obj->chunks[i].face_count;
    }
    if (!triangles)
        return fail(obj, "the mesh has no faces");
    if (triangles > MESH_MAX_COUNT)
        return fail(obj, "the mesh is too large");
    if (!mesh_data_allocate(out, obj->vertex_count, triangles, !lacks_normals, !lacks_uvs)) {
        mesh_data_free(out);
        return fail_memory(obj);
    }
#pragma omp taskloop num_tasks(team_tasks())
    for (size_t i = 0; i < obj->vertex_count; i++)
        fill_vertex(obj, i, out);
    uint32_t *to = out->indices;
    for (size_t i = 0; i < obj->chunk_count; i++)
        to = write_triangles(&obj->chunks[i], to);
    return FEWRAY_OK;
}

int mesh_parse_obj(const char *path, const char *text, size_t size, struct mesh_data *out,
                   struct fewray_error *error) {
    struct obj obj = {.path = path, .error = error};
    *out = (struct mesh_data){0};
    int status;
    if (!(status = split(&obj, text, size)) && !(status = count(&obj)) && !(status = parse(&obj)) &&
        !(status = join_corners(&obj)))
        status = assemble(&obj, out);
    for (size_t i = 0; i < obj.chunk_count; i++) {
        free(obj.chunks[i].corners);
        free(obj.chunks[i].faces);
    }
    free(obj.chunks);
    free(obj.values.v);
    free(obj.values.vt);
    free(obj.values.vn);
    free(obj.vertices);
    free(obj.first);
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
