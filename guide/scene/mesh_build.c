/* SPDX-License-Identifier: Apache-2.0 */
/* From a shape to a mesh in world space, by Mitsuba's rules for normals and sides.
 *
 * Mitsuba decides by the shading normal which side of a surface is in front, whichever way the
 * triangles wind. Here the winding of each triangle is made to agree with its vertex normals, so
 * that face and shading normal lie on one side. */

#include "guide/scene/mesh_build.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/loader.h"
#include "guide/scene/team.h"

/* Of a sphere's transform, over its squared scale: with less it stays a sphere. */
#define LEAST_SHEAR 1e-5

static bool copy_array(void *array, size_t items, size_t size) {
    void **pointer = array, *copy;
    if (!*pointer)
        return true;
    copy = malloc((items + 1) * size);
    if (copy)
        memcpy(copy, *pointer, items * size);
    if (copy)
        memset((char *)copy + items * size, 0, size);
    *pointer = copy;
    return copy != NULL;
}

/* Replaces the arrays by copies; what couldn't be copied becomes NULL. */
static bool unshare(struct mesh_data *mesh) {
    bool done = copy_array(&mesh->positions, mesh->vertex_count, 3 * sizeof(float));
    done = copy_array(&mesh->normals, mesh->vertex_count, 3 * sizeof(float)) && done;
    done = copy_array(&mesh->uvs, mesh->vertex_count, 2 * sizeof(float)) && done;
    return copy_array(&mesh->indices, mesh->triangle_count, 3 * sizeof(uint32_t)) && done;
}

/* The shape in its own space. A file's mesh that no other shape needs is taken over. */
static bool take_mesh(const struct loader *loader, const struct shape *shape,
                      struct mesh_data *mesh) {
    switch (shape->kind) {
    case SHAPE_RECTANGLE:
        return mesh_make_rectangle(mesh);
    case SHAPE_DISK:
        return mesh_make_disk(mesh);
    case SHAPE_CUBE:
        return mesh_make_cube(mesh);
    case SHAPE_CYLINDER:
        return mesh_make_cylinder(mesh);
    case SHAPE_SPHERE:
        return mesh_make_sphere(mesh);
    default:
        break;
    }
    struct asset *asset = &loader->assets.items[shape->asset];
    *mesh = asset->mesh;
    if (asset->users > 1)
        return unshare(mesh);
    asset->mesh = (struct mesh_data){0};
    return true;
}

static void apply(const double m[3][4], float *p, double w) {
    double x = p[0], y = p[1], z = p[2];
    for (int i = 0; i < 3; i++)
        p[i] = (float)(m[i][0] * x + m[i][1] * y + m[i][2] * z + m[i][3] * w);
}

static bool transform_positions(struct mesh_data *mesh, const struct transform *to_world) {
    bool finite = true;
#pragma omp taskloop num_tasks(team_tasks()) if (team_pays(mesh->vertex_count)) shared(finite)
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        float *p = mesh->positions + 3 * i;
        apply(to_world->m, p, 1);
        for (int j = 0; j < 3; j++)
            if (!(fabsf(p[j]) <= FLT_MAX)) {
#pragma omp atomic write
                finite = false;
            }
    }
    return finite;
}

static bool normalize_in_place(float n[3]) {
    double x = n[0], y = n[1], z = n[2], l = sqrt(x * x + y * y + z * z);
    if (!(l > 0 && l <= DBL_MAX))
        return false;
    n[0] = (float)(x / l);
    n[1] = (float)(y / l);
    n[2] = (float)(z / l);
    return true;
}

/* By smooth ones; false without memory. */
static bool replace_zero_normals(struct mesh_data *mesh) {
    float *smooth = mesh_smooth_normals(mesh);
    if (!smooth)
        return false;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        float *n = mesh->normals + 3 * i;
        if (n[0] == 0 && n[1] == 0 && n[2] == 0)
            memcpy(n, smooth + 3 * i, 3 * sizeof(float));
    }
    free(smooth);
    return true;
}

