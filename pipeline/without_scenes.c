/* SPDX-License-Identifier: Apache-2.0 */
/* In place of the scenes, for a command that is built without the renderer: they are refused. */
#include "fewray/guide.h"

int fewray_scene_load(const char *path, const struct fewray_scene_options *options,
                      struct fewray_scene **out, struct fewray_error *error) {
    (void)options;
    *out = NULL;
    return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                       "this fewray was built without the renderer: it reads EXRs alone");
}

struct fewray_scene_summary fewray_scene_summarize(const struct fewray_scene *scene) {
    (void)scene;
    return (struct fewray_scene_summary){.width = 0};
}

void fewray_scene_destroy(struct fewray_scene **scene) {
    *scene = NULL;
}
