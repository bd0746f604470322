/* SPDX-License-Identifier: Apache-2.0 */
/* A scene in glTF 2.0, as JSON with its buffer beside it, or as one binary file. */

#include <string.h>

#include "fewray/guide.h"
#include "tests/fuzz/fuzz.h"

static const char *const names[] = {"buffer.bin", "image.png", NULL};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const bool binary = size >= 4 && !memcmp(data, "glTF", 4);
    const struct fewray_scene_options options = {.threads = 1};
    const char *path =
        binary ? fuzz_file("scene.glb", data, size) : fuzz_files(data, size, "scene.gltf", names);
    fuzz_load_scene(path, &options);
    return 0;
}
