/* SPDX-License-Identifier: Apache-2.0 */
/* The film, and what a file may lack: a camera that shows all of it, and light. */

#include <float.h>
#include <math.h>

#include "guide/scene/assimp/import.h"

#define FILM_WIDTH  1280
#define FILM_HEIGHT 720
#define FRAMING_FOV 0.7f /* radians, along x */

struct box {
    struct vec3 low, high;
};

static void grow(struct box *box, struct vec3 p) {
    box->low = vec(fminf(box->low.x, p.x), fminf(box->low.y, p.y), fminf(box->low.z, p.z));
    box->high = vec(fmaxf(box->high.x, p.x), fmaxf(box->high.y, p.y), fmaxf(box->high.z, p.z));
}

static struct vec3 placed(const float *m, const float *p) {
    if (!m)
        return vec(p[0], p[1], p[2]);
    return vec(m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3],
               m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7],
               m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11]);
}

static void grow_by_mesh(struct box *box, const struct mesh *mesh, const float *to_world) {
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++)
        grow(box, placed(to_world, mesh->positions + 3 * (size_t)mesh->indices[i]));
}

static struct box bounds(const struct fewray_scene *scene) {
    struct box box = {{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
    for (int i = 0; i < scene->mesh_count; i++)
        if (scene->meshes[i].group < 0)
            grow_by_mesh(&box, &scene->meshes[i], NULL);
    for (int k = 0; k < scene->instance_count; k++)
        for (int i = 0; i < scene->mesh_count; i++)
            if (scene->meshes[i].group == scene->instances[k].group)
                grow_by_mesh(&box, &scene->meshes[i], scene->instances[k].to_world);
    return box;
}

/* Least distance from the box's middle at which all its corners are in the picture. */
static float framing_distance(const struct box *box, const struct vec3 axes[3], float tan_x,
                              float tan_y) {
    struct vec3 half = scale(sub(box->high, box->low), 0.5f);
    float distance = 0;
    for (int k = 0; k < 8; k++) {
        struct vec3 corner =
            vec(k & 1 ? half.x : -half.x, k & 2 ? half.y : -half.y, k & 4 ? half.z : -half.z);
        float across =
            fmaxf(fabsf(dot(corner, axes[0])) / tan_x, fabsf(dot(corner, axes[1])) / tan_y);
        distance = fmaxf(distance, across - dot(corner, axes[2]));
    }
    return distance;
}

/* From the front, the right and above: y is up and the front looks along z in both formats. False
 * where floats don't reach that far. */
static bool frame_all(struct fewray_scene *scene) {
    struct camera *camera = &scene->camera;
    struct box box = bounds(scene);
    if (!(box.low.x <= box.high.x)) /* no surface at all */
        box = (struct box){{0, 0, 0}, {0, 0, 0}};
    struct vec3 middle = scale(add(scale(box.low, 0.5f), scale(box.high, 0.5f)), 1);
    struct vec3 axes[3];
    axes[2] = normalize(vec(-0.55f, -0.4f, -1));
    axes[0] = normalize(cross(vec(0, 1, 0), axes[2]));
    axes[1] = cross(axes[2], axes[0]);
    float tan_x = tanf(FRAMING_FOV / 2);
    float tan_y = tan_x * (float)camera->height / (float)camera->width;
    float distance = 1.05f * framing_distance(&box, axes, tan_x, tan_y);
    struct vec3 eye = sub(middle, scale(axes[2], distance > 0 ? distance : 1));
    const float rows[12] = {axes[0].x, axes[1].x, axes[2].x, eye.x,     axes[0].y, axes[1].y,
                            axes[2].y, eye.y,     axes[0].z, axes[1].z, axes[2].z, eye.z};
    camera->fov_x = FRAMING_FOV;
    for (int i = 0; i < 12; i++) {
        if (!isfinite(rows[i]))
            return false;
        camera->to_world[i] = rows[i];
    }
    return true;
}

static void set_film(struct import *import) {
    struct camera *camera = &import->scene->camera;
    double aspect = fmin(fmax(import->aspect, 0.1), 10);
    camera->height = FILM_HEIGHT;
    camera->width = import->aspect > 0 ? (int)(FILM_HEIGHT * aspect + 0.5) : FILM_WIDTH;
    if (import->has_camera)
        camera->fov_x = (float)(2 * atan(tan(import->fov_y / 2) * camera->width / camera->height));
}

static bool shines(const struct fewray_scene *scene) {
    for (int i = 0; i < scene->mesh_count; i++)
        if (scene->meshes[i].emission >= 0)
            return true;
    return scene->light_count > 0;
}

int import_view(struct import *import) {
    struct fewray_scene *scene = import->scene;
    int status = FEWRAY_OK;
    set_film(import);
    if (!import->has_camera && !frame_all(scene))
        return import_fail(import, FEWRAY_ERROR_FORMAT,
                           "its surfaces reach too far for a camera to show all of them");
    if (!shines(scene)) {
        scene->environment.kind = ENVIRONMENT_CONSTANT;
        scene->environment.radiance = vec(1, 1, 1);
        status = import_warn(import, "it has no light: lit by a white sky of radiance 1");
    }
    return status;
}
