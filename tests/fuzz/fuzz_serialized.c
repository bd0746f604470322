/* SPDX-License-Identifier: Apache-2.0 */
/* A mesh in Mitsuba's serialized format. zlib's checksum and its codes stop nearly every change to
 * a compressed file, so the input is what the mesh inflates to: version, then its bytes; or, where
 * it starts with the format's own number, the file itself. */

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "tests/fuzz/fuzz.h"

static void read_file(const void *data, size_t size) {
    struct mesh_data mesh;
    struct fewray_error error = {0};
    const char *path = fuzz_file("mesh.serialized", data, size);
    for (int index = 0; index < 2; index++) {
        const int status = mesh_read_serialized(path, index, &mesh, &error);
        fuzz_check_error(status, &error);
        if (!status && mesh.triangle_count)
            fuzz_check_mesh(&mesh);
        mesh_data_free(&mesh);
    }
}

/* One mesh, packed, with the file's head and table around it. */
static void read_packed(int version, const uint8_t *data, size_t size) {
    uLongf packed = compressBound(size);
    const size_t table = version == 4 ? 12 : 8;
    uint8_t *file = calloc(1, 4 + packed + table);
    FUZZ_CHECK(file && compress2(file + 4, &packed, data, size, 1) == Z_OK);
    const uint8_t head[4] = {0x1c, 0x04, (uint8_t)version, 0};
    memcpy(file, head, sizeof(head));
    file[4 + packed + table - 4] = 1;
    read_file(file, 4 + packed + table);
    free(file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < 2)
        return 0;
    if (data[0] == 0x1c && data[1] == 0x04)
        read_file(data, size);
    else
        read_packed(data[0] == 3 ? 3 : 4, data + 1, size - 1);
    return 0;
}
