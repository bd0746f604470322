/* SPDX-License-Identifier: Apache-2.0 */
/* Sampling of a single light within the scene. */

#include "guide/light/light_source.h"

#include "guide/basis.h"
#include "guide/trace/sphere.h"
#include "guide/trace/texture.h"

static struct vec3 corner(const struct mesh *mesh, uint32_t triangle, int i) {
    const float *p = mesh->positions + 3 * (size_t)mesh->indices[3 * (size_t)triangle + (size_t)i];
    return vec(p[0], p[1], p[2]);
}

/* Shading normal of a light's surface at barycentric (b1, b2); area lights shine to its side. */
static struct vec3 shading_normal(const struct mesh *mesh, uint32_t triangle, float b1, float b2,
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

static struct vec3 triangle_radiance(const struct fewray_scene *scene, const struct mesh *mesh,
                                     uint32_t triangle, float b1, float b2) {
    const struct texture *texture = &scene->textures[mesh->emission];
    if (texture->kind == TEXTURE_CONSTANT)
        return texture->color0;
    if (!mesh->uvs)
        return texture_value(texture, b1, b2);
    const uint32_t *c = mesh->indices + 3 * (size_t)triangle;
    const float *t0 = mesh->uvs + 2 * (size_t)c[0], *t1 = mesh->uvs + 2 * (size_t)c[1],
                *t2 = mesh->uvs + 2 * (size_t)c[2];
    float b0 = 1 - b1 - b2;
    return texture_value(texture, b0 * t0[0] + b1 * t1[0] + b2 * t2[0],
                         b0 * t0[1] + b1 * t1[1] + b2 * t2[1]);
}

/* outward: unit, from the centre. */
static struct vec3 sphere_radiance(const struct fewray_scene *scene, const struct mesh *mesh,
                                   struct vec3 outward) {
    const struct texture *texture = &scene->textures[mesh->emission];
    if (texture->kind == TEXTURE_CONSTANT)
        return texture->color0;
    float u, v;
    sphere_uv(mesh, outward, &u, &v);
    return texture_value(texture, u, v);
}

/* --- what a source is worth */

float texture_mean_luminance(const struct texture *texture) {
    if (texture->kind == TEXTURE_CONSTANT)
        return luminance(texture->color0);
    if (texture->kind == TEXTURE_CHECKERBOARD)
        return 0.5f * (luminance(texture->color0) + luminance(texture->color1));
    struct texture plain = *texture;
    static const float identity[6] = {1, 0, 0, 0, 1, 0};
    for (int i = 0; i < 6; i++)
        plain.to_uv[i] = identity[i];
    plain.nearest = true;
    int w = texture->image->width, h = texture->image->height;
    double sum = 0;
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++)
            sum += luminance(
                texture_value(&plain, ((float)x + 0.5f) / (float)w, ((float)y + 0.5f) / (float)h));
    return (float)(sum / ((double)w * (double)h));
}

/* Mean luminance of a triangle: where the samples see only dark parts of a texture its mean
 * keeps a tenth of the say, so that no bright spot is lost. */
static float triangle_luminance(const struct fewray_scene *scene, const struct mesh *mesh,
                                uint32_t triangle, float mean) {
    if (scene->textures[mesh->emission].kind == TEXTURE_CONSTANT)
        return mean;
    /* As many samples as a mesh of few triangles can afford. */
    int steps = (int)fminf(fmaxf(sqrtf(1e5f / (float)mesh->triangle_count), 4), 64);
    float sum = 0;
    for (int j = 0; j < steps; j++)
        for (int i = 0; i < steps; i++) {
            float root = sqrtf(((float)i + 0.5f) / (float)steps);
            float v = ((float)j + 0.5f) / (float)steps;
            sum += luminance(triangle_radiance(scene, mesh, triangle, 1 - root, v * root));
        }
    return 0.9f * sum / (float)(steps * steps) + 0.1f * mean;
}

double source_area(const struct fewray_scene *scene, const struct light_source *source) {
    if (source->kind > SOURCE_SPHERE)
        return 0;
    const struct mesh *mesh = &scene->meshes[source->index];
    if (source->kind == SOURCE_SPHERE)
        return 4 * PI_F * mesh->sphere[3] * mesh->sphere[3];
    struct vec3 p0 = corner(mesh, source->triangle, 0);
    return 0.5f * length(cross(sub(corner(mesh, source->triangle, 1), p0),
                               sub(corner(mesh, source->triangle, 2), p0)));
}

