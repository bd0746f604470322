/* SPDX-License-Identifier: Apache-2.0 */
/* Light tables and their sampling. */

#include "guide/trace/lights.h"

#include <stdlib.h>

#include "guide/trace/distribution.h"
#include "guide/trace/surface.h"

static struct vec3 corner(const struct mesh *mesh, uint32_t triangle, int i) {
    const float *p = mesh->positions + 3 * (size_t)mesh->indices[3 * (size_t)triangle + (size_t)i];
    return vec(p[0], p[1], p[2]);
}

static float triangle_area(const struct mesh *mesh, uint32_t triangle) {
    struct vec3 p0 = corner(mesh, triangle, 0);
    return 0.5f *
           length(cross(sub(corner(mesh, triangle, 1), p0), sub(corner(mesh, triangle, 2), p0)));
}

/* Radius of a sphere around all vertices: what the environment's power is measured over. */
static double scene_radius(const struct fewray_scene *scene) {
    struct vec3 low = vec(INFINITY, INFINITY, INFINITY), high = negate(low);
    for (int m = 0; m < scene->mesh_count; m++)
        for (uint32_t i = 0; i < scene->meshes[m].vertex_count; i++) {
            const float *p = scene->meshes[m].positions + 3 * (size_t)i;
            low = vec(fminf(low.x, p[0]), fminf(low.y, p[1]), fminf(low.z, p[2]));
            high = vec(fmaxf(high.x, p[0]), fmaxf(high.y, p[1]), fmaxf(high.z, p[2]));
        }
    return low.x <= high.x ? 0.5 * length(sub(high, low)) : 1;
}

static size_t count_light_triangles(const struct fewray_scene *scene) {
    size_t n = 0;
    for (int m = 0; m < scene->mesh_count; m++)
        if (scene->meshes[m].emissive)
            n += scene->meshes[m].triangle_count;
    return n;
}

static void add_mesh(const struct fewray_scene *scene, uint32_t m, struct lights *lights,
                     float *power) {
    const struct mesh *mesh = &scene->meshes[m];
    lights->first_triangle[m] = (uint32_t)lights->triangle_count;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        size_t i = lights->triangle_count++;
        power[i] = triangle_area(mesh, t) * luminance(mesh->radiance) * PI_F;
        lights->triangles[i] = (struct light_triangle){m, t, 0};
    }
}

int lights_create(const struct fewray_scene *scene, const struct environment_table *environment,
                  struct lights *lights, struct fewray_error *error) {
    *lights = (struct lights){0};
    size_t n = count_light_triangles(scene);
    lights->triangles = calloc(n + 1, sizeof(*lights->triangles));
    lights->cdf = malloc((n + 2) * sizeof(float));
    lights->first_triangle = malloc(((size_t)scene->mesh_count + 1) * sizeof(uint32_t));
    float *power = malloc((n + 1) * sizeof(float));
    if (!lights->triangles || !lights->cdf || !lights->first_triangle || !power) {
        free(power);
        lights_clear(lights);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                           "no memory for %zu emitting triangles", n);
    }
    for (int m = 0; m < scene->mesh_count; m++) {
        lights->first_triangle[m] = UINT32_MAX;
        if (scene->meshes[m].emissive)
            add_mesh(scene, (uint32_t)m, lights, power);
    }
    double radius = scene->environment.kind != ENVIRONMENT_NONE ? scene_radius(scene) : 0;
    double triangle_power = 0;
    for (size_t i = 0; i < n; i++)
        triangle_power += power[i];
    /* A huge ground plane must not starve the lamps: the environment gets at most what the lamps
     * get together. */
    double sky = environment->power_density * 4 * PI_F * PI_F * radius * radius;
    power[n] = (float)(triangle_power > 0 && sky > triangle_power ? triangle_power : sky);
    double total = cdf_build(power, n + 1, lights->cdf);
    for (size_t i = 0; i < n && total > 0; i++) {
        float area =
            triangle_area(&scene->meshes[lights->triangles[i].mesh], lights->triangles[i].triangle);
        lights->triangles[i].pdf_area = area > 0 ? (float)(power[i] / total / area) : 0;
    }
    lights->environment_chance = total > 0 ? (float)(power[n] / total) : 0;
    free(power);
    return FEWRAY_OK;
}

