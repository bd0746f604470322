/* SPDX-License-Identifier: Apache-2.0 */
/* Channel names of other renderers become ours. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "pipeline/layer_names.h"

static struct fewray_frame *frame_of(const char *const *names) {
    struct fewray_frame *frame = NULL;
    assert_int_equal(fewray_frame_create(2, 1, &frame, NULL), 0);
    for (; *names; names++)
        assert_non_null(fewray_frame_add(frame, *names));
    return frame;
}

static bool has(const struct fewray_frame *frame, enum fewray_layer layer) {
    float *planes[3];
    return fewray_frame_layer(frame, layer, planes);
}

static const char *const MITSUBA[] = {"R",    "G",    "B",    "alb.R",  "alb.G", "alb.B",
                                      "nn.X", "nn.Y", "nn.Z", "dd.y.T", NULL};
static const char *const BLENDER[] = {"ViewLayer.Combined.R",
                                      "ViewLayer.Combined.G",
                                      "ViewLayer.Combined.B",
                                      "ViewLayer.Combined.A",
                                      "ViewLayer.Denoising Albedo.R",
                                      "ViewLayer.Denoising Albedo.G",
                                      "ViewLayer.Denoising Albedo.B",
                                      "ViewLayer.Denoising Normal.X",
                                      "ViewLayer.Denoising Normal.Y",
                                      "ViewLayer.Denoising Normal.Z",
                                      "ViewLayer.Depth.Z",
                                      "ViewLayer.DiffCol.R",
                                      "ViewLayer.DiffCol.G",
                                      "ViewLayer.DiffCol.B",
                                      NULL};

static void test_mitsuba_names_are_found(void **state) {
    (void)state;
    struct fewray_frame *frame = frame_of(MITSUBA);
    adopt_layer_names(frame, NAMING_AUTO);
    assert_true(has(frame, FEWRAY_COLOR) && has(frame, FEWRAY_ALBEDO) &&
                has(frame, FEWRAY_NORMAL) && has(frame, FEWRAY_DEPTH));
    fewray_frame_destroy(&frame);
}

static void test_blender_names_are_found_and_misses_mended(void **state) {
    (void)state;
    struct fewray_frame *frame = frame_of(BLENDER);
    float *depth = fewray_frame_plane(frame, "ViewLayer.Depth.Z");
    depth[0] = 1e10f;
    depth[1] = 3;
    adopt_layer_names(frame, NAMING_BLENDER);
    assert_true(has(frame, FEWRAY_COLOR) && has(frame, FEWRAY_ALBEDO) && has(frame, FEWRAY_NORMAL));
    assert_ptr_equal(fewray_frame_plane(frame, "depth.Z"), depth);
    assert_true(depth[0] == 0 && depth[1] == 3);
    assert_non_null(fewray_frame_plane(frame, "ViewLayer.DiffCol.R")); /* not needed: left alone */
    fewray_frame_destroy(&frame);
}

static void test_only_the_asked_names_are_adopted(void **state) {
    (void)state;
    struct fewray_frame *frame = frame_of(BLENDER);
    adopt_layer_names(frame, NAMING_MITSUBA);
    assert_false(has(frame, FEWRAY_COLOR));
    fewray_frame_destroy(&frame);
}

static void test_own_names_stay(void **state) {
    (void)state;
    static const char *const names[] = {"R",        "G",     "B",     "albedo.R", "albedo.G",
                                        "albedo.B", "alb.R", "alb.G", "alb.B",    NULL};
    struct fewray_frame *frame = frame_of(names);
    const float *albedo = fewray_frame_plane(frame, "albedo.G");
    adopt_layer_names(frame, NAMING_AUTO);
    assert_ptr_equal(fewray_frame_plane(frame, "albedo.G"), albedo);
    assert_non_null(fewray_frame_plane(frame, "alb.G"));
    fewray_frame_destroy(&frame);
}

static void test_what_means_two_things_must_be_asked_for(void **state) {
    (void)state;
    static const char *const names[] = {"R", "G", "B", "diffuse.R", "diffuse.G", "diffuse.B", NULL};
    struct fewray_frame *frame = frame_of(names);
    adopt_layer_names(frame, NAMING_AUTO);
    assert_false(has(frame, FEWRAY_ALBEDO)); /* Arnold's is light */
    adopt_layer_names(frame, NAMING_VRAY);
    assert_true(has(frame, FEWRAY_ALBEDO));
    fewray_frame_destroy(&frame);
}

static void test_a_background_counts_where_the_picture_holds_it(void **state) {
    (void)state;
    static const char *const names[] = {
        "V.Combined.R", "V.Combined.G", "V.Combined.B", "V.Emit.R", "V.Emit.G",
        "V.Emit.B",     "V.Env.R",      "V.Env.G",      "V.Env.B",  NULL};
    for (int transparent = 0; transparent < 2; transparent++) {
        struct fewray_frame *frame = frame_of(names);
        struct adoption adoption;
        for (int c = 0; c < 3; c++) {
            frame->planes[c].data[0] = 4;
            frame->planes[c].data[1] = transparent ? 0 : 2;
            frame->planes[3 + c].data[0] = 3;
            frame->planes[6 + c].data[1] = 2;
        }
        adopt_layers(frame, NAMING_AUTO, true, &adoption);
        const float *emission = fewray_frame_plane(frame, "emission.G");
        assert_true(emission[0] == 3 && emission[1] == (transparent ? 0 : 2));
        assert_string_equal(adoption.added, transparent ? "" : "V.Env.R");
        fewray_frame_destroy(&frame);
    }
}

static void test_the_result_replaces_what_blender_denoised(void **state) {
    (void)state;
    static const char *const names[] = {
        "V.Combined.R",    "V.Combined.G",    "V.Combined.B",    "V.Combined.A",
        "V.Noisy Image.R", "V.Noisy Image.G", "V.Noisy Image.B", NULL};
    struct fewray_frame *frame = frame_of(names);
    struct adoption adoption;
    adopt_layers(frame, NAMING_AUTO, true, &adoption);
    assert_string_equal(adoption.layers[FEWRAY_COLOR].names[1], "V.Noisy Image.G");
    assert_string_equal(adopted_name(&adoption, "G"), "V.Combined.G");
    assert_string_equal(adopted_name(&adoption, "A"), "V.Combined.A");
    assert_string_equal(adopted_name(&adoption, "V.AO.R"), "V.AO.R");
    fewray_frame_destroy(&frame);
    frame = frame_of(names);
    adopt_layers(frame, NAMING_AUTO, false, &adoption); /* to look at */
    assert_string_equal(adoption.layers[FEWRAY_COLOR].names[1], "V.Combined.G");
    fewray_frame_destroy(&frame);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mitsuba_names_are_found),
        cmocka_unit_test(test_blender_names_are_found_and_misses_mended),
        cmocka_unit_test(test_only_the_asked_names_are_adopted),
        cmocka_unit_test(test_own_names_stay),
        cmocka_unit_test(test_what_means_two_things_must_be_asked_for),
        cmocka_unit_test(test_a_background_counts_where_the_picture_holds_it),
        cmocka_unit_test(test_the_result_replaces_what_blender_denoised),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
