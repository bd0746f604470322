/* SPDX-License-Identifier: Apache-2.0 */
/* A scene in Mitsuba's XML, with the files that it includes and names. */

#include "fewray/guide.h"
#include "tests/fuzz/fuzz.h"

static const char *const names[] = {"part.xml", "mesh.obj", "mesh.ply", "curve.spd", NULL};

static int load(const char *path, bool lenient) {
    const struct fewray_scene_options options = {.threads = 1, .frame = "3", .lenient = lenient};
    return fuzz_load_scene(path, &options);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *path = fuzz_files(data, size, "scene.xml", names);
    if (load(path, false) == FEWRAY_ERROR_UNSUPPORTED)
        load(path, true);
    return 0;
}
