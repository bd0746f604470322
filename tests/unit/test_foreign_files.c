/* SPDX-License-Identifier: Apache-2.0 */
/* EXRs with the parts and channel names of other renderers, half and float, with and without
 * albedo, normals and variance: the layers are found, and denoised by. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include <cmocka.h>

#include "fewray/denoise.h"
#include "picture_files.h"
#include "pipeline/layer_names.h"

enum { WIDTH = 37, HEIGHT = 21, COUNT = WIDTH * HEIGHT, PARTS = 6, WANTED = 6 };

/* A layer that is to be found: channel 0 of it is this channel of this part, times scale. */
struct wanted {
    enum fewray_layer layer;
    int part, channel;
    float scale;
};

struct foreign {
    const char *what;
    int spp;
    struct picture_part parts[PARTS]; /* up to the first without channels */
    struct wanted wanted[WANTED];     /* up to the first with scale 0; no other layers */
};

static const struct foreign FILES[] = {
    {"Mitsuba, all AOVs",
     0,
     {{NULL, "R,G,B,image.R,image.G,image.B,image.A,albedo.R,albedo.G,albedo.B,nn.X,nn.Y,nn.Z,dd.T,"
             "uv.U,uv.V"}},
     {{FEWRAY_COLOR, 0, 0, 1},
      {FEWRAY_ALBEDO, 0, 7, 1},
      {FEWRAY_NORMAL, 0, 10, 1},
      {FEWRAY_DEPTH, 0, 13, 1}}},
    {"Mitsuba, AOVs by their types' names",
     0,
     {{NULL, "R,G,B,A,albedo.R,albedo.G,albedo.B,sh_normal.X,sh_normal.Y,sh_normal.Z,depth.T"}},
     {{FEWRAY_COLOR, 0, 0, 1},
      {FEWRAY_ALBEDO, 0, 4, 1},
      {FEWRAY_NORMAL, 0, 7, 1},
      {FEWRAY_DEPTH, 0, 10, 1}}},
    {"Mitsuba, geometric normals alone",
     0,
     {{NULL, "R,G,B,geo_normal.X,geo_normal.Y,geo_normal.Z"}},
     {{FEWRAY_COLOR, 0, 0, 1}, {FEWRAY_NORMAL, 0, 3, 1}}},
    {"Mitsuba, AOVs inside the moment integrator",
     0,
     {{NULL, "R,G,B,a.X,a.Y,a.Z,a.albedo.R,a.albedo.G,a.albedo.B,a.nn.X,a.nn.Y,a.nn.Z,"
             "m2_a.albedo.R,m2_a.albedo.G,m2_a.albedo.B,m2_a.nn.X,m2_a.nn.Y,m2_a.nn.Z"}},
     {{FEWRAY_COLOR, 0, 0, 1}, {FEWRAY_ALBEDO, 0, 6, 1}, {FEWRAY_NORMAL, 0, 9, 1}}},
    {"Mitsuba, no AOVs", 0, {{NULL, "R,G,B"}}, {{FEWRAY_COLOR, 0, 0, 1}}},
    {"Blender, one part",
     0,
     {{NULL, "ViewLayer.Combined.R,ViewLayer.Combined.G,ViewLayer.Combined.B,ViewLayer.Combined.A,"
             "ViewLayer.Denoising Albedo.R,ViewLayer.Denoising Albedo.G,ViewLayer.Denoising "
             "Albedo.B,ViewLayer.Denoising Normal.X,ViewLayer.Denoising Normal.Y,"
             "ViewLayer.Denoising Normal.Z,ViewLayer.Denoising Depth.Z,ViewLayer.Depth.Z"}},
     {{FEWRAY_COLOR, 0, 0, 1},
      {FEWRAY_ALBEDO, 0, 4, 1},
      {FEWRAY_NORMAL, 0, 7, 1},
      {FEWRAY_DEPTH, 0, 10, 1}}},
    {"Blender, RenderLayer, noisy image kept, colour passes",
     0,
     {{NULL, "RenderLayer.Combined.R,RenderLayer.Combined.G,RenderLayer.Combined.B,"
             "RenderLayer.Noisy Image.R,RenderLayer.Noisy Image.G,RenderLayer.Noisy Image.B,"
             "RenderLayer.DiffCol.R,RenderLayer.DiffCol.G,RenderLayer.DiffCol.B,"
             "RenderLayer.Normal.X,RenderLayer.Normal.Y,RenderLayer.Normal.Z,RenderLayer.Depth.V"}},
     {{FEWRAY_COLOR, 0, 3, 1},
      {FEWRAY_ALBEDO, 0, 6, 1},
      {FEWRAY_NORMAL, 0, 9, 1},
      {FEWRAY_DEPTH, 0, 12, 1}}},
    {"Blender, two view layers",
     0,
     {{NULL, "Back.Combined.R,Back.Combined.G,Back.Combined.B,Front.Combined.R,Front.Combined.G,"
             "Front.Combined.B,Back.Emit.R,Back.Emit.G,Back.Emit.B"}},
     {{FEWRAY_COLOR, 0, 0, 1}, {FEWRAY_EMISSION, 0, 6, 1}}},
    {"Blender, a part for each pass, whole channel names",
     0,
     {{"ViewLayer.AO", "ViewLayer.AO.R,ViewLayer.AO.G,ViewLayer.AO.B"},
      {"ViewLayer.Combined", "ViewLayer.Combined.R,ViewLayer.Combined.G,ViewLayer.Combined.B"},
      {"ViewLayer.Denoising Albedo", "ViewLayer.Denoising Albedo.R,ViewLayer.Denoising Albedo.G,"
                                     "ViewLayer.Denoising Albedo.B"},
      {"ViewLayer.Depth", "ViewLayer.Depth.Z"}},
     {{FEWRAY_COLOR, 1, 0, 1}, {FEWRAY_ALBEDO, 2, 0, 1}, {FEWRAY_DEPTH, 3, 0, 1}}},
    {"Blender, a part for each pass, bare channel names",
     0,
     {{"ViewLayer.AO", "R,G,B"},
      {"ViewLayer.Combined", "R,G,B,A"},
      {"ViewLayer.Denoising Albedo", "R,G,B"},
      {"ViewLayer.Denoising Normal", "X,Y,Z"},
      {"ViewLayer.Depth", "Z"}},
     {{FEWRAY_COLOR, 1, 0, 1},
      {FEWRAY_ALBEDO, 2, 0, 1},
      {FEWRAY_NORMAL, 3, 0, 1},
      {FEWRAY_DEPTH, 4, 0, 1}}},
    {"Blender, a picture with Z",
     0,
     {{NULL, "R,G,B,A,Z"}},
     {{FEWRAY_COLOR, 0, 0, 1}, {FEWRAY_DEPTH, 0, 4, 1}}},
    {"parts of a compositing program",
     0,
     {{"rgba", "R,G,B,A"}, {"albedo", "R,G,B"}, {"normal", "X,Y,Z"}, {"depth", "Z"}},
     {{FEWRAY_COLOR, 0, 0, 1},
      {FEWRAY_ALBEDO, 1, 0, 1},
      {FEWRAY_NORMAL, 2, 0, 1},
      {FEWRAY_DEPTH, 3, 0, 1}}},
    {"pbrt, GBufferFilm",
     16,
     {{NULL, "R,G,B,Albedo.R,Albedo.G,Albedo.B,P.X,P.Y,P.Z,dzdx,dzdy,N.X,N.Y,N.Z,Ns.X,Ns.Y,Ns.Z,u,"
             "v,Variance.R,Variance.G,Variance.B,RelativeVariance.R,RelativeVariance.G,"
             "RelativeVariance.B"}},
     {{FEWRAY_COLOR, 0, 0, 1},
      {FEWRAY_ALBEDO, 0, 3, 1},
      {FEWRAY_NORMAL, 0, 14, 1},
      {FEWRAY_VARIANCE, 0, 19, 1.0f / 16},
      {FEWRAY_DEPTH, -1, 0, 1}}},
    {"pbrt, GBufferFilm's old names, unknown samples",
     0,
     {{NULL, "R,G,B,Albedo.R,Albedo.G,Albedo.B,Nx,Ny,Nz,Nsx,Nsy,Nsz,Variance.R,Variance.G,"
             "Variance.B"}},
     {{FEWRAY_COLOR, 0, 0, 1}, {FEWRAY_ALBEDO, 0, 3, 1}, {FEWRAY_NORMAL, 0, 9, 1}}},
    {"Arnold",
     0,
     {{NULL, "R,G,B,A,Z,N.X,N.Y,N.Z,denoise_albedo.R,denoise_albedo.G,denoise_albedo.B,diffuse.R,"
             "diffuse.G,diffuse.B,specular.R,specular.G,specular.B,motionvector.X,motionvector.Y,"
             "RGBA_variance.R,RGBA_variance.G,RGBA_variance.B"}},
     {{FEWRAY_COLOR, 0, 0, 1},
      {FEWRAY_DEPTH, 0, 4, 1},
      {FEWRAY_NORMAL, 0, 5, 1},
      {FEWRAY_ALBEDO, 0, 8, 1},
      {FEWRAY_VARIANCE, 0, 19, 1}}},
    {"Arnold, the beauty by its AOV's name, a background that it doesn't hold",
     0,
     {{NULL, "RGBA.R,RGBA.G,RGBA.B,RGBA.A,N.R,N.G,N.B,background.R,background.G,background.B"}},
     {{FEWRAY_COLOR, 0, 0, 1}, {FEWRAY_NORMAL, 0, 4, 1}}},
    {"RenderMan, for its denoiser",
     0,
     {{NULL, "Ci.r,Ci.g,Ci.b,a,mse.r,mse.g,mse.b,albedo.r,albedo.g,albedo.b,albedo_var.r,"
             "albedo_var.g,albedo_var.b,normal.x,normal.y,normal.z,normal_var.x,normal_var.y,"
             "normal_var.z,zfiltered,zfiltered_var,sampleCount,diffuse.r,diffuse.g,diffuse.b"}},
     {{FEWRAY_COLOR, 0, 0, 1},
      {FEWRAY_VARIANCE, 0, 4, 1},
      {FEWRAY_ALBEDO, 0, 7, 1},
      {FEWRAY_NORMAL, 0, 13, 1},
      {FEWRAY_DEPTH, 0, 19, 1}}},
    {"V-Ray for 3ds Max",
     0,
     {{NULL,
       "R,G,B,A,Z,VRayDiffuseFilter.R,VRayDiffuseFilter.G,VRayDiffuseFilter.B,"
       "VRayBumpNormals.X,VRayBumpNormals.Y,VRayBumpNormals.Z,VRaySelfIllumination.R,"
       "VRaySelfIllumination.G,VRaySelfIllumination.B,VRayZDepth.R,VRayZDepth.G,VRayZDepth.B"}},
     {{FEWRAY_COLOR, 0, 0, 1},
      {FEWRAY_DEPTH, 0, 4, 1},
      {FEWRAY_ALBEDO, 0, 5, 1},
      {FEWRAY_NORMAL, 0, 8, 1},
      {FEWRAY_EMISSION, 0, 11, 1}}},
    {"V-Ray for Maya",
     0,
     {{NULL, "R,G,B,A,diffuse.red,diffuse.green,diffuse.blue,bump_normals.X,bump_normals.Y,"
             "bump_normals.Z,self_illumination.red,self_illumination.green,self_illumination.blue,"
             "gi.red,gi.green,gi.blue,lighting.red,lighting.green,lighting.blue"}},
     {{FEWRAY_COLOR, 0, 0, 1},
      {FEWRAY_ALBEDO, 0, 4, 1},
      {FEWRAY_NORMAL, 0, 7, 1},
      {FEWRAY_EMISSION, 0, 10, 1}}},
    {"Karma",
     0,
     {{"C", "R,G,B,A"}, {"albedo", "R,G,B"}, {"N", "X,Y,Z"}, {"hitPz", "Y"}},
     {{FEWRAY_COLOR, 0, 0, 1}, {FEWRAY_ALBEDO, 1, 0, 1}, {FEWRAY_NORMAL, 2, 0, 1}}},
    {"pbrt, RGBFilm", 16, {{NULL, "R,G,B"}}, {{FEWRAY_COLOR, 0, 0, 1}}},
};

