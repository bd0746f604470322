/* SPDX-License-Identifier: Apache-2.0 */
/* A scene in OBJ with materials of an MTL file. */

#include "guide/guide.h"
#include "tests/fuzz/fuzz.h"

static const char *const names[] = {"scene.mtl", "image.png", NULL};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const struct fewray_scene_options options = {.threads = 1};
    struct fewray_scene *scene = NULL;
    struct fewray_error error = {0};
    const int status =
        fewray_scene_load(fuzz_files(data, size, "scene.obj", names), &options, &scene, &error);
    fuzz_check_error(status, &error);
    FUZZ_CHECK(!status == !!scene);
    if (scene)
        fuzz_check_scene(scene);
    fewray_scene_destroy(&scene);
    return 0;
}