/* Normals that a file stores as zero or NaN are replaced by smooth ones. */
static bool transform_normals(struct mesh_data *mesh, const struct transform *to_world) {
    double n[3][3], m[3][4], largest = 0;
    bool complete = true;
    transform_normal_matrix(to_world, n);
    for (int i = 0; i < 9; i++)
        largest = fmax(largest, fabs(n[i / 3][i % 3]));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            m[i][j] = j == 3 || largest == 0 ? 0 : n[i][j] / largest;
#pragma omp taskloop num_tasks(team_tasks()) if (team_pays(mesh->vertex_count)) shared(m, complete)
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        float *normal = mesh->normals + 3 * i;
        if (normalize_in_place(normal)) {
            apply(m, normal, 0);
            if (normalize_in_place(normal))
                continue;
        }
        memset(normal, 0, 3 * sizeof(float));
#pragma omp atomic write
        complete = false;
    }
    return complete || replace_zero_normals(mesh);
}

static void negate_normals(struct mesh_data *mesh) {
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++)
        mesh->normals[i] = -mesh->normals[i];
}

static void reverse(uint32_t triangle[3]) {
    uint32_t second = triangle[1];
    triangle[1] = triangle[2];
    triangle[2] = second;
}

static struct vec3 at(const float *values, uint32_t index) {
    const float *v = values + 3 * (size_t)index;
    return vec(v[0], v[1], v[2]);
}

/* Winds each triangle so that its face normal lies on the side of its vertex normals. */
static void wind_by_normals(struct mesh_data *mesh) {
#pragma omp taskloop num_tasks(team_tasks()) if (team_pays(mesh->triangle_count))
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t *i = mesh->indices + 3 * t;
        struct vec3 p = at(mesh->positions, i[0]);
        struct vec3 face =
            cross(sub(at(mesh->positions, i[1]), p), sub(at(mesh->positions, i[2]), p));
        struct vec3 side =
            add(add(at(mesh->normals, i[0]), at(mesh->normals, i[1])), at(mesh->normals, i[2]));
        if (dot(face, side) < 0)
            reverse(i);
    }
}

static void drop_normals(struct mesh_data *mesh) {
    free(mesh->normals);
    mesh->normals = NULL;
}

/* Mitsuba turns a mirrored sphere inside out, but no other shape that has normals. */
static bool is_flipped(const struct shape *shape) {
    bool mirrored = shape->kind == SHAPE_SPHERE && transform_determinant(&shape->to_world) < 0;
    return shape->flip_normals != mirrored;
}

/* False without memory. */
static bool set_normals(struct mesh_data *mesh, const struct shape *shape) {
    bool is_flat =
        shape->kind == SHAPE_RECTANGLE || shape->kind == SHAPE_DISK || shape->kind == SHAPE_CUBE;
    if (shape->face_normals)
        drop_normals(mesh);
    if (mesh->normals) {
        if (!transform_normals(mesh, &shape->to_world))
            return false;
    } else if (!shape->face_normals) {
        mesh->normals = mesh_smooth_normals(mesh);
        if (!mesh->normals)
            return false;
    }
    bool flip = is_flipped(shape);
    if (mesh->normals) {
        if (flip)
            negate_normals(mesh);
        wind_by_normals(mesh);
    } else if (flip) {
        for (size_t t = 0; t < mesh->triangle_count; t++)
            reverse(mesh->indices + 3 * t);
    }
    if (is_flat)
        drop_normals(mesh);
    return true;
}

static void set_uvs(struct mesh_data *mesh, bool flip_v) {
    const size_t count = mesh->uvs ? mesh->vertex_count : 0;
#pragma omp taskloop num_tasks(team_tasks()) if (team_pays(count))
    for (size_t i = 0; i < count; i++) {
        float *uv = mesh->uvs + 2 * i;
        for (int j = 0; j < 2; j++)
            if (!(fabsf(uv[j]) <= FLT_MAX))
                uv[j] = 0;
        if (flip_v)
            uv[1] = 1 - uv[1];
    }
}