static char path[256];

static struct fewray_frame *read_foreign(const struct foreign *file, bool half) {
    int parts = 0;
    while (parts < PARTS && file->parts[parts].channels)
        parts++;
    assert_true(picture_write(path, WIDTH, HEIGHT, half, file->spp, file->parts, parts));
    struct fewray_frame *frame = NULL;
    struct fewray_error error;
    if (read_noisy_picture(path, NAMING_AUTO, NULL, &frame, &error))
        fail_msg("%s: %s", file->what, error.what);
    return frame;
}

static const struct wanted *find_wanted(const struct foreign *file, enum fewray_layer layer) {
    for (int i = 0; i < WANTED && file->wanted[i].scale > 0; i++)
        if (file->wanted[i].layer == layer)
            return &file->wanted[i];
    return NULL;
}

static void check_layer(const struct foreign *file, const struct fewray_frame *frame,
                        enum fewray_layer layer) {
    const struct wanted *wanted = find_wanted(file, layer);
    float *planes[3];
    if (fewray_frame_layer(frame, layer, planes) != (wanted != NULL))
        fail_msg("%s: layer %d is %s", file->what, layer, wanted ? "missing" : "there");
    for (int c = 0; wanted && wanted->part >= 0 && c < 3 && planes[c]; c++)
        for (int i = 0; i < COUNT; i++) {
            const float value = picture_value(wanted->part, wanted->channel + c, i) * wanted->scale;
            if (planes[c][i] != value)
                fail_msg("%s: layer %d, channel %d, pixel %d is %g, not %g", file->what, layer, c,
                         i, planes[c][i], value);
        }
}

