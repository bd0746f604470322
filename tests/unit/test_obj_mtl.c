/* SPDX-License-Identifier: Apache-2.0 */
/* OBJ + MTL files arrive as scenes. */

#include "imported_scene.h"

static void test_obj_with_mtl(void **state) {
    (void)state;
    write_textures();
    scratch_text("scene.mtl", "newmtl wall\nKd 0.5 0.25 1\nmap_Kd mr.png\nillum 1\n"
                              "newmtl lamp\nKd 0 0 0\nKe 8 4 2\nillum 1\n"
                              "newmtl coat\nKd 0.1 0.2 0.3\nKs 0.5 0.5 0.5\nNs 198\nillum 2\n"
                              "newmtl glass\nKd 0 0 0\nTf 1 0.5 1\nNi 1.5\nillum 7\n"
                              "newmtl veil\nKd 1 1 1\nd 0.25\nillum 1\n"
                              "newmtl metal\nKd 1 1 1\nPr 0.25\nPm 1\n");
    struct fewray_scene *scene =
        load(scratch_text("scene.obj", "mtllib scene.mtl\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\n"
                                       "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.75\n"
                                       "usemtl wall\nf 1/1 4/4 3/3 2/2\nusemtl lamp\nf 1 4 3\n"
                                       "usemtl coat\nf 1 4 3\nusemtl glass\nf 1 4 3\n"
                                       "usemtl veil\nf 1 4 3\nusemtl metal\nf 1 4 3\n"));
    assert_int_equal(scene->mesh_count, 6);
    assert_int_equal(scene->meshes[0].triangle_count, 2);
    assert_int_equal(scene->warning_count, 0);
    const struct bsdf *wall = unwrapped(scene, scene->meshes[0].bsdf, BSDF_TWOSIDED);
    assert_int_equal(wall->kind, BSDF_DIFFUSE);
    assert_color(scene->textures[wall->reflectance].factor, 0.5, 0.25, 1);
    /* v of OBJ goes up, ours goes down the image. */
    for (uint32_t i = 0; i < 4; i++)
        if (scene->meshes[0].positions[3 * i] == -1 && scene->meshes[0].positions[3 * i + 2] == 1)
            assert_near(scene->meshes[0].uvs[2 * i + 1], 0.25, 1e-6);
    assert_color(scene->textures[scene->meshes[1].emission].color0, 8, 4, 2);
    const struct bsdf *coat = unwrapped(scene, scene->meshes[2].bsdf, BSDF_TWOSIDED);
    assert_int_equal(coat->kind, BSDF_ROUGH_PLASTIC);
    assert_near(grey(scene, coat->alpha_u), 0.1, 1e-6);
    const struct bsdf *glass = &scene->bsdfs[scene->meshes[3].bsdf];
    assert_int_equal(glass->kind, BSDF_DIELECTRIC);
    assert_near(glass->eta, 1.5, 1e-6);
    assert_color(scene->textures[glass->specular_transmittance].color0, 1, 0.5, 1);
    assert_near(grey(scene, scene->bsdfs[scene->meshes[4].bsdf].weight), 0.25, 1e-6);
    const struct bsdf *metal = unwrapped(scene, scene->meshes[5].bsdf, BSDF_TWOSIDED);
    assert_int_equal(metal->kind, BSDF_PRINCIPLED);
    assert_near(grey(scene, metal->principled[PRINCIPLED_ROUGHNESS]), 0.25, 1e-6);
    fewray_scene_destroy(&scene);
}

static void test_missing_files_of_an_obj_are_told(void **state) {
    (void)state;
    struct fewray_scene *scene =
        load(scratch_text("scene.obj", "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    assert_int_equal(scene->warning_count, 2);
    assert_non_null(strstr(scene->warnings[0], "gone.mtl"));
    fewray_scene_destroy(&scene);
    scratch_text("scene.mtl", "newmtl a\nKd 1 1 1\nmap_Kd gone.png\n");
    scratch_text("scene.obj",
                 "mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n");
    struct fewray_error error = {0};
    assert_true(fewray_scene_load(scratch_path("scene.obj"), NULL, &scene, &error) < 0);
    assert_non_null(strstr(error.file, "gone.png"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_obj_with_mtl),
        cmocka_unit_test(test_missing_files_of_an_obj_are_told),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
