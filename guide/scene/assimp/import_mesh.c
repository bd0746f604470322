/* SPDX-License-Identifier: Apache-2.0 */
/* One mesh of assimp's as a mesh of the scene. Where it has normals, each triangle winds so that
 * its face normal lies on their side, as in mesh_build.c. */

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/assimp/import.h"
#include "guide/scene/memory.h"
#include "guide/scene/mesh_data.h"

static struct vec3 apply(const double m[3][4], struct aiVector3D v, double w) {
    double p[3];
    for (int i = 0; i < 3; i++)
        p[i] = m[i][0] * (double)v.x + m[i][1] * (double)v.y + m[i][2] * (double)v.z + m[i][3] * w;
    return vec((float)p[0], (float)p[1], (float)p[2]);
}

static void store(float *values, size_t index, struct vec3 v) {
    values[3 * index] = v.x;
    values[3 * index + 1] = v.y;
    values[3 * index + 2] = v.z;
}

static struct vec3 load(const float *values, uint32_t index) {
    const float *v = values + 3 * (size_t)index;
    return vec(v[0], v[1], v[2]);
}

static bool copy_positions(struct mesh_data *mesh, const struct aiMesh *source,
                           const struct transform *to_world) {
    bool finite = true;
    for (unsigned i = 0; i < source->mNumVertices; i++) {
        struct vec3 p = apply(to_world->m, source->mVertices[i], 1);
        finite = finite && is_finite(p);
        store(mesh->positions, i, p);
    }
    return finite;
}

/* Normals up to the transform's largest number; a bad one becomes zero, and the triangle's own is
 * taken for it. */
static void copy_normals(struct mesh_data *mesh, const struct aiMesh *source,
                         const struct transform *to_world) {
    double n[3][3], largest = 0, m[3][4] = {{0}};
    transform_normal_matrix(to_world, n);
    for (int i = 0; i < 9; i++)
        largest = fmax(largest, fabs(n[i / 3][i % 3]));
    for (int i = 0; i < 9 && largest > 0; i++)
        m[i / 3][i % 3] = n[i / 3][i % 3] / largest;
    for (unsigned i = 0; i < source->mNumVertices; i++) {
        struct vec3 normal = normalize(apply(m, source->mNormals[i], 0));
        bool sound = is_finite(normal) && dot(normal, normal) > 0.5f;
        store(mesh->normals, i, sound ? normal : vec(0, 0, 0));
    }
}

static void copy_uvs(struct mesh_data *mesh, const struct aiVector3D *uvs) {
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        mesh->uvs[2 * (size_t)i] = fabsf(uvs[i].x) <= FLT_MAX ? uvs[i].x : 0;
        mesh->uvs[2 * (size_t)i + 1] = fabsf(uvs[i].y) <= FLT_MAX ? uvs[i].y : 0;
    }
}

static void copy_triangles(struct mesh_data *mesh, const struct aiMesh *source) {
    uint32_t count = 0;
    for (unsigned f = 0; f < source->mNumFaces; f++) {
        const struct aiFace *face = &source->mFaces[f];
        uint32_t *to = mesh->indices + 3 * (size_t)count;
        if (face->mNumIndices != 3 || face->mIndices[0] >= mesh->vertex_count ||
            face->mIndices[1] >= mesh->vertex_count || face->mIndices[2] >= mesh->vertex_count)
            continue;
        memcpy(to, face->mIndices, 3 * sizeof(*to));
        count++;
    }
    mesh->triangle_count = count;
}

static struct vec3 face_normal(const struct mesh_data *mesh, const uint32_t *i) {
    struct vec3 p = load(mesh->positions, i[0]);
    return cross(sub(load(mesh->positions, i[1]), p), sub(load(mesh->positions, i[2]), p));
}

static void reverse(uint32_t *triangle) {
    uint32_t second = triangle[1];
    triangle[1] = triangle[2];
    triangle[2] = second;
}

/* mirrored: the transform turned every face over, but not the normals. */
static void orient(struct mesh_data *mesh, bool mirrored) {
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t *i = mesh->indices + 3 * t;
        if (mirrored)
            reverse(i);
        if (!mesh->normals)
            continue;
        struct vec3 side = add(add(load(mesh->normals, i[0]), load(mesh->normals, i[1])),
                               load(mesh->normals, i[2]));
        if (dot(face_normal(mesh, i), side) < 0)
            reverse(i);
        struct vec3 face = normalize(face_normal(mesh, i));
        for (int c = 0; c < 3; c++)
            if (dot(load(mesh->normals, i[c]), load(mesh->normals, i[c])) < 0.5f)
                store(mesh->normals, i[c], dot(face, face) > 0.5f ? face : vec(0, 0, 1));
    }
}

static struct mesh *add_mesh(struct import *import) {
    struct fewray_scene *scene = import->scene;
    if (!array_reserve((void **)&scene->meshes, &import->mesh_capacity,
                       (size_t)scene->mesh_count + 1, sizeof(*scene->meshes)))
        return NULL;
    struct mesh *mesh = &scene->meshes[scene->mesh_count++];
    *mesh = (struct mesh){.kind = MESH_TRIANGLES};
    return mesh;
}

static bool has_triangles(const struct aiMesh *source) {
    for (unsigned i = 0; i < source->mNumFaces; i++)
        if (source->mFaces[i].mNumIndices == 3)
            return true;
    return false;
}

int import_mesh(struct import *import, const struct aiMesh *source,
                const struct import_material *material, const struct transform *to_world,
                int group) {
    const struct transform identity = transform_identity();
    const struct aiVector3D *uvs = source->mTextureCoords[material->uv_set % 8];
    const char *name = source->mName.data;
    struct mesh_data data;
    int status = FEWRAY_OK;
    if (!source->mVertices || !has_triangles(source))
        return import_warn(import, "points and lines are not drawn");
    if (source->mNumVertices > MESH_MAX_COUNT || source->mNumFaces > MESH_MAX_COUNT)
        return import_fail(import, FEWRAY_ERROR_UNSUPPORTED, "mesh '%.100s' is too large", name);
    if (source->mColors[0])
        status = import_warn(import, "vertex colours are ignored");
    if (!status && material->wants_uvs && !uvs)
        status = import_warn(import, "mesh '%.100s' has textures but no texture coordinates", name);
    struct mesh *mesh = status ? NULL : add_mesh(import);
    if (!mesh)
        return status ? status : import_fail_memory(import);
    bool allocated = mesh_data_allocate(&data, source->mNumVertices, source->mNumFaces,
                                        source->mNormals != NULL, uvs != NULL);
    *mesh = (struct mesh){.kind = MESH_TRIANGLES,
                          .id = strdup(name[0] ? name : "mesh"),
                          .vertex_count = data.vertex_count,
                          .positions = data.positions,
                          .normals = data.normals,
                          .uvs = data.uvs,
                          .indices = data.indices,
                          .group = group,
                          .bsdf = material->bsdf,
                          .emission = material->emission};
    if (!allocated || !mesh->id)
        return import_fail_memory(import);
    if (!to_world)
        to_world = &identity;
    if (!copy_positions(&data, source, to_world))
        return import_fail(import, FEWRAY_ERROR_FORMAT,
                           "mesh '%.100s': its vertices are not finite", name);
    if (data.normals)
        copy_normals(&data, source, to_world);
    if (uvs)
        copy_uvs(&data, uvs);
    copy_triangles(&data, source);
    mesh->triangle_count = data.triangle_count;
    orient(&data, transform_determinant(to_world) < 0);
    return FEWRAY_OK;
}