/* A cone around the directions to whose side a triangle shines. */
static void triangle_cone(const struct mesh *mesh, uint32_t triangle, struct light_bounds *b) {
    struct vec3 p0 = corner(mesh, triangle, 0);
    b->axis =
        normalize(cross(sub(corner(mesh, triangle, 1), p0), sub(corner(mesh, triangle, 2), p0)));
    b->theta_o = 0;
    if (!mesh->normals)
        return;
    struct vec3 n[3];
    for (int i = 0; i < 3; i++)
        n[i] = normalize(
            shading_normal(mesh, triangle, (float)(i == 1), (float)(i == 2), vec(0, 0, 0)));
    struct vec3 mean = normalize(add(n[0], add(n[1], n[2])));
    float cosine = fminf(dot(mean, n[0]), fminf(dot(mean, n[1]), dot(mean, n[2])));
    /* What lies between normals that are less than a quarter turn from the axis is so, too. */
    b->theta_o = cosine > 1e-3f ? acosf(fminf(cosine, 1)) + 1e-3f : PI_F;
    b->axis = cosine > 1e-3f ? mean : vec(0, 0, 1);
}

static struct light_bounds triangle_bounds(const struct fewray_scene *scene,
                                           const struct light_source *source, float mean,
                                           float *flux) {
    const struct mesh *mesh = &scene->meshes[source->index];
    struct light_bounds b = light_bounds_none();
    for (int i = 0; i < 3; i++) {
        struct vec3 p = corner(mesh, source->triangle, i);
        b.low = vec(fminf(b.low.x, p.x), fminf(b.low.y, p.y), fminf(b.low.z, p.z));
        b.high = vec(fmaxf(b.high.x, p.x), fmaxf(b.high.y, p.y), fmaxf(b.high.z, p.z));
    }
    triangle_cone(mesh, source->triangle, &b);
    b.theta_e = 0.5f * PI_F;
    b.phi =
        (float)source_area(scene, source) * triangle_luminance(scene, mesh, source->triangle, mean);
    *flux = b.phi * PI_F;
    return b;
}

struct light_bounds source_bounds(const struct fewray_scene *scene,
                                  const struct light_source *source, float mean, float *flux) {
    if (source->kind == SOURCE_TRIANGLE)
        return triangle_bounds(scene, source, mean, flux);
    struct light_bounds b = {.axis = {0, 0, 1}, .theta_o = PI_F, .theta_e = 0.5f * PI_F};
    if (source->kind == SOURCE_SPHERE) {
        const float *s = scene->meshes[source->index].sphere;
        b.low = vec(s[0] - s[3], s[1] - s[3], s[2] - s[3]);
        b.high = vec(s[0] + s[3], s[1] + s[3], s[2] + s[3]);
        b.phi = PI_F * s[3] * s[3] * mean;
        *flux = 4 * PI_F * b.phi;
        return b;
    }
    const struct light *light = &scene->lights[source->index];
    b.low = b.high = light->position;
    b.phi = luminance(light->intensity);
    *flux = 4 * PI_F * b.phi;
    if (source->kind == SOURCE_SPOT) {
        b.axis = light->direction;
        b.theta_o = light->cutoff;
        b.theta_e = 0;
        *flux = 2 * PI_F * b.phi * (1 - cosf(0.5f * (light->cutoff + light->beam_width)));
    }
    return b;
}

/* --- sampling */

static struct light_sample sample_triangle(const struct fewray_scene *scene,
                                           const struct light_source *source, struct vec3 from,
                                           const float u[2]) {
    const struct mesh *mesh = &scene->meshes[source->index];
    /* Uniform over the triangle: Turk 1990. */
    float root = sqrtf(u[0]), b1 = 1 - root, b2 = u[1] * root;
    struct vec3 p0 = corner(mesh, source->triangle, 0);
    struct vec3 e1 = sub(corner(mesh, source->triangle, 1), p0),
                e2 = sub(corner(mesh, source->triangle, 2), p0);
    struct light_sample s = {.position = add(p0, add(scale(e1, b1), scale(e2, b2)))};
    struct vec3 to = sub(s.position, from), facing = cross(e1, e2);
    float distance2 = dot(to, to), area2 = length(facing);
    if (!(distance2 > 0) || !(area2 > 0))
        return s;
    s.direction = scale(to, 1 / sqrtf(distance2));
    facing = scale(facing, 1 / area2);
    if (dot(shading_normal(mesh, source->triangle, b1, b2, facing), s.direction) >= 0)
        return s;
    float cos_light = fabsf(dot(facing, s.direction));
    if (cos_light > 0) {
        s.pdf = source->pdf_area * distance2 / cos_light;
        s.radiance = triangle_radiance(scene, mesh, source->triangle, b1, b2);
    }
    return s;
}

/* 1 - cos(theta) of the cone that a sphere fills as seen from a distance; above 1 from inside, or
 * from so near that the cone is a half space but for rounding. sin2 = (radius / distance)^2. */
