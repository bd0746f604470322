/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_OBJ_CHUNK_H
#define FEWRAY_GUIDE_SCENE_OBJ_CHUNK_H

/* A part of an OBJ file's lines, which can be parsed while other threads parse the other parts. A
 * face refers to what stands before it in the file by number, so that each chunk is counted first.
 */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fewray/features.h"

/* Numbers of lines and of "v", "vt", "vn" and "f" among them. */
struct obj_counts {
    size_t lines, v, vt, vn, f;
};

/* What the numbers of the whole file become: (v, 3), (vt, 2), (vn, 3). */
struct obj_values {
    float *v, *vt, *vn;
};

/* A face's corner: 0-based position, uv and normal, -1 = none. */
struct obj_corner {
    int32_t v, vt, vn;
};

struct obj_chunk {
    const char *begin, *end;       /* whole lines; no backslash hides the last one's end */
    struct obj_counts own, before; /* of this chunk; of all chunks before it */

    struct obj_corner *corners; /* of faces, one after the other; freed by the owner */
    size_t corner_count, corner_capacity;
    uint32_t *faces; /* number of corners of each; freed by the owner */
    size_t face_count;
    bool lacks_uvs, lacks_normals; /* some corner does */

    int status;
    struct fewray_error error;
};

/* Fills own. Where a line is malformed the counts of later ones may be wrong. */
void obj_chunk_count(struct obj_chunk *chunk);

/* Reads the lines: numbers into their places in values, faces into the chunk. Needs before; sets
 * status, and error in the name of path. */
void obj_chunk_parse(struct obj_chunk *chunk, const char *path, const struct obj_values *values);

#endif