static void test_layers_are_found(void **state) {
    (void)state;
    for (size_t f = 0; f < sizeof FILES / sizeof *FILES; f++)
        for (int half = 0; half < 2; half++) {
            struct fewray_frame *frame = read_foreign(&FILES[f], half);
            for (int layer = 0; layer < FEWRAY_LAYER_COUNT; layer++)
                check_layer(&FILES[f], frame, (enum fewray_layer)layer);
            fewray_frame_destroy(&frame);
        }
}

static void test_depth_is_the_length_of_a_place(void **state) {
    (void)state;
    static const struct foreign file = {"places", 0, {{NULL, "R,G,B,P.X,P.Y,P.Z"}}, {{0}}};
    struct fewray_frame *frame = read_foreign(&file, false);
    const float *depth = fewray_frame_plane(frame, "depth.Z");
    assert_non_null(depth);
    for (int i = 0; i < COUNT; i++) {
        const float x = picture_value(0, 3, i), y = picture_value(0, 4, i),
                    z = picture_value(0, 5, i);
        assert_float_equal(depth[i], sqrtf(x * x + y * y + z * z), 1e-6f);
    }
    fewray_frame_destroy(&frame);
}

static void test_misses_are_depth_0(void **state) {
    (void)state;
    static const float misses[] = {1e10f, 1e30f, 3.4e38f, INFINITY};
    for (int k = 0; k < 4; k++) {
        struct fewray_frame *frame = NULL;
        assert_int_equal(fewray_frame_create(2, 1, &frame, NULL), FEWRAY_OK);
        float *depth = fewray_frame_add(frame, "Z");
        depth[0] = misses[k];
        depth[1] = 7;
        adopt_layer_names(frame, NAMING_AUTO);
        assert_ptr_equal(fewray_frame_plane(frame, "depth.Z"), depth);
        assert_true(depth[0] == 0 && depth[1] == 7);
        fewray_frame_destroy(&frame);
    }
}

