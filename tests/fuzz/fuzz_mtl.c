/* SPDX-License-Identifier: Apache-2.0 */
/* A scene in OBJ with materials of an MTL file. */

#include "fewray/guide.h"
#include "tests/fuzz/fuzz.h"

static const char *const names[] = {"scene.mtl", "image.png", NULL};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const struct fewray_scene_options options = {.threads = 1};
    fuzz_load_scene(fuzz_files(data, size, "scene.obj", names), &options);
    return 0;
}