void lights_clear(struct lights *lights) {
    free(lights->triangles);
    free(lights->cdf);
    free(lights->first_triangle);
    *lights = (struct lights){0};
}

static struct light_sample sample_environment(const struct fewray_world *world, const float u[2]) {
    struct light_sample s = {.distant = true};
    s.direction = environment_sample(&world->environment, u, &s.pdf);
    s.pdf *= world->lights.environment_chance;
    return s;
}

/* Shading normal of a light's surface at barycentric (b1, b2); area lights shine to its side. */
static struct vec3 light_normal(const struct mesh *mesh, uint32_t triangle, float b1, float b2,
                                struct vec3 geometric) {
    if (!mesh->normals)
        return geometric;
    const uint32_t *c = mesh->indices + 3 * (size_t)triangle;
    const float *n0 = mesh->normals + 3 * (size_t)c[0], *n1 = mesh->normals + 3 * (size_t)c[1],
                *n2 = mesh->normals + 3 * (size_t)c[2];
    float b0 = 1 - b1 - b2;
    return vec(b0 * n0[0] + b1 * n1[0] + b2 * n2[0], b0 * n0[1] + b1 * n1[1] + b2 * n2[1],
               b0 * n0[2] + b1 * n1[2] + b2 * n2[2]);
}

struct light_sample lights_sample(const struct fewray_world *world, struct vec3 from, float pick,
                                  const float u[2]) {
    const struct lights *lights = &world->lights;
    size_t i = cdf_sample(lights->cdf, lights->triangle_count + 1, &pick);
    if (i == lights->triangle_count)
        return sample_environment(world, u);
    const struct light_triangle *light = &lights->triangles[i];
    const struct mesh *mesh = &world->scene->meshes[light->mesh];
    /* Uniform over the triangle: Turk 1990. */
    float root = sqrtf(u[0]), b1 = 1 - root, b2 = u[1] * root;
    struct vec3 p0 = corner(mesh, light->triangle, 0);
    struct vec3 e1 = sub(corner(mesh, light->triangle, 1), p0),
                e2 = sub(corner(mesh, light->triangle, 2), p0);
    struct light_sample s = {.position = add(p0, add(scale(e1, b1), scale(e2, b2)))};
    struct vec3 to = sub(s.position, from), normal = cross(e1, e2);
    float distance2 = dot(to, to), area2 = length(normal);
    if (!(distance2 > 0) || !(area2 > 0))
        return s;
    s.direction = scale(to, 1 / sqrtf(distance2));
    normal = scale(normal, 1 / area2);
    if (dot(light_normal(mesh, light->triangle, b1, b2, normal), s.direction) >= 0)
        return s;
    float cos_light = fabsf(dot(normal, s.direction));
    if (cos_light > 0) {
        s.pdf = light->pdf_area * distance2 / cos_light;
        s.radiance = mesh->radiance;
    }
    return s;
}

float lights_pdf_hit(const struct fewray_world *world, struct vec3 direction,
                     const struct surface *hit) {
    if (!hit->mesh->emissive)
        return 0;
    uint32_t i = world->lights.first_triangle[hit->mesh_index] + hit->triangle;
    float cos_light = fabsf(dot(hit->geometric_normal, direction));
    if (!(cos_light > 0))
        return 0;
    return world->lights.triangles[i].pdf_area * hit->distance * hit->distance / cos_light;
}

float lights_pdf_environment(const struct fewray_world *world, struct vec3 direction) {
    return environment_pdf(&world->environment, direction) * world->lights.environment_chance;
}
