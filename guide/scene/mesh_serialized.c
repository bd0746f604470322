/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes in Mitsuba's serialized format: a file of several, each compressed by zlib, with a table
 * of their places at its end. All numbers are little endian. */

#include <float.h>
#include <math.h>
#include <string.h>
#include <zlib.h>

#include "guide/scene/file_bytes.h"
#include "guide/scene/mesh_data.h"

#define FILE_FORMAT  0x041c
#define HEADER_BYTES 4
/* zlib makes a byte of at most so many. */
#define MAX_RATIO 1032
/* Bytes of a mesh's name. */
#define MAX_NAME 65536

enum serialized_flags {
    HAS_NORMALS = 0x1,
    HAS_UVS = 0x2,
    HAS_COLORS = 0x8,
    IS_SINGLE = 0x1000,
    IS_DOUBLE = 0x2000
};

struct serialized {
    const char *path;
    struct file_bytes file;
    int version;
    size_t begin, end; /* of the mesh's compressed bytes */
    z_stream stream;
    bool inflating;
    bool is_double;
    struct fewray_error *error;
};

static int fail(const struct serialized *in, const char *what) {
    return fewray_fail(in->error, FEWRAY_ERROR_FORMAT, in->path, 0, "%s", what);
}

static uint64_t little_endian(const void *bytes, int count) {
    const unsigned char *b = bytes;
    uint64_t value = 0;
    for (int i = count - 1; i >= 0; i--)
        value = value << 8 | b[i];
    return value;
}

/* --- the file */

/* Where mesh `index` lies, by the table at the file's end: an offset of each, then their number. */
static int find_mesh(struct serialized *in, int index) {
    size_t size = in->file.size;
    const char *data = in->file.data;
    if (size < 2 * HEADER_BYTES || little_endian(data, 2) != FILE_FORMAT)
        return fail(in, "not a file in Mitsuba's serialized format");
    in->version = (int)little_endian(data + 2, 2);
    if (in->version != 3 && in->version != 4)
        return fewray_fail(in->error, FEWRAY_ERROR_UNSUPPORTED, in->path, 0,
                           "version %d of the serialized format is not supported: only 3 and 4",
                           in->version);
    size_t entry = in->version == 4 ? 8 : 4;
    uint64_t count = little_endian(data + size - 4, 4);
    if (count > (size - 4 - HEADER_BYTES) / entry)
        return fail(in, "the table of meshes is damaged");
    if ((uint64_t)index >= count)
        return fewray_fail(in->error, FEWRAY_ERROR_FORMAT, in->path, 0,
                           "shape_index = %d, but the file holds %llu meshes", index,
                           (unsigned long long)count);
    size_t table = size - 4 - entry * (size_t)count;
    uint64_t offset = little_endian(data + table + entry * (size_t)index, (int)entry);
    if (offset > table || table - offset < HEADER_BYTES)
        return fail(in, "the table of meshes is damaged");
    in->begin = (size_t)offset + HEADER_BYTES;
    in->end = table;
    return FEWRAY_OK;
}

/* --- the compressed bytes */

/* Inflates exactly size bytes. */
static int take(struct serialized *in, void *out, size_t size) {
    z_stream *stream = &in->stream;
    char *to = out;
    while (size > 0) {
        size_t left = in->end - in->begin, most = 1u << 30;
        uInt wanted = (uInt)(size < most ? size : most);
        if (stream->avail_in == 0) {
            stream->avail_in = (uInt)(left < most ? left : most);
            stream->next_in = (Bytef *)in->file.data + in->begin;
            in->begin += stream->avail_in;
        }
        stream->next_out = (Bytef *)to;
        stream->avail_out = wanted;
        int code = inflate(stream, Z_NO_FLUSH);
        size_t got = wanted - stream->avail_out;
        to += got;
        size -= got;
        if (code == Z_MEM_ERROR)
            return fewray_fail(in->error, FEWRAY_ERROR_MEMORY, in->path, 0, "out of memory");
        if (code != Z_OK && code != Z_STREAM_END && code != Z_BUF_ERROR)
            return fail(in, "the compressed mesh is damaged");
        bool starved = stream->avail_in == 0 && in->begin == in->end;
        if (size > 0 && (code != Z_OK || (got == 0 && starved)))
            return fail(in, "the mesh is truncated");
    }
    return FEWRAY_OK;
}