/* False where the transform stretches the unit sphere, or floats can't hold the result. */
static bool set_sphere(const struct transform *to_world, struct mesh *out) {
    const double(*m)[4] = to_world->m;
    double radius = cbrt(fabs(transform_determinant(to_world)));
    if (!(radius > 1e-30 && radius < 1e30))
        return false;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double product = m[0][i] * m[0][j] + m[1][i] * m[1][j] + m[2][i] * m[2][j];
            if (!(fabs(product / (radius * radius) - (i == j)) <= LEAST_SHEAR))
                return false;
            out->sphere_axes[3 * i + j] = (float)(m[j][i] / radius);
        }
    for (int i = 0; i < 3; i++) {
        if (!(fabs(m[i][3]) < 1e30))
            return false;
        out->sphere[i] = (float)m[i][3];
    }
    out->sphere[3] = (float)radius;
    out->kind = MESH_SPHERE;
    return true;
}

static int build_triangles(const struct loader *loader, const struct shape *shape,
                           struct mesh *out) {
    struct mesh_data mesh = {0};
    int status = FEWRAY_OK;
    if (!take_mesh(loader, shape, &mesh))
        status = FEWRAY_ERROR_MEMORY;
    else if (!transform_positions(&mesh, &shape->to_world))
        status = FEWRAY_ERROR_FORMAT;
    else if (!set_normals(&mesh, shape))
        status = FEWRAY_ERROR_MEMORY;
    set_uvs(&mesh, shape->flip_v);
    out->vertex_count = mesh.vertex_count;
    out->triangle_count = mesh.triangle_count;
    out->positions = mesh.positions;
    out->normals = mesh.normals;
    out->uvs = mesh.uvs;
    out->indices = mesh.indices;
    return status;
}

static int build_mesh(const struct loader *loader, const struct shape *shape, struct mesh *out) {
    out->bsdf = shape->bsdf;
    out->emission = shape->emission;
    out->group = shape->group;
    out->id = strdup(shape->name);
    if (!out->id)
        return FEWRAY_ERROR_MEMORY;
    if (shape->kind == SHAPE_SPHERE && set_sphere(&shape->to_world, out)) {
        out->flip_normals = is_flipped(shape);
        return FEWRAY_OK;
    }
    return build_triangles(loader, shape, out);
}

/* Refuses a scene that places its files more often than memory has room for. */
static int check_memory(struct loader *loader) {
    double bytes = 0;
    for (size_t i = 0; i < loader->shape_count; i++) {
        const struct shape *shape = &loader->shapes[i];
        if (shape->kind != SHAPE_FILE)
            continue;
        const struct mesh_data *mesh = &loader->assets.items[shape->asset].mesh;
        bytes += 32.0 * mesh->vertex_count + 12.0 * mesh->triangle_count;
    }
    return fewray_memory_check(loader->path, "all meshes together", bytes, loader->error);
}

int meshes_build(struct loader *loader) {
    struct fewray_scene *scene = loader->scene;
    size_t count = loader->shape_count, first_failure = count;
    int status = check_memory(loader);
    if (status)
        return status;
    scene->meshes = calloc(count + 1, sizeof(*scene->meshes));
    if (!scene->meshes)
        return loader_fail_memory(loader);
    scene->mesh_count = (int)count;
#pragma omp parallel for schedule(dynamic, 1) num_threads(loader->threads)
    for (size_t i = 0; i < count; i++) {
        int result = build_mesh(loader, &loader->shapes[i], &scene->meshes[i]);
        if (result) {
#pragma omp critical(fewray_meshes_build)
            if (i < first_failure) {
                first_failure = i;
                status = result;
            }
        }
    }
    if (status == FEWRAY_ERROR_MEMORY)
        return loader_fail_memory(loader);
    if (status)
        return loader_fail(loader, status, loader->shapes[first_failure].node,
                           "%s: its vertices are not finite after the transform",
                           loader->shapes[first_failure].name);
    return FEWRAY_OK;
}
