/* SPDX-License-Identifier: Apache-2.0 */
/* glTF files arrive as scenes: materials, textures, lights, camera, nodes. */

#include "imported_scene.h"

/* A quad in the plane y = 0 that looks up, its corners from (-1, 0, -1) on, v along z. */
static const float quad[32] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1, /* positions */
                               0,  1, 0,  0, 1, 0,  0, 1, 0, 0,  1, 0, /* normals */
                               0,  0, 1,  0, 1, 1,  0, 1};             /* uvs */
static const uint16_t quad_indices[6] = {0, 2, 1, 0, 3, 2};
enum { BUFFER_SIZE = sizeof(quad) + sizeof(quad_indices) };

static void fill_buffer(uint8_t bytes[BUFFER_SIZE]) {
    memcpy(bytes, quad, sizeof(quad));
    memcpy(bytes + sizeof(quad), quad_indices, sizeof(quad_indices));
}

static char *base64(const uint8_t *bytes, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char *text = calloc(size / 3 + 2, 4), *to = text;
    for (size_t i = 0; i < size; i += 3) {
        uint32_t group = (uint32_t)bytes[i] << 16;
        group |= i + 1 < size ? (uint32_t)bytes[i + 1] << 8 : 0;
        group |= i + 2 < size ? (uint32_t)bytes[i + 2] : 0;
        for (size_t k = 0; k < 4; k++)
            *to++ = i + k <= size ? digits[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

/* What all files here share behind their own members: the quad, as meshes of materials 0, 1, 2. */
static const char *const geometry =
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':2},'indices':3,"
    "'material':0}]},{'primitives':[{'attributes':{'POSITION':0},'indices':3,'material':1},"
    "{'attributes':{'POSITION':0},'indices':3,'material':2}]}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},"
    "{'bufferView':0,'byteOffset':48,'componentType':5126,'count':4,'type':'VEC3'},"
    "{'bufferView':0,'byteOffset':96,'componentType':5126,'count':4,'type':'VEC2'},"
    "{'bufferView':0,'byteOffset':128,'componentType':5123,'count':6,'type':'SCALAR'},"
    /* An animation's times 0 and 1, and two places: (-1, 0, -1) and (1, 0, -1). */
    "{'bufferView':0,'byteOffset':100,'componentType':5126,'count':2,'type':'SCALAR'},"
    "{'bufferView':0,'componentType':5126,'count':2,'type':'VEC3'}],"
    "'bufferViews':[{'buffer':0,'byteLength':140}],";

static const char *const plain_materials = "'materials':[{},{},{}],";
static const char *const one_node = "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],";

/* The JSON with ' for ", malloc'd; buffer closes it. */
static char *make_json(const char *members, const char *buffer) {
    size_t size = strlen(members) + strlen(geometry) + strlen(buffer) + 64;
    char *text = malloc(size);
    snprintf(text, size, "{'asset':{'version':'2.0'},%s%s'buffers':[{%s'byteLength':%d}]}", members,
             geometry, buffer, (int)BUFFER_SIZE);
    for (char *c = text; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    return text;
}

static const char *write_gltf(const char *members) {
    uint8_t bytes[BUFFER_SIZE];
    char buffer[512];
    fill_buffer(bytes);
    char *encoded = base64(bytes, sizeof(bytes));
    snprintf(buffer, sizeof(buffer), "'uri':'data:application/octet-stream;base64,%s',", encoded);
    char *json = make_json(members, buffer);
    const char *path = scratch_text("scene.gltf", json);
    free(encoded);
    free(json);
    return path;
}

static const char *write_glb(const char *members) {
    char *json = make_json(members, "");
    uint32_t length = (uint32_t)(strlen(json) + 3) / 4 * 4;
    uint8_t *file = calloc(1, 28 + length + BUFFER_SIZE);
    const uint32_t header[5] = {0x46546C67, 2, 28 + length + BUFFER_SIZE, length, 0x4E4F534A};
    const uint32_t chunk[2] = {BUFFER_SIZE, 0x004E4942};
    memcpy(file, header, 20);
    memset(file + 20, ' ', length);
    memcpy(file + 20, json, strlen(json));
    memcpy(file + 20 + length, chunk, 8);
    fill_buffer(file + 28 + length);
    const char *path = scratch_write("scene.glb", file, header[2]);
    free(file);
    free(json);
    return path;
}

static void need_refusal(const char *path, int status, const char *word) {
    struct fewray_scene *scene = NULL;
    struct fewray_error error = {0};
    assert_int_equal(fewray_scene_load(path, NULL, &scene, &error), status);
    assert_null(scene);
    assert_string_equal(error.file, path);
    if (!strstr(error.what, word))
        fail_msg("'%s' doesn't say '%s'", error.what, word);
}

static void test_a_plain_gltf_and_glb_are_the_same(void **state) {
    char members[512];
    (void)state;
    snprintf(members, sizeof(members), "%s%s", one_node, plain_materials);
    for (int binary = 0; binary < 2; binary++) {
        struct fewray_scene *scene = load(binary ? write_glb(members) : write_gltf(members));
        assert_int_equal(scene->mesh_count, 1);
        const struct mesh *mesh = &scene->meshes[0];
        assert_int_equal(mesh->vertex_count, 4);
        assert_int_equal(mesh->triangle_count, 2);
        for (int i = 0; i < 6; i++) { /* newer assimp sorts vertices by their first use */
            const uint32_t found = mesh->indices[i], wanted = quad_indices[i];
            assert_memory_equal(mesh->positions + 3 * found, quad + 3 * wanted, 3 * sizeof(float));
            assert_memory_equal(mesh->normals + 3 * found, quad + 12 + 3 * wanted,
                                3 * sizeof(float));
            assert_memory_equal(mesh->uvs + 2 * found, quad + 24 + 2 * wanted, 2 * sizeof(float));
        }
        assert_int_equal(mesh->group, -1);
        const struct bsdf *bsdf = unwrapped(scene, mesh->bsdf, BSDF_TWOSIDED);
        assert_int_equal(bsdf->kind, BSDF_PRINCIPLED);
        assert_near(grey(scene, bsdf->principled[PRINCIPLED_METALLIC]), 1, 0);
        assert_near(grey(scene, bsdf->principled[PRINCIPLED_ROUGHNESS]), 1, 0);
        assert_near(bsdf->eta, 1.5, 0);
        /* Without light and camera: a white sky, a picture of all. */
        assert_int_equal(scene->environment.kind, ENVIRONMENT_CONSTANT);
        assert_int_equal(scene->warning_count, 1);
        assert_int_equal(scene->camera.width, 1280);
        assert_int_equal(scene->camera.height, 720);
        assert_int_equal(scene->max_depth, 8);
        fewray_scene_destroy(&scene);
    }
}

static void test_materials(void **state) {
    char members[2048];
    (void)state;
    write_textures();
    snprintf(members, sizeof(members), "%s",
             "'extensionsUsed':['KHR_materials_transmission','KHR_materials_ior',"
             "'KHR_materials_emissive_strength','KHR_texture_transform'],"
             "'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':1},{'mesh':0}],"
             "'textures':[{'source':0,'sampler':0},{'source':1}],'samplers':[{'wrapS':33071}],"
             "'images':[{'uri':'color%20a.exr'},{'uri':'mr.png'}],'materials':["
             "{'alphaMode':'MASK','alphaCutoff':0.6,'doubleSided':true,'pbrMetallicRoughness':{"
             "'baseColorFactor':[0.5,0.25,1,1],'baseColorTexture':{'index':0,'extensions':{"
             "'KHR_texture_transform':{'offset':[0.25,0.5],'rotation':1.57079633,'scale':[2,3]}}},"
             "'metallicRoughnessTexture':{'index':1},'roughnessFactor':0.5},"
             "'normalTexture':{'index':1}},"
             "{'pbrMetallicRoughness':{'metallicFactor':0,'roughnessFactor':0.25},'extensions':{"
             "'KHR_materials_transmission':{'transmissionFactor':0.75},"
             "'KHR_materials_ior':{'ior':1.25}}},"
             "{'alphaMode':'BLEND','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.5]},"
             "'emissiveFactor':[1,0.5,0.25],"
             "'extensions':{'KHR_materials_emissive_strength':{'emissiveStrength':8}}}],");
    struct fewray_scene *scene = load(write_gltf(members));
    assert_int_equal(scene->mesh_count, 3);
    assert_int_equal(scene->image_count, 3);

    const struct bsdf *glass = &scene->bsdfs[scene->meshes[0].bsdf];
    assert_int_equal(glass->kind, BSDF_PRINCIPLED);
    assert_near(grey(scene, glass->principled[PRINCIPLED_SPEC_TRANS]), 0.75, 1e-6);
    assert_near(grey(scene, glass->principled[PRINCIPLED_ROUGHNESS]), 0.25, 1e-6);
    assert_int_equal(glass->principled[PRINCIPLED_METALLIC], -1);
    assert_near(glass->eta, 1.25, 1e-6);
    assert_int_equal(scene->meshes[0].emission, -1);

    assert_color(scene->textures[scene->meshes[1].emission].color0, 8, 4, 2);
    assert_near(grey(scene, scene->bsdfs[scene->meshes[1].bsdf].weight), 0.5, 1e-6);
    assert_int_equal(scene->environment.kind, ENVIRONMENT_NONE);

    const struct bsdf *mask = &scene->bsdfs[scene->meshes[2].bsdf];
    const struct bsdf *map =
        unwrapped(scene, scene->meshes[2].bsdf, BSDF_MASK)->nested[0] + scene->bsdfs;
    assert_int_equal(map->kind, BSDF_NORMAL_MAP);
    assert_true(map->tangents && mask->tangents);
    const struct bsdf *floor = &scene->bsdfs[map->nested[0]];
    const struct texture *color = &scene->textures[floor->reflectance];
    assert_color(color->factor, 0.5, 0.25, 1);
    assert_int_equal(color->image->channels, 4);
    assert_int_equal(color->wrap, WRAP_CLAMP);
    assert_true(color->srgb);
    const float to_uv[6] = {0, 3, 0.25f, -2, 0, 0.5f};
    for (int i = 0; i < 6; i++)
        assert_near(color->to_uv[i], to_uv[i], 1e-5);
    const struct texture *opacity = &scene->textures[mask->weight];
    assert_int_equal(opacity->image->channels, 1);
    assert_int_equal(opacity->image->bytes[0], 255);
    assert_int_equal(opacity->image->bytes[1], 0);
    const struct texture *roughness = &scene->textures[floor->principled[PRINCIPLED_ROUGHNESS]];
    const struct texture *metallic = &scene->textures[floor->principled[PRINCIPLED_METALLIC]];
    assert_int_equal(roughness->channel, 1);
    assert_int_equal(metallic->channel, 2);
    assert_near(roughness->factor.x, 0.5, 1e-6);
    assert_ptr_equal(roughness->image, metallic->image);
    assert_ptr_equal(roughness->image, scene->textures[map->weight].image);
    assert_int_equal(roughness->image->bytes[1], 255);
    assert_false(roughness->srgb);
    fewray_scene_destroy(&scene);
}

/* Nodes turned by 90 degrees around x: -z becomes -y... */
static const char *const lights_and_camera =
    "'extensions':{'KHR_lights_punctual':{'lights':["
    "{'type':'point','color':[1,0.5,0.25],'intensity':1366},"
    "{'type':'spot','intensity':683,'spot':{'innerConeAngle':0.25,'outerConeAngle':0.5}},"
    "{'type':'directional','intensity':341.5}]}},"
    "'cameras':[{'type':'perspective','perspective':{'yfov':0.8,'aspectRatio':1.5,'znear':0.1}}],"
    "'scene':0,'scenes':[{'nodes':[0,1,2,3,4,5]}],'nodes':[{'mesh':0},"
    "{'translation':[1,2,3],'extensions':{'KHR_lights_punctual':{'light':0}}},"
    "{'scale':[2,2,2],'children':[6]},"
    "{'rotation':[-0.70710678,0,0,0.70710678],'extensions':{'KHR_lights_punctual':{'light':1}}},"
    "{'rotation':[-0.70710678,0,0,0.70710678],'extensions':{'KHR_lights_punctual':{'light':2}}},"
    "{'camera':0,'translation':[0,1,5],'scale':[3,3,3]},"
    "{'translation':[1,2,3],'extensions':{'KHR_lights_punctual':{'light':0}}}],";

static void test_lights_and_camera(void **state) {
    char members[4096];
    (void)state;
    snprintf(members, sizeof(members), "%s%s", lights_and_camera, plain_materials);
    struct fewray_scene *scene = load(write_gltf(members));
    assert_int_equal(scene->environment.kind, ENVIRONMENT_NONE);
    assert_int_equal(scene->light_count, 4);
    assert_int_equal(scene->lights[0].kind, LIGHT_POINT);
    assert_color(scene->lights[0].intensity, 2, 1, 0.5);
    assert_color(scene->lights[0].position, 1, 2, 3);
    assert_color(scene->lights[1].position, 2, 4, 6);
    assert_int_equal(scene->lights[2].kind, LIGHT_SPOT);
    assert_color(scene->lights[2].intensity, 1, 1, 1);
    assert_color(scene->lights[2].direction, 0, -1, 0);
    assert_near(scene->lights[2].beam_width, 0.25, 1e-6);
    assert_near(scene->lights[2].cutoff, 0.5, 1e-6);
    assert_int_equal(scene->lights[3].kind, LIGHT_DIRECTIONAL);
    assert_color(scene->lights[3].intensity, 0.5, 0.5, 0.5);

    const struct camera *camera = &scene->camera;
    const float to_world[12] = {-1, 0, 0, 0, 0, 1, 0, 1, 0, 0, -1, 5};
    for (int i = 0; i < 12; i++)
        assert_near(camera->to_world[i], to_world[i], 1e-6);
    assert_int_equal(camera->width, 1080);
    assert_int_equal(camera->height, 720);
    assert_near(camera->fov_x, 2 * atan(1.5 * tan(0.4)), 1e-6);
    fewray_scene_destroy(&scene);
}

/* Mirrored: the face still looks where its normal does. */
/* The camera's node stands on one that moves along x by 2 in a second. */
static void test_an_animated_camera_moves_with_the_time(void **state) {
    char members[2048];
    (void)state;
    snprintf(members, sizeof(members),
             "'scene':0,'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0},{'children':[2]},"
             "{'camera':0,'translation':[0,1,5]}],"
             "'cameras':[{'type':'perspective','perspective':{'yfov':0.8,'znear':0.1}}],"
             "'animations':[{'channels':[{'sampler':0,'target':{'node':1,'path':'translation'}}],"
             "'samplers':[{'input':4,'output':5}]}],%s",
             plain_materials);
    struct fewray_scene *scene = load(write_gltf(members));
    assert_int_equal(fewray_scene_summarize(scene).camera_keys, 2);
    for (int i = 0; i < 4; i++) {
        fewray_scene_set_time(scene, 0.5 * i);
        assert_near(scene->camera.to_world[3], i < 3 ? i - 1 : 1, 1e-5);
        assert_near(scene->camera.to_world[7], 1, 1e-5);
        assert_near(scene->camera.to_world[11], 4, 1e-5);
    }
    for (int i = 0; i < scene->warning_count; i++)
        assert_null(strstr(scene->warnings[i], "animations"));
    fewray_scene_destroy(&scene);
}

static void test_nodes_place_their_meshes(void **state) {
    char members[2048];
    (void)state;
    snprintf(members, sizeof(members), "%s%s",
             "'scenes':[{'nodes':[0]}],'nodes':[{'children':[1,2],'translation':[10,0,0]},"
             "{'mesh':0,'scale':[-2,1,1]},{'mesh':1,'translation':[0,5,0],'scale':[1,-1,1]}],",
             plain_materials);
    struct fewray_scene *scene = load(write_gltf(members));
    assert_int_equal(scene->mesh_count, 3);
    for (int m = 0; m < 3; m++) {
        const struct mesh *mesh = &scene->meshes[m];
        struct vec3 p[3];
        for (int i = 0; i < 3; i++) {
            const float *at = mesh->positions + 3 * mesh->indices[i];
            p[i] = vec(at[0], at[1], at[2]);
        }
        struct vec3 n = normalize(cross(sub(p[1], p[0]), sub(p[2], p[0])));
        assert_near(n.y, m ? -1 : 1, 1e-6);
        assert_near(mesh->positions[0], m ? 9 : 12, 1e-6);
        assert_near(mesh->positions[1], m ? 5 : 0, 1e-6);
    }
    assert_null(scene->meshes[1].normals);
    fewray_scene_destroy(&scene);
}

static void test_often_used_meshes_become_instances(void **state) {
    char members[2048] = "'scenes':[{'nodes':[0,1,2,3,4,5]}],'nodes':[";
    (void)state;
    for (int i = 0; i < 6; i++)
        snprintf(members + strlen(members), 64, "%s{'mesh':0,'translation':[%d,0,0]}", i ? "," : "",
                 i);
    snprintf(members + strlen(members), 64, "],%s", plain_materials);
    struct fewray_scene *scene = load(write_gltf(members));
    assert_int_equal(scene->mesh_count, 1);
    assert_int_equal(scene->group_count, 1);
    assert_int_equal(scene->instance_count, 6);
    assert_int_equal(scene->meshes[0].group, 0);
    assert_near(scene->instances[4].to_world[3], 4, 1e-6);
    /* The camera that frames all looks at their middle. */
    const float *m = scene->camera.to_world;
    float along = (2.5f - m[3]) / m[2];
    assert_near(m[7] + along * m[6], 0, 1e-4);
    assert_near(m[11] + along * m[10], 0, 1e-4);
    fewray_scene_destroy(&scene);
}

static void test_wrong_gltf_is_refused(void **state) {
    static const struct {
        const char *members, *word;
        int status;
    } cases[] = {
        {"", "no scene", FEWRAY_ERROR_FORMAT},
        {"'scenes':[{'nodes':[0]}],'nodes':[{'children':[1]},{'children':[0]}],", "tree",
         FEWRAY_ERROR_FORMAT},
        {"'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],'extensionsRequired':['KHR_x'],", "KHR_x",
         FEWRAY_ERROR_UNSUPPORTED},
        {"'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'translation':[1,2]}],", "translation",
         FEWRAY_ERROR_FORMAT},
        {"'scenes':[{'nodes':[0]}],'nodes':[{'mesh':7}],", "read the scene", FEWRAY_ERROR_FORMAT},
        {"'scenes':[{'nodes':[0]}],'nodes':[{}],", "no triangles", FEWRAY_ERROR_FORMAT},
    };
    char members[1024];
    (void)state;
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++) {
        snprintf(members, sizeof(members), "%s%s", cases[i].members, plain_materials);
        need_refusal(write_gltf(members), cases[i].status, cases[i].word);
    }
    need_refusal(scratch_text("scene.gltf", "{\n'"), FEWRAY_ERROR_FORMAT, "not a glTF");
    need_refusal(scratch_text("scene.gltf", "{}"), FEWRAY_ERROR_FORMAT, "asset.version");
    need_refusal(scratch_text("scene.gltf", "{\"asset\":{\"version\":\"1.0\"}}"),
                 FEWRAY_ERROR_UNSUPPORTED, "version 1.0");
    need_refusal(scratch_path("gone.glb"), FEWRAY_ERROR_IO, "read");
}

/* A .glb cut anywhere is refused, or is whole enough. */
static void test_cut_off_files_do_no_harm(void **state) {
    char members[512], bytes[4096];
    (void)state;
    snprintf(members, sizeof(members), "%s%s", one_node, plain_materials);
    FILE *file = fopen(write_glb(members), "rb");
    size_t size = fread(bytes, 1, sizeof(bytes), file);
    fclose(file);
    for (size_t cut = 1; cut < size; cut += 7) {
        struct fewray_scene *scene = NULL;
        struct fewray_error error = {0};
        const char *path = scratch_write("scene.glb", bytes, cut);
        int status = fewray_scene_load(path, NULL, &scene, &error);
        assert_true(status < 0 && error.what[0]);
        assert_null(scene);
    }
}

static void test_the_example(void **state) {
    (void)state;
    struct fewray_scene *scene = load(EXAMPLES "/lamp.gltf");
    assert_int_equal(scene->warning_count, 0);
    assert_int_equal(scene->mesh_count, 8);
    assert_int_equal(scene->light_count, 2);
    assert_int_equal(scene->image_count, 2);
    fewray_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_plain_gltf_and_glb_are_the_same),
        cmocka_unit_test(test_materials),
        cmocka_unit_test(test_lights_and_camera),
        cmocka_unit_test(test_an_animated_camera_moves_with_the_time),
        cmocka_unit_test(test_nodes_place_their_meshes),
        cmocka_unit_test(test_often_used_meshes_become_instances),
        cmocka_unit_test(test_wrong_gltf_is_refused),
        cmocka_unit_test(test_cut_off_files_do_no_harm),
        cmocka_unit_test(test_the_example),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
