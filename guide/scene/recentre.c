/* SPDX-License-Identifier: Apache-2.0 */
/* Moves the origin of a scene that is far from it. */

#include "guide/scene/recentre.h"

/* The middle's distance, over half the scene's largest side, from which on the origin moves. */
#define FAR 64

struct box {
    double low[3], high[3];
};

static const struct box nothing = {{INFINITY, INFINITY, INFINITY},
                                   {-INFINITY, -INFINITY, -INFINITY}};

static void include(struct box *box, const double p[3]) {
    for (int i = 0; i < 3; i++) {
        box->low[i] = p[i] < box->low[i] ? p[i] : box->low[i];
        box->high[i] = p[i] > box->high[i] ? p[i] : box->high[i];
    }
}

static void include_box(struct box *box, const struct box *other) {
    include(box, other->low);
    include(box, other->high);
}

static struct box mesh_box(const struct mesh *mesh) {
    struct box box = nothing;
    for (int side = -1; side <= 1 && mesh->kind == MESH_SPHERE; side += 2) {
        double p[3];
        for (int i = 0; i < 3; i++)
            p[i] = (double)mesh->sphere[i] + side * (double)mesh->sphere[3];
        include(&box, p);
    }
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        const float *p = mesh->positions + 3 * v;
        include(&box, (const double[3]){p[0], p[1], p[2]});
    }
    return box;
}

/* Around the corners of a box that is placed; nothing stays nothing. */
static struct box placed_box(const struct box *box, const float m[12]) {
    struct box placed = nothing;
    for (int corner = 0; corner < 8 && box->low[0] <= box->high[0]; corner++) {
        double p[3];
        for (int i = 0; i < 3; i++) {
            p[i] = m[4 * i + 3];
            for (int j = 0; j < 3; j++)
                p[i] += m[4 * i + j] * (corner >> j & 1 ? box->high[j] : box->low[j]);
        }
        include(&placed, p);
    }
    return placed;
}

/* Of the surfaces that stand in the scene itself, or of a group's in its own space. */
static struct box meshes_box(const struct fewray_scene *scene, int group, int threads) {
    struct box all = nothing;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (int m = 0; m < scene->mesh_count; m++) {
        if ((scene->meshes[m].group < 0 ? -1 : scene->meshes[m].group) != group)
            continue;
        const struct box box = mesh_box(&scene->meshes[m]);
#pragma omp critical(fewray_meshes_box)
        include_box(&all, &box);
    }
    return all;
}

static struct box scene_box(const struct fewray_scene *scene, int threads) {
    struct box all = meshes_box(scene, -1, threads);
    for (int g = 0; g < scene->group_count; g++) {
        const struct box group = meshes_box(scene, g, threads);
        for (int i = 0; i < scene->instance_count; i++) {
            if (scene->instances[i].group != g)
                continue;
            const struct box placed = placed_box(&group, scene->instances[i].to_world);
            include_box(&all, &placed);
        }
    }
    return all;
}

static void move_mesh(struct mesh *mesh, const float by[3]) {
    for (int i = 0; i < 3; i++)
        mesh->sphere[i] -= mesh->kind == MESH_SPHERE ? by[i] : 0;
    for (size_t v = 0; v < mesh->vertex_count; v++)
        for (int i = 0; i < 3; i++)
            mesh->positions[3 * v + (size_t)i] -= by[i];
}

static void move_scene(struct fewray_scene *scene, const float by[3], int threads) {
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (int m = 0; m < scene->mesh_count; m++)
        if (scene->meshes[m].group < 0)
            move_mesh(&scene->meshes[m], by);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < scene->instance_count; k++)
            scene->instances[k].to_world[4 * i + 3] -= by[i];
        for (int k = 0; k < scene->camera_key_count; k++)
            scene->camera_keys[k].position[i] -= (double)by[i];
        scene->camera.to_world[4 * i + 3] -= by[i];
        scene->origin[i] = by[i];
    }
    for (int k = 0; k < scene->light_count; k++) {
        struct vec3 *p = &scene->lights[k].position;
        *p = sub(*p, vec(by[0], by[1], by[2]));
    }
}

void scene_recentre(struct fewray_scene *scene, int threads) {
    const struct box box = scene_box(scene, threads);
    float by[3] = {0, 0, 0};
    double reach = 0;
    bool far = false;
    if (!(box.low[0] <= box.high[0]))
        return;
    for (int i = 0; i < 3; i++)
        reach = fmax(reach, 0.5 * (box.high[i] - box.low[i]));
    for (int i = 0; i < 3; i++) {
        double middle = 0.5 * (box.low[i] + box.high[i]);
        if (fabs(middle) > FAR * reach) {
            by[i] = (float)middle;
            far = true;
        }
    }
    if (far)
        move_scene(scene, by, threads);
}