static float sphere_cone(float sin2) {
    return sin2 < 0.9999f ? sin2 / (1 + sqrtf(1 - sin2)) : 2;
}

/* Uniform over the cone of the visible part. */
static struct light_sample sample_sphere_cone(const struct mesh *mesh, struct vec3 centre,
                                              float distance2, const float u[2]) {
    float radius = mesh->sphere[3], distance = sqrtf(distance2);
    float sin2_max = radius * radius / distance2, cone = sphere_cone(sin2_max);
    float below = u[0] * cone, sin2 = below * (2 - below);
    struct basis basis = basis_around(scale(centre, 1 / distance));
    struct light_sample s = {.pdf = 1 / (2 * PI_F * cone)};
    s.direction = normalize(to_world(&basis, uniform_cone(cone, u)));
    float t = distance * (1 - below) - radius * sqrtf(fmaxf(0, 1 - fminf(1, sin2 / sin2_max)));
    s.position = scale(s.direction, t);
    return s;
}

/* Uniform over the area. */
static struct light_sample sample_sphere_area(const struct mesh *mesh, struct vec3 centre,
                                              float pdf_area, const float u[2]) {
    struct vec3 outward = uniform_sphere(u);
    struct light_sample s = {.position = add(centre, scale(outward, mesh->sphere[3]))};
    float distance2 = dot(s.position, s.position);
    s.direction = normalize(s.position);
    float cosine = fabsf(dot(outward, s.direction));
    s.pdf = cosine > 0 ? pdf_area * distance2 / cosine : 0;
    return s;
}

static struct light_sample sample_sphere(const struct fewray_scene *scene,
                                         const struct light_source *source, struct vec3 from,
                                         const float u[2]) {
    const struct mesh *mesh = &scene->meshes[source->index];
    const float *sphere = mesh->sphere;
    struct vec3 centre = sub(vec(sphere[0], sphere[1], sphere[2]), from);
    float distance2 = dot(centre, centre);
    bool outside = sphere_cone(sphere[3] * sphere[3] / distance2) <= 1;
    struct light_sample s = outside ? sample_sphere_cone(mesh, centre, distance2, u)
                                    : sample_sphere_area(mesh, centre, source->pdf_area, u);
    struct vec3 outward = normalize(sub(s.position, centre));
    s.position = add(s.position, from);
    if ((dot(outward, s.direction) < 0) == mesh->flip_normals)
        s.pdf = 0;
    if (s.pdf > 0)
        s.radiance = sphere_radiance(scene, mesh, outward);
    return s;
}

/* Mitsuba's spot: whole within beam_width, then falling linearly in the angle. */
static float spot_falloff(const struct light *light, struct vec3 away) {
    float angle = angle_between(away, light->direction);
    if (angle >= light->cutoff)
        return 0;
    if (angle <= light->beam_width)
        return 1;
    return (light->cutoff - angle) / (light->cutoff - light->beam_width);
}

static struct light_sample sample_point(const struct light *light, struct vec3 from) {
    struct light_sample s = {.position = light->position, .delta = true};
    struct vec3 to = sub(light->position, from);
    float distance2 = dot(to, to);
    if (!(distance2 > 0))
        return s;
    s.direction = normalize(to);
    float falloff = light->kind == LIGHT_SPOT ? spot_falloff(light, negate(s.direction)) : 1;
    s.radiance = scale(light->intensity, falloff / distance2);
    s.pdf = falloff > 0 && isfinite(1 / distance2) ? 1 : 0;
    return s;
}

struct light_sample source_sample(const struct fewray_scene *scene,
                                  const struct light_source *source, struct vec3 from,
                                  const float u[2]) {
    if (source->kind == SOURCE_TRIANGLE)
        return sample_triangle(scene, source, from, u);
    if (source->kind == SOURCE_SPHERE)
        return sample_sphere(scene, source, from, u);
    return sample_point(&scene->lights[source->index], from);
}

float source_pdf(const struct light_source *source, struct vec3 from, struct vec3 direction,
                 const struct surface *hit) {
    if (source->kind == SOURCE_SPHERE) {
        const float *sphere = hit->mesh->sphere;
        struct vec3 centre = sub(vec(sphere[0], sphere[1], sphere[2]), from);
        float cone = sphere_cone(sphere[3] * sphere[3] / dot(centre, centre));
        if (cone <= 1)
            return 1 / (2 * PI_F * cone);
    }
    float cos_light = fabsf(dot(hit->geometric_normal, direction));
    return cos_light > 0 ? source->pdf_area * hit->distance * hit->distance / cos_light : 0;
}
