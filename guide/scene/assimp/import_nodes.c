/* SPDX-License-Identifier: Apache-2.0 */
/* Nodes: what they place, from the root down. assimp's tree is walked along with the JSON's, whose
 * nodes, children and primitives stand in the same order. */

#include <stdlib.h>
#include <string.h>

#include "guide/scene/assimp/import.h"
#include "guide/scene/memory.h"

/* A mesh of more nodes is placed by instances, of fewer copied. */
#define MOST_COPIES 4
/* OBJ files and assimp's own wrappers have few levels; glTF's were counted (gltf_read.c). */
#define MAX_DEPTH 600

/* False where the tree is too deep or names meshes that aren't there. */
static bool count_uses(struct import *import, const struct aiNode *node, int depth) {
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        if (node->mMeshes[i] >= import->source->mNumMeshes)
            return false;
        import->mesh_uses[node->mMeshes[i]]++;
    }
    for (unsigned i = 0; i < node->mNumChildren; i++)
        if (depth > MAX_DEPTH || !count_uses(import, node->mChildren[i], depth + 1))
            return false;
    return true;
}

static struct transform transform_of(const struct aiMatrix4x4 *m) {
    return (struct transform){
        {{m->a1, m->a2, m->a3, m->a4}, {m->b1, m->b2, m->b3, m->b4}, {m->c1, m->c2, m->c3, m->c4}}};
}

static int find_material(struct import *import, const struct aiMesh *mesh, const json_t *json,
                         struct import_material **out) {
    if (mesh->mMaterialIndex >= import->source->mNumMaterials)
        return import_fail(import, FEWRAY_ERROR_FORMAT, "mesh '%.100s' has no material",
                           mesh->mName.data);
    const struct aiMaterial *source = import->source->mMaterials[mesh->mMaterialIndex];
    *out = &import->materials[mesh->mMaterialIndex];
    if ((*out)->done)
        return FEWRAY_OK;
    return import->gltf ? import_gltf_material(import, source, json, *out)
                        : import_mtl_material(import, source, *out);
}

static int add_instance(struct import *import, int group, const struct transform *to_world) {
    struct fewray_scene *scene = import->scene;
    if (!array_reserve((void **)&scene->instances, &import->instance_capacity,
                       (size_t)scene->instance_count + 1, sizeof(*scene->instances)))
        return import_fail_memory(import);
    struct instance *instance = &scene->instances[scene->instance_count++];
    instance->group = group;
    for (int i = 0; i < 12; i++)
        instance->to_world[i] = (float)to_world->m[i / 4][i % 4];
    return FEWRAY_OK;
}

static int place_mesh(struct import *import, unsigned index, const json_t *material_json,
                      const struct transform *to_world) {
    const struct aiMesh *mesh = import->source->mMeshes[index];
    struct import_material *material = NULL;
    int status = find_material(import, mesh, material_json, &material);
    if (status)
        return status;
    /* Meshes of groups don't shine. */
    if (import->mesh_uses[index] <= MOST_COPIES || material->emission >= 0)
        return import_mesh(import, mesh, material, to_world, -1);
    if (import->mesh_groups[index] < 0) {
        import->mesh_groups[index] = import->scene->group_count++;
        status = import_mesh(import, mesh, material, NULL, import->mesh_groups[index]);
    }
    return status ? status : add_instance(import, import->mesh_groups[index], to_world);
}

static int place_light(struct import *import, const json_t *json,
                       const struct transform *to_world) {
    struct fewray_scene *scene = import->scene;
    struct light light;
    if (!gltf_node_light(import->gltf, json, to_world, &light))
        return FEWRAY_OK;
    if (!array_reserve((void **)&scene->lights, &import->light_capacity,
                       (size_t)scene->light_count + 1, sizeof(*scene->lights)))
        return import_fail_memory(import);
    scene->lights[scene->light_count++] = light;
    return FEWRAY_OK;
}

/* The first camera. */
static int place_camera(struct import *import, const struct aiNode *node, const json_t *json,
                        const struct transform *to_world) {
    double fov_y, aspect;
    bool orthographic;
    struct transform pose;
    if (import->has_camera)
        return FEWRAY_OK;
    bool perspective = gltf_node_camera(import->gltf, json, &fov_y, &aspect, &orthographic);
    if (orthographic)
        return import_warn(import, "an orthographic camera is ignored");
    if (!perspective)
        return FEWRAY_OK;
    if (!import_camera_pose(to_world, &pose))
        return import_warn(import, "a camera whose node is scaled to nothing is ignored");
    for (int i = 0; i < 12; i++)
        import->scene->camera.to_world[i] = (float)pose.m[i / 4][i % 4];
    import->has_camera = true;
    import->fov_y = fov_y;
    import->aspect = aspect;
    return import_camera_keys(import, node);
}

/* json: the node of a glTF file; NULL for OBJ, or the root that assimp adds around several. */
static int place_node(struct import *import, const struct aiNode *node, const json_t *json,
                      const struct transform *parent) {
    struct transform own = transform_of(&node->mTransformation);
    struct transform to_world = transform_multiply(parent, &own);
    int status = FEWRAY_OK;
    bool added_root = import->gltf && !json;
    const json_t *list = added_root ? gltf_scene(import->gltf) : json;
    if (import->gltf &&
        ((!added_root && gltf_primitive_count(import->gltf, json) != node->mNumMeshes) ||
         gltf_child_count(list, added_root ? "nodes" : "children") != node->mNumChildren))
        return import_fail(import, FEWRAY_ERROR_FORMAT, "its nodes can't be followed at '%.100s'",
                           node->mName.data);
    if (json)
        status = place_light(import, json, &to_world);
    if (!status && json)
        status = place_camera(import, node, json, &to_world);
    for (unsigned i = 0; i < node->mNumMeshes && !status; i++)
        status =
            place_mesh(import, node->mMeshes[i],
                       json ? gltf_primitive_material(import->gltf, json, i) : NULL, &to_world);
    for (unsigned i = 0; i < node->mNumChildren && !status; i++) {
        const json_t *child = added_root ? gltf_root(import->gltf, i)
                              : json     ? gltf_child(import->gltf, json, i)
                                         : NULL;
        status = place_node(import, node->mChildren[i], child, &to_world);
    }
    return status;
}

int import_nodes(struct import *import) {
    const struct aiNode *root = import->source->mRootNode;
    struct transform identity = transform_identity();
    for (unsigned i = 0; i < import->source->mNumMeshes; i++)
        import->mesh_groups[i] = -1;
    if (!count_uses(import, root, 0))
        return import_fail(import, FEWRAY_ERROR_FORMAT, "its nodes are damaged or too deep");
    int status = FEWRAY_OK;
    /* assimp adds a root unless there is exactly one. */
    bool one = import->gltf && gltf_child_count(gltf_scene(import->gltf), "nodes") == 1;
    if (!status)
        status = place_node(import, root, one ? gltf_root(import->gltf, 0) : NULL, &identity);
    if (!status && import->gltf && import_moves_more(import))
        status = import_warn(import, "skins, morph targets and animations of all but the camera "
                                     "are ignored: everything else is shown at rest");
    if (!status && import->scene->mesh_count == 0)
        status = import_fail(import, FEWRAY_ERROR_FORMAT, "the scene has no triangles");
    return status;
}
