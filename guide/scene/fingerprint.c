/* SPDX-License-Identifier: Apache-2.0 */
/* One number that tells whether two loaded scenes are the same. Not for use against malice. */

#include <string.h>

#include "guide/scene/scene.h"

/* A word at a time: a round of Steele, Lea, Flood 2014, "Fast splittable pseudorandom number
 * generators", after each. Bytes of structs alone would take in their padding. */
static uint64_t add_bytes(uint64_t h, const void *data, size_t size) {
    const char *bytes = data;
    for (size_t i = 0; i < size; i += sizeof(h)) {
        uint64_t word = 0;
        memcpy(&word, bytes + i, size - i < sizeof(word) ? size - i : sizeof(word));
        h = (h ^ word) * 0xbf58476d1ce4e5b9u;
        h ^= h >> 29;
    }
    return h ^ size;
}

#define ADD(h, value) add_bytes(h, &(value), sizeof(value))

static uint64_t add_optional(uint64_t h, const void *data, size_t size) {
    return data ? add_bytes(h, data, size) : ~h;
}

static uint64_t add_image(uint64_t h, const struct fewray_image *image) {
    size_t values = (size_t)image->width * (size_t)image->height * (size_t)image->channels;
    h = ADD(h, image->width);
    h = ADD(h, image->channels);
    h = add_optional(h, image->bytes, values);
    return add_optional(h, image->floats, values * sizeof(float));
}

static uint64_t add_texture(uint64_t h, const struct texture *t) {
    const int numbers[] = {(int)t->kind, (int)t->wrap, t->channel, t->nearest, t->srgb};
    h = ADD(h, numbers);
    h = ADD(h, t->color0);
    h = ADD(h, t->color1);
    h = ADD(h, t->factor);
    h = ADD(h, t->to_uv);
    return t->image ? add_image(h, t->image) : ~h;
}

static uint64_t add_bsdf(uint64_t h, const struct bsdf *b) {
    const int numbers[] = {(int)b->kind,
                           b->nested[0],
                           b->nested[1],
                           b->weight,
                           b->reflectance,
                           b->specular_reflectance,
                           b->specular_transmittance,
                           b->alpha_u,
                           b->alpha_v,
                           (int)b->microfacets,
                           b->nonlinear,
                           b->flip_invalid_normals,
                           b->use_shadowing_function};
    h = ADD(h, numbers);
    h = ADD(h, b->principled);
    h = ADD(h, b->eta);
    h = ADD(h, b->conductor_eta);
    h = ADD(h, b->conductor_k);
    return ADD(h, b->bump_scale);
}

static uint64_t add_mesh(uint64_t h, const struct mesh *m) {
    const int numbers[] = {(int)m->kind, m->flip_normals, m->group, m->bsdf, m->emission};
    size_t vertices = m->vertex_count;
    h = ADD(h, numbers);
    h = ADD(h, m->sphere);
    h = ADD(h, m->sphere_axes);
    h = add_optional(h, m->positions, 3 * vertices * sizeof(float));
    h = add_optional(h, m->normals, 3 * vertices * sizeof(float));
    h = add_optional(h, m->uvs, 2 * vertices * sizeof(float));
    return add_optional(h, m->indices, 3 * (size_t)m->triangle_count * sizeof(uint32_t));
}

static uint64_t add_light(uint64_t h, const struct light *l) {
    const float numbers[] = {(float)l->kind, l->cutoff, l->beam_width};
    h = ADD(h, numbers);
    h = ADD(h, l->position);
    h = ADD(h, l->direction);
    return ADD(h, l->intensity);
}

static uint64_t add_environment(uint64_t h, const struct environment *e) {
    h = ADD(h, e->kind);
    h = ADD(h, e->radiance);
    h = ADD(h, e->scale);
    h = ADD(h, e->to_local);
    return e->image ? add_image(h, e->image) : ~h;
}

uint64_t fewray_scene_fingerprint(const struct fewray_scene *scene) {
    const int numbers[] = {scene->max_depth,     scene->rr_depth,   scene->texture_count,
                           scene->bsdf_count,    scene->mesh_count, scene->light_count,
                           scene->instance_count};
    const struct camera *camera = &scene->camera;
    const float optics[] = {camera->fov_x, camera->principal_x, camera->principal_y,
                            camera->aperture_radius, camera->focus_distance};
    const int film[] = {camera->width, camera->height};
    uint64_t h = ADD(0, numbers);
    h = ADD(h, camera->to_world);
    h = ADD(h, optics);
    h = ADD(h, film);
    for (int i = 0; i < scene->texture_count; i++)
        h = add_texture(h, &scene->textures[i]);
    for (int i = 0; i < scene->bsdf_count; i++)
        h = add_bsdf(h, &scene->bsdfs[i]);
    for (int i = 0; i < scene->mesh_count; i++)
        h = add_mesh(h, &scene->meshes[i]);
    for (int i = 0; i < scene->light_count; i++)
        h = add_light(h, &scene->lights[i]);
    for (int i = 0; i < scene->instance_count; i++) {
        h = ADD(h, scene->instances[i].group);
        h = ADD(h, scene->instances[i].to_world);
    }
    return add_environment(h, &scene->environment);
}
