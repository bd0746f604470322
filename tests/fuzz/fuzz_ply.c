/* SPDX-License-Identifier: Apache-2.0 */
/* A mesh in PLY. */

#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    struct mesh_data mesh;
    struct fewray_error error = {0};
    const int status = mesh_read_ply(fuzz_file("mesh.ply", data, size), &mesh, &error);
    fuzz_check_error(status, &error);
    if (!status)
        fuzz_check_mesh(&mesh);
    mesh_data_free(&mesh);
    return 0;
}