/* Reads `count` numbers of the file's precision; NaN and infinities stay. out may be NULL. */
static int take_numbers(struct serialized *in, float *out, size_t count) {
    union {
        float single[1024];
        double precise[512];
        char bytes[4096];
    } buffer;
    size_t item = in->is_double ? sizeof(double) : sizeof(float);
    size_t most = sizeof(buffer) / item;
    for (size_t done = 0; done < count;) {
        size_t n = count - done < most ? count - done : most;
        int status = take(in, buffer.bytes, n * item);
        if (status)
            return status;
        for (size_t i = 0; out && i < n; i++)
            out[done + i] = in->is_double ? (float)buffer.precise[i] : buffer.single[i];
        done += n;
    }
    return FEWRAY_OK;
}

/* --- the mesh */

static int skip_name(struct serialized *in) {
    char c = 0;
    for (int i = 0; i < MAX_NAME; i++) {
        const int status = take(in, &c, 1);
        if (status || !c)
            return status;
    }
    return fail(in, "the mesh's name is endless");
}

/* Refuses counts that the compressed bytes can't hold, before memory is taken for them. */
static int check_counts(const struct serialized *in, uint64_t vertices, uint64_t triangles) {
    double most = (double)(in->file.size) * MAX_RATIO;
    double item = in->is_double ? sizeof(double) : sizeof(float);
    if (vertices > MESH_MAX_COUNT || triangles > MESH_MAX_COUNT)
        return fail(in, "the mesh is too large");
    if (3 * item * (double)vertices + 3 * sizeof(uint32_t) * (double)triangles > most)
        return fail(in, "the mesh is truncated");
    return FEWRAY_OK;
}

static int check_mesh(const struct serialized *in, const struct mesh_data *mesh) {
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++)
        if (!(fabsf(mesh->positions[i]) <= FLT_MAX))
            return fewray_fail(in->error, FEWRAY_ERROR_FORMAT, in->path, 0,
                               "vertex %zu is not finite", i / 3);
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++)
        if (mesh->indices[i] >= mesh->vertex_count)
            return fewray_fail(in->error, FEWRAY_ERROR_FORMAT, in->path, 0,
                               "triangle %zu: index %u is out of range", i / 3, mesh->indices[i]);
    return FEWRAY_OK;
}

static int read_mesh(struct serialized *in, struct mesh_data *out) {
    unsigned char head[4], counts[16];
    int status = take(in, head, sizeof(head));
    if (!status && in->version == 4)
        status = skip_name(in);
    if (!status)
        status = take(in, counts, sizeof(counts));
    if (status)
        return status;
    unsigned flags = (unsigned)little_endian(head, 4);
    uint64_t vertices = little_endian(counts, 8), triangles = little_endian(counts + 8, 8);
    in->is_double = flags & IS_DOUBLE;
    if (!(flags & IS_SINGLE) == !in->is_double)
        return fail(in, "the mesh is neither of single nor of double precision");
    status = check_counts(in, vertices, triangles);
    if (status)
        return status;
    status = fewray_memory_check(in->path, "the mesh",
                                 32.0 * (double)vertices + 12.0 * (double)triangles, in->error);
    if (status)
        return status;
    if (!mesh_data_allocate(out, (size_t)vertices, (size_t)triangles, flags & HAS_NORMALS,
                            flags & HAS_UVS))
        return fewray_fail(in->error, FEWRAY_ERROR_MEMORY, in->path, 0, "out of memory");
    status = take_numbers(in, out->positions, 3 * (size_t)vertices);
    if (!status && (flags & HAS_NORMALS))
        status = take_numbers(in, out->normals, 3 * (size_t)vertices);
    if (!status && (flags & HAS_UVS))
        status = take_numbers(in, out->uvs, 2 * (size_t)vertices);
    if (!status && (flags & HAS_COLORS))
        status = take_numbers(in, NULL, 3 * (size_t)vertices);
    if (!status)
        status = take(in, out->indices, 3 * sizeof(uint32_t) * (size_t)triangles);
    return status ? status : check_mesh(in, out);
}

int mesh_read_serialized(const char *path, int index, struct mesh_data *out,
                         struct fewray_error *error) {
    struct serialized in = {.path = path, .error = error};
    *out = (struct mesh_data){0};
    int status = file_read(path, &in.file, error);
    if (status)
        return status;
    status = find_mesh(&in, index);
    if (!status) {
        in.inflating = inflateInit(&in.stream) == Z_OK;
        status = in.inflating ? read_mesh(&in, out)
                              : fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    }
    if (in.inflating)
        inflateEnd(&in.stream);
    file_free(&in.file);
    if (status)
        mesh_data_free(out);
    return status;
}