static void test_they_are_denoised(void **state) {
    (void)state;
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    fewray_denoise_options_init(&options);
    options.threads = 1;
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, NULL), FEWRAY_OK);
    for (size_t f = 0; f < sizeof FILES / sizeof *FILES; f++) {
        struct fewray_frame *frame = read_foreign(&FILES[f], f & 1);
        fewray_frame_repair(frame);
        assert_int_equal(fewray_denoise_frame(denoiser, frame, NULL, NULL), FEWRAY_OK);
        float *color[3], *noisy[3];
        assert_true(fewray_frame_layer(frame, FEWRAY_COLOR, color));
        assert_true(fewray_frame_layer(frame, FEWRAY_NOISY, noisy));
        int changed = 0;
        for (int i = 0; i < COUNT; i++) {
            assert_true(isfinite(color[1][i]) && color[1][i] >= 0);
            changed += color[1][i] != noisy[1][i];
        }
        assert_true(changed > COUNT / 2);
        fewray_frame_destroy(&frame);
    }
    fewray_denoiser_destroy(&denoiser);
}

static void test_a_file_of_features_alone_is_refused(void **state) {
    (void)state;
    static const struct picture_part parts[] = {{"albedo", "R,G,B"}, {"normal", "X,Y,Z"}};
    struct fewray_frame *frame = NULL;
    assert_true(picture_write(path, WIDTH, HEIGHT, true, 0, parts, 2));
    assert_int_equal(read_picture(path, NAMING_AUTO, &frame, NULL), FEWRAY_ERROR_UNSUPPORTED);
    assert_null(frame);
}

static int name_file(void **state) {
    (void)state;
    const char *parent = getenv("TMPDIR");
    snprintf(path, sizeof path, "%.200s/fewray-foreign-%ld.exr", parent ? parent : "/tmp",
             (long)getpid());
    return 0;
}

static int remove_file(void **state) {
    (void)state;
    return unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_layers_are_found),
        cmocka_unit_test(test_depth_is_the_length_of_a_place),
        cmocka_unit_test(test_misses_are_depth_0),
        cmocka_unit_test(test_they_are_denoised),
        cmocka_unit_test(test_a_file_of_features_alone_is_refused),
    };
    return cmocka_run_group_tests(tests, name_file, remove_file);
}
