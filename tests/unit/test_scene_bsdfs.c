/* SPDX-License-Identifier: Apache-2.0 */
/* BSDFs arrive with Mitsuba's parameters and defaults. The numbers were read from Mitsuba 3.9.1,
 * scalar_rgb. */

#include "scene_scratch.h"

/* A cube of the BSDF. */
static struct fewray_scene *load_bsdf(const char *bsdf) {
    char body[4096];
    snprintf(body, sizeof(body), "<shape type='cube'>%s</shape>", bsdf);
    return scratch_scene(body);
}

static const struct bsdf *bsdf_of(const struct fewray_scene *scene, int mesh) {
    return &scene->bsdfs[scene->meshes[mesh].bsdf];
}

static const struct bsdf *nested_of(const struct fewray_scene *scene, int i) {
    int nested = bsdf_of(scene, 0)->nested[i];
    assert_true(nested >= 0);
    return &scene->bsdfs[nested];
}

static struct vec3 color_of(const struct fewray_scene *scene, int texture) {
    assert_true(texture >= 0 && texture < scene->texture_count);
    assert_int_equal(scene->textures[texture].kind, TEXTURE_CONSTANT);
    return scene->textures[texture].color0;
}

static void expect_color(const struct fewray_scene *scene, int texture, float r, float g, float b) {
    struct vec3 color = color_of(scene, texture);
    assert_near(color.x, r, 1e-6);
    assert_near(color.y, g, 1e-6);
    assert_near(color.z, b, 1e-6);
}

static void expect_grey(const struct fewray_scene *scene, int texture, float value) {
    expect_color(scene, texture, value, value, value);
}

static void expect_vector(struct vec3 v, float x, float y, float z, float tolerance) {
    assert_near(v.x, x, tolerance);
    assert_near(v.y, y, tolerance);
    assert_near(v.z, z, tolerance);
}

static void test_plastics(void **state) {
    static const char *const types[] = {"plastic", "roughplastic"};
    (void)state;
    for (int i = 0; i < 2; i++) {
        char text[512];
        snprintf(text, sizeof(text), "<bsdf type='%s'/>", types[i]);
        struct fewray_scene *scene = load_bsdf(text);
        const struct bsdf *bsdf = bsdf_of(scene, 0);
        assert_int_equal(bsdf->kind, i ? BSDF_ROUGH_PLASTIC : BSDF_PLASTIC);
        assert_near(bsdf->eta, 1.4895873, 1e-6);
        expect_grey(scene, bsdf->reflectance, 0.5f);
        expect_grey(scene, bsdf->specular_reflectance, 1);
        assert_false(bsdf->nonlinear || bsdf->tangents);
        if (i)
            expect_grey(scene, bsdf->alpha_u, 0.1f);
        assert_int_equal(bsdf->microfacets, MICROFACET_BECKMANN);
        fewray_scene_destroy(&scene);
    }
    struct fewray_scene *scene = load_bsdf(
        "<bsdf type='roughplastic'><float name='int_ior' value='1.5'/><float name='ext_ior' "
        "value='1'/><string name='distribution' value='ggx'/><float name='alpha' value='0.25'/>"
        "<boolean name='nonlinear' value='true'/><rgb name='diffuse_reflectance' value='.1 .2 .3'/>"
        "<float name='specular_reflectance' value='.75'/><boolean name='sample_visible' "
        "value='false'/></bsdf>");
    const struct bsdf *bsdf = bsdf_of(scene, 0);
    assert_near(bsdf->eta, 1.5, 1e-6);
    assert_int_equal(bsdf->microfacets, MICROFACET_GGX);
    assert_true(bsdf->nonlinear);
    expect_grey(scene, bsdf->alpha_u, 0.25f);
    expect_grey(scene, bsdf->alpha_v, 0.25f);
    expect_color(scene, bsdf->reflectance, 0.1f, 0.2f, 0.3f);
    expect_grey(scene, bsdf->specular_reflectance, 0.75f);
    assert_int_equal(scene->warning_count, 0);
    fewray_scene_destroy(&scene);
}

