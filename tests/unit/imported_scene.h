/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_IMPORTED_SCENE_H
#define FEWRAY_TESTS_IMPORTED_SCENE_H

/* Scenes that came from glTF or OBJ + MTL, and what is asked of them. */

#include <math.h>

#include "scene_scratch.h"

static inline struct fewray_scene *load(const char *path) {
    struct fewray_scene *scene = NULL;
    struct fewray_error error = {0};
    if (fewray_scene_load(path, NULL, &scene, &error))
        fail_msg("%s: %s", error.file, error.what);
    return scene;
}

/* The scene's BSDF, or what is inside wrappers around it. */
static inline const struct bsdf *unwrapped(const struct fewray_scene *scene, int index,
                                           enum bsdf_kind wrapper) {
    const struct bsdf *bsdf = &scene->bsdfs[index];
    assert_int_equal(bsdf->kind, wrapper);
    return &scene->bsdfs[bsdf->nested[0]];
}

static inline void assert_color(struct vec3 c, double r, double g, double b) {
    assert_near(c.x, r, 1e-5 * (1 + fabs(r)));
    assert_near(c.y, g, 1e-5 * (1 + fabs(g)));
    assert_near(c.z, b, 1e-5 * (1 + fabs(b)));
}

static inline float grey(const struct fewray_scene *scene, int texture) {
    assert_true(texture >= 0);
    assert_int_equal(scene->textures[texture].kind, TEXTURE_CONSTANT);
    return scene->textures[texture].color0.x;
}

/* Red, green; the second is half transparent. G and B of the other one: roughness and metal. */
static inline void write_textures(void) {
    static const uint8_t metallic_roughness[12] = {0, 255, 51, 0, 102, 255, 0, 0, 0, 0, 0, 0};
    struct fewray_frame *frame = NULL;
    const char *const names[] = {"R", "G", "B", "A"};
    const float rgba[4][2] = {{1, 0}, {0, 1}, {0, 0}, {1, 0.5f}};
    assert_int_equal(fewray_image_write_png(scratch_path("mr.png"), 2, 2, metallic_roughness, NULL),
                     FEWRAY_OK);
    assert_int_equal(fewray_frame_create(2, 1, &frame, NULL), FEWRAY_OK);
    for (int c = 0; c < 4; c++)
        memcpy(fewray_frame_add(frame, names[c]), rgba[c], sizeof(rgba[c]));
    assert_int_equal(fewray_frame_write_exr(frame, scratch_path("color a.exr"), true, NULL),
                     FEWRAY_OK);
    fewray_frame_destroy(&frame);
}

#endif