static void test_metals_by_name(void **state) {
    static const struct {
        const char *name;
        struct vec3 eta, k;
    } metals[] = {
        {"Au", {0.143036f, 0.375307f, 1.44205f}, {3.983f, 2.38556f, 1.60336f}},
        {"Cu", {0.201005f, 0.92375f, 1.10222f}, {3.91326f, 2.45305f, 2.14209f}},
        {"Al", {1.6575f, 0.880405f, 0.521244f}, {9.22381f, 6.2695f, 4.837f}},
        {"Ag", {0.155276f, 0.116728f, 0.138388f}, {4.82835f, 3.12222f, 2.1469f}},
        {"Cr", {4.36967f, 2.91651f, 1.6549f}, {5.20655f, 4.23131f, 3.7547f}},
        {"W", {4.37082f, 3.30025f, 2.99841f}, {3.50064f, 2.60487f, 2.27323f}},
        {"a-C", {2.94405f, 2.22714f, 1.96816f}, {0.887465f, 0.799299f, 0.81529f}},
        {"TiN_palik", {1.64845f, 1.15052f, 1.37982f}, {3.36833f, 1.9435f, 1.10207f}},
        {"AlSb", {0, 4.13937f, 4.66925f}, {0, 0.0940091f, 1.30057f}},
        {"none", {0, 0, 0}, {1, 1, 1}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof(metals) / sizeof(*metals); i++) {
        char text[256];
        struct vec3 eta = metals[i].eta, k = metals[i].k;
        snprintf(text, sizeof(text),
                 "<bsdf type='conductor'><string name='material' value='%s'/></bsdf>",
                 metals[i].name);
        struct fewray_scene *scene = load_bsdf(text);
        expect_vector(bsdf_of(scene, 0)->conductor_eta, eta.x, eta.y, eta.z, 1e-5f);
        expect_vector(bsdf_of(scene, 0)->conductor_k, k.x, k.y, k.z, 1e-5f);
        fewray_scene_destroy(&scene);
    }
}

static void test_conductors(void **state) {
    struct fewray_scene *scene = load_bsdf("<bsdf type='roughconductor'/>");
    const struct bsdf *bsdf = bsdf_of(scene, 0);
    (void)state;
    assert_int_equal(bsdf->kind, BSDF_ROUGH_CONDUCTOR);
    expect_vector(bsdf->conductor_eta, 0, 0, 0, 0);
    expect_vector(bsdf->conductor_k, 1, 1, 1, 0);
    expect_grey(scene, bsdf->alpha_u, 0.1f);
    expect_grey(scene, bsdf->specular_reflectance, 1);
    assert_int_equal(bsdf->microfacets, MICROFACET_BECKMANN);
    assert_false(bsdf->tangents);
    fewray_scene_destroy(&scene);

    /* Out of the gamut: only squares count. */
    scene = load_bsdf("<bsdf type='roughconductor'><rgb name='eta' value='-0.05 4 5'/>"
                      "<spectrum name='k' value='400:1,700:3'/><float name='alpha_u' value='0.1'/>"
                      "<float name='alpha_v' value='0.3'/><string name='distribution' value='GGX'/>"
                      "</bsdf>");
    bsdf = bsdf_of(scene, 0);
    expect_vector(bsdf->conductor_eta, 0.05f, 4, 5, 1e-6f);
    expect_vector(bsdf->conductor_k, 2.60364f, 1.95267f, 1.26699f, 2e-5f);
    expect_grey(scene, bsdf->alpha_v, 0.3f);
    assert_true(bsdf->tangents);
    assert_int_equal(bsdf->microfacets, MICROFACET_GGX);
    fewray_scene_destroy(&scene);
}

static void test_dielectrics(void **state) {
    static const struct {
        const char *type;
        enum bsdf_kind kind;
    } kinds[] = {{"dielectric", BSDF_DIELECTRIC},
                 {"thindielectric", BSDF_THIN_DIELECTRIC},
                 {"roughdielectric", BSDF_ROUGH_DIELECTRIC}};
    (void)state;
    for (int i = 0; i < 3; i++) {
        char text[512];
        snprintf(text, sizeof(text), "<bsdf type='%s'/>", kinds[i].type);
        struct fewray_scene *scene = load_bsdf(text);
        const struct bsdf *bsdf = bsdf_of(scene, 0);
        assert_int_equal(bsdf->kind, kinds[i].kind);
        assert_near(bsdf->eta, 1.5041833, 1e-6);
        expect_grey(scene, bsdf->specular_reflectance, 1);
        expect_grey(scene, bsdf->specular_transmittance, 1);
        if (i == 2)
            expect_grey(scene, bsdf->alpha_u, 0.1f);
        fewray_scene_destroy(&scene);
    }
    struct fewray_scene *scene =
        load_bsdf("<bsdf type='dielectric'><string name='int_ior' value='Water Ice'/></bsdf>");
    assert_near(bsdf_of(scene, 0)->eta, 1.3096371, 1e-6);
    fewray_scene_destroy(&scene);
    scene = load_bsdf("<bsdf type='dielectric'><string name='int_ior' value='air'/>"
                      "<string name='ext_ior' value='diamond'/></bsdf>");
    assert_near(bsdf_of(scene, 0)->eta, 1.000277 / 2.419, 1e-6);
    fewray_scene_destroy(&scene);
}

static void test_principled(void **state) {
    struct fewray_scene *scene = load_bsdf("<bsdf type='principled'/>");
    const struct bsdf *bsdf = bsdf_of(scene, 0);
    (void)state;
    assert_int_equal(bsdf->kind, BSDF_PRINCIPLED);
    expect_grey(scene, bsdf->reflectance, 0.5f);
    assert_near(bsdf->eta, 1.5, 1e-6);
    assert_false(bsdf->tangents);
    for (int i = 0; i < PRINCIPLED_COUNT; i++)
        if (i == PRINCIPLED_ROUGHNESS)
            expect_grey(scene, bsdf->principled[i], 0.5f);
        else
            assert_int_equal(bsdf->principled[i], -1);
    fewray_scene_destroy(&scene);

    scene = load_bsdf(
        "<bsdf type='principled'><float name='metallic' value='0.1'/><float name='roughness' "
        "value='0.2'/><float name='anisotropic' value='0.3'/><float name='spec_trans' value='0.4'/>"
        "<float name='spec_tint' value='0.5'/><float name='sheen' value='0.6'/><float "
        "name='sheen_tint' value='0.7'/><float name='clearcoat' value='0.8'/><float "
        "name='clearcoat_gloss' value='0.9'/><float name='flatness' value='1'/><float "
        "name='specular' value='0.8'/><float name='clearcoat_sampling_rate' value='2'/></bsdf>");
    bsdf = bsdf_of(scene, 0);
    for (int i = 0; i < PRINCIPLED_COUNT; i++)
        expect_grey(scene, bsdf->principled[i], (float)(i + 1) / 10);
    assert_near(bsdf->eta, 1.6773124, 1e-6);
    assert_true(bsdf->tangents);
    assert_int_equal(scene->warning_count, 0);
    fewray_scene_destroy(&scene);

    scene = load_bsdf("<bsdf type='principled'><float name='eta' value='1'/><float "
                      "name='spec_trans' value='1'/><float name='sheen' value='0'/></bsdf>");
    assert_near(bsdf_of(scene, 0)->eta, 1.001, 1e-6);
    assert_int_equal(bsdf_of(scene, 0)->principled[PRINCIPLED_SHEEN], -1);
    fewray_scene_destroy(&scene);
}

#define DIFFUSE      "<bsdf type='diffuse'/>"
#define CHECKS(name) "<texture type='checkerboard' name='" name "'/>"

static void test_masks_and_blends(void **state) {
    struct fewray_scene *scene =
        load_bsdf("<bsdf type='mask'><bsdf type='twosided'>" DIFFUSE "</bsdf></bsdf>");
    (void)state;
    assert_int_equal(bsdf_of(scene, 0)->kind, BSDF_MASK);
    expect_grey(scene, bsdf_of(scene, 0)->weight, 0.5f);
    assert_int_equal(nested_of(scene, 0)->kind, BSDF_TWOSIDED);
    assert_int_equal(nested_of(scene, 1)->kind, BSDF_NULL);
    fewray_scene_destroy(&scene);

    scene = load_bsdf("<bsdf type='mask'>" DIFFUSE CHECKS("opacity") "</bsdf>");
    assert_int_equal(scene->textures[bsdf_of(scene, 0)->weight].kind, TEXTURE_CHECKERBOARD);
    fewray_scene_destroy(&scene);

    scene = load_bsdf("<bsdf type='blendbsdf'>" DIFFUSE "<bsdf type='conductor'/>"
                      "<float name='weight' value='0.25'/></bsdf>");
    assert_int_equal(bsdf_of(scene, 0)->kind, BSDF_BLEND);
    expect_grey(scene, bsdf_of(scene, 0)->weight, 0.25f);
    assert_int_equal(nested_of(scene, 0)->kind, BSDF_DIFFUSE);
    assert_int_equal(nested_of(scene, 1)->kind, BSDF_CONDUCTOR);
    fewray_scene_destroy(&scene);

    scene =
        load_bsdf("<bsdf type='twosided'><bsdf type='plastic'/><bsdf type='conductor'/></bsdf>");
    assert_int_equal(nested_of(scene, 0)->kind, BSDF_PLASTIC);
    assert_int_equal(nested_of(scene, 1)->kind, BSDF_CONDUCTOR);
    assert_false(bsdf_of(scene, 0)->tangents);
    fewray_scene_destroy(&scene);
}

static void test_bump_and_normal_maps_need_tangents(void **state) {
    struct fewray_scene *scene =
        load_bsdf("<bsdf type='twosided'><bsdf type='bumpmap'>" DIFFUSE CHECKS(
            "anything") "<float name='scale' value='3'/></bsdf></bsdf>");
    (void)state;
    assert_true(bsdf_of(scene, 0)->tangents);
    assert_int_equal(nested_of(scene, 0)->kind, BSDF_BUMP_MAP);
    assert_near(nested_of(scene, 0)->bump_scale, 3, 0);
    assert_true(nested_of(scene, 0)->weight >= 0);
    fewray_scene_destroy(&scene);

    scene = load_bsdf("<bsdf type='normalmap'><rgb name='normalmap' value='0.5 0.5 1'/>" DIFFUSE
                      "<boolean name='use_shadowing_function' value='true'/></bsdf>");
    assert_true(bsdf_of(scene, 0)->tangents);
    assert_int_equal(bsdf_of(scene, 0)->kind, BSDF_NORMAL_MAP);
    expect_color(scene, bsdf_of(scene, 0)->weight, 0.5f, 0.5f, 1);
    assert_int_equal(scene->warning_count, 0);
    fewray_scene_destroy(&scene);
}

/* An id deep inside another BSDF is as good as one at the top; equal constants share a texture. */
static void test_ids_anywhere(void **state) {
    struct fewray_scene *scene = scratch_scene(
        "<shape type='cube'><ref id='paint'/></shape>"
        "<shape type='cube'><bsdf type='twosided' id='wall'><bsdf type='plastic' id='paint'>"
        "<ref name='diffuse_reflectance' id='checks'/></bsdf></bsdf></shape>"
        "<shape type='cube'><bsdf type='diffuse'><texture type='checkerboard' name='reflectance' "
        "id='checks'/></bsdf></shape>"
        "<shape type='cube'><bsdf type='mask'><ref id='wall'/></bsdf></shape>"
        "<shape type='cube'><bsdf type='mask'><ref id='paint'/></bsdf></shape>");
    const struct bsdf *paint = bsdf_of(scene, 0);
    (void)state;
    assert_int_equal(bsdf_of(scene, 1)->nested[0], scene->meshes[0].bsdf);
    assert_int_equal(bsdf_of(scene, 2)->reflectance, paint->reflectance);
    assert_int_equal(bsdf_of(scene, 3)->nested[0], scene->meshes[1].bsdf);
    assert_int_equal(bsdf_of(scene, 3)->nested[1], bsdf_of(scene, 4)->nested[1]);
    assert_int_equal(scene->textures[paint->reflectance].kind, TEXTURE_CHECKERBOARD);
    assert_int_equal(scene->texture_count, 3); /* checks, white, the opacity */
    assert_int_equal(fewray_scene_summarize(scene).materials, 5);
    fewray_scene_destroy(&scene);
}

static void test_refusals(void **state) {
    static const struct {
        const char *bsdf, *what;
    } cases[] = {
        {"<bsdf type='conductor'><string name='material' value='Unobtainium'/></bsdf>",
         "'Unobtainium' is no metal"},
        {"<bsdf type='conductor'><string name='material' value='Au'/><rgb name='k' value='1'/>"
         "</bsdf>",
         "both a material and eta or k"},
        {"<bsdf type='conductor'>" CHECKS("eta") "</bsdf>", "eta: a texture is not supported"},
        {"<bsdf type='conductor'><rgb name='specular_reflectance' value='2'/></bsdf>", "0..1"},
        {"<bsdf type='dielectric'><string name='int_ior' value='jelly'/></bsdf>", "'jelly'"},
        {"<bsdf type='dielectric'><float name='int_ior' value='-1'/></bsdf>", "int_ior = -1"},
        {"<bsdf type='roughdielectric'><float name='int_ior' value='1'/><float name='ext_ior' "
         "value='1'/></bsdf>",
         "must differ"},
        {"<bsdf type='roughconductor'><float name='alpha_u' value='1'/></bsdf>",
         "both alpha_u and alpha_v"},
        {"<bsdf type='roughconductor'><float name='alpha' value='-1'/></bsdf>", "alpha = '-1'"},
        {"<bsdf type='roughconductor'><string name='distribution' value='phong'/></bsdf>",
         "distribution = 'phong'"},
        {"<bsdf type='roughplastic'>" CHECKS("alpha") "</bsdf>", "alpha should be a <float>"},
        {"<bsdf type='principled'><float name='eta' value='1.5'/><float name='specular' "
         "value='1'/></bsdf>",
         "both eta and specular"},
        {"<bsdf type='mask'/>", "mask has no BSDF inside"},
        {"<bsdf type='mask'>" DIFFUSE DIFFUSE "</bsdf>", "mask takes at most 1 BSDF inside"},
        {"<bsdf type='blendbsdf'>" DIFFUSE DIFFUSE "</bsdf>", "blendbsdf has no weight"},
        {"<bsdf type='blendbsdf'>" DIFFUSE "<float name='weight' value='1'/></bsdf>",
         "blendbsdf needs 2 BSDFs inside"},
        {"<bsdf type='bumpmap'>" DIFFUSE "</bsdf>", "bumpmap has no texture"},
        {"<bsdf type='bumpmap'>" DIFFUSE CHECKS("a") CHECKS("b") "</bsdf>", "only one texture"},
        {"<bsdf type='normalmap'>" DIFFUSE CHECKS("a") "</bsdf>", "no normalmap texture"},
        {"<bsdf type='twosided'><bsdf type='dielectric'/></bsdf>", "lets light through"},
        {"<bsdf type='twosided'><bsdf type='mask'>" DIFFUSE "</bsdf></bsdf>", "lets light through"},
        {"<bsdf type='twosided'>" DIFFUSE DIFFUSE DIFFUSE "</bsdf>", "at most 2 BSDFs"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++) {
        char body[2048];
        struct fewray_scene *scene = NULL;
        struct fewray_error error;
        snprintf(body, sizeof(body), "<shape type='cube'>\n%s</shape>", cases[i].bsdf);
        if (scratch_load(body, &scene, &error) >= 0)
            fail_msg("accepted: %s", cases[i].bsdf);
        if (!strstr(error.what, cases[i].what))
            fail_msg("'%s' lacks '%s'", error.what, cases[i].what);
        assert_int_equal(error.line, 3);
    }
}

/* At a point more BSDFs than a shading can hold, or deeper than any scene needs. */
static void test_nesting_is_bounded(void **state) {
    static char body[16384];
    struct fewray_scene *scene = NULL;
    struct fewray_error error;
    size_t used = 0;
    (void)state;
    for (int i = 0; i < 5; i++)
        used += (size_t)snprintf(body + used, sizeof(body) - used,
                                 "<bsdf type='blendbsdf' id='b%d'><float name='weight' "
                                 "value='.5'/>" DIFFUSE "%s</bsdf>",
                                 i, i ? "<ref id='previous'/>" : DIFFUSE);
    for (char *at = body, i = '0'; (at = strstr(at, "previous")); i++) {
        memcpy(at, "b0      ", 8);
        memmove(at + 2, at + 8, strlen(at + 8) + 1);
        at[1] = i;
    }
    strcat(body, "<shape type='cube'><ref id='b4'/></shape>");
    assert_int_equal(scratch_load(body, &scene, &error), FEWRAY_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.what, "joins 5 BSDFs"));

    used = 0;
    for (int i = 0; i < 40; i++)
        used += (size_t)snprintf(body + used, sizeof(body) - used,
                                 "<bsdf type='twosided' id='b%d'><ref id='b%d'/></bsdf>", i, i + 1);
    strcpy(body + used, "<bsdf type='diffuse' id='b40'/><shape type='cube'><ref id='b0'/></shape>");
    assert_true(scratch_load(body, &scene, &error) < 0);
    assert_non_null(strstr(error.what, "nested deeper"));
}

/* Unsupported ones become two-sided: what they hold, or diffuse of their reflectance. */
static void test_lenient_draws_the_rest_diffuse(void **state) {
    struct fewray_scene *scene = scratch_scene_as(
        "<bsdf type='pplastic' id='paint'><rgb name='diffuse_reflectance' value='0.2'/></bsdf>\n"
        "<bsdf type='circular' id='filter'><bsdf type='diffuse'><rgb name='reflectance' "
        "value='0.7'/></bsdf></bsdf>\n"
        "<bsdf type='principledthin' id='leaf'><rgb name='base_color' value='0.3'/></bsdf>\n"
        "<bsdf type='hair' id='hair'/>\n"
        "<shape type='cube'><ref id='paint'/></shape><shape type='cube'><ref id='filter'/></shape>"
        "<shape type='cube'><ref id='leaf'/></shape><shape type='cube'><ref id='hair'/></shape>"
        "<shape type='cube'><ref id='hair'/></shape>\n"
        "<shape type='cube'><bsdf type='mask'><ref id='leaf'/></bsdf></shape>\n"
        "<emitter type='projector'/>"
        "<integrator type='aov'><integrator type='path'><integer name='max_depth' value='3'/>"
        "</integrator></integrator>",
        true);
    const float expected[] = {0.2f, 0.7f, 0.3f, 0.5f};
    (void)state;
    for (int i = 0; i < 4; i++) {
        const struct bsdf *outer = bsdf_of(scene, i);
        assert_int_equal(outer->kind, BSDF_TWOSIDED);
        expect_grey(scene, scene->bsdfs[outer->nested[0]].reflectance, expected[i]);
    }
    assert_int_equal(bsdf_of(scene, 5)->kind, BSDF_MASK);
    assert_int_equal(scene->max_depth, 3);
    assert_int_equal(scene->warning_count, 6);
    assert_non_null(strstr(scene->warnings[0], "scene.xml:2: bsdf 'pplastic' (id 'paint') is"));
    assert_non_null(strstr(scene->warnings[4], "emitter 'projector' is left out"));
    fewray_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plastics),
        cmocka_unit_test(test_metals_by_name),
        cmocka_unit_test(test_conductors),
        cmocka_unit_test(test_dielectrics),
        cmocka_unit_test(test_principled),
        cmocka_unit_test(test_masks_and_blends),
        cmocka_unit_test(test_bump_and_normal_maps_need_tangents),
        cmocka_unit_test(test_ids_anywhere),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_nesting_is_bounded),
        cmocka_unit_test(test_lenient_draws_the_rest_diffuse),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
