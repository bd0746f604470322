/* SPDX-License-Identifier: Apache-2.0 */
/* What a bundle's rays hit: vertices on diffuse triangles, and what shines there. */

#include "guide/trace/bundle_state.inc.h"

static bool is_hit(const struct bundle *b, int i) {
    return b->rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
}

static void lane_surface(const struct bundle *b, int i, struct surface *surface) {
    const struct RTCHit16 *h = &b->rays.hit;
    struct RTCHit hit = {.Ng_x = h->Ng_x[i],
                         .Ng_y = h->Ng_y[i],
                         .Ng_z = h->Ng_z[i],
                         .u = h->u[i],
                         .v = h->v[i],
                         .primID = h->primID[i],
                         .geomID = h->geomID[i],
                         .instID = {h->instID[0][i]}};
    surface_at_hit(b->in->world, &hit, b->rays.ray.tfar[i], surface);
}

/* The texture of the reflectance that a material has on one side; -1: black; -2: it is more than
 * a diffuse one. */
static int diffuse_side(const struct fewray_scene *scene, int index, bool behind) {
    const struct bsdf *bsdf = &scene->bsdfs[index];
    if (bsdf->kind == BSDF_TWOSIDED) {
        bsdf = &scene->bsdfs[bsdf->nested[behind && bsdf->nested[1] >= 0]];
        behind = false;
    }
    if (bsdf->kind != BSDF_DIFFUSE)
        return -2;
    return behind ? -1 : bsdf->reflectance;
}

/* Whether a lane's hit can be shaded with the others. */
static bool is_plain(const struct bundle *b, int i) {
    const struct fewray_scene *scene = b->in->world->scene;
    if (b->rays.hit.instID[0][i] != RTC_INVALID_GEOMETRY_ID)
        return false;
    const struct mesh *mesh = &scene->meshes[b->rays.hit.geomID[i]];
    return mesh->kind == MESH_TRIANGLES && diffuse_side(scene, mesh->bsdf, false) > -2 &&
           diffuse_side(scene, mesh->bsdf, true) > -2;
}

/* The corners of the triangles that were hit. */
struct corners {
    struct vec3_lanes position[3], normal[3]; /* normal: 0 where the mesh has none */
};

static void fetch_corners(const struct bundle *b, struct corners *c) {
    const struct fewray_scene *scene = b->in->world->scene;
    for (int i = 0; i < LANES; i++) {
        if (!b->alive[i])
            continue;
        const struct mesh *mesh = &scene->meshes[b->rays.hit.geomID[i]];
        const uint32_t *corner = mesh->indices + 3 * (size_t)b->rays.hit.primID[i];
        for (int k = 0; k < 3; k++) {
            const float *p = mesh->positions + 3 * (size_t)corner[k];
            lane_set(&c->position[k], i, vec(p[0], p[1], p[2]));
            const float *n = mesh->normals ? mesh->normals + 3 * (size_t)corner[k] : NULL;
            lane_set(&c->normal[k], i, n ? vec(n[0], n[1], n[2]) : vec(0, 0, 0));
        }
    }
}

static inline struct vec3 blend(const struct vec3_lanes corner[3], int i, float u, float v) {
    return add(scale(lane_get(&corner[0], i), 1 - u - v),
               add(scale(lane_get(&corner[1], i), u), scale(lane_get(&corner[2], i), v)));
}

/* As fill_triangle() of surface.c does it; behind: the shading normal looks away from the viewer.
 */
static void find_vertices(const struct bundle *b, struct vertices *out, int behind[LANES]) {
    struct corners c = {.position[0].x[0] = 0};
    fetch_corners(b, &c);
    EACH_LANE(i) {
        float u = b->rays.hit.u[i], v = b->rays.hit.v[i];
        struct vec3 p0 = lane_get(&c.position[0], i), p1 = lane_get(&c.position[1], i),
                    p2 = lane_get(&c.position[2], i);
        struct vec3 geometric = normalize(cross(sub(p1, p0), sub(p2, p0)));
        struct vec3 n = blend(c.normal, i, u, v);
        float l = length(n), inverse = l > 0 ? 1 / l : 0;
        n = vec(l > 0 ? n.x * inverse : geometric.x, l > 0 ? n.y * inverse : geometric.y,
                l > 0 ? n.z * inverse : geometric.z);
        float facing = -dot(n, ray_direction(b, i));
        behind[i] = facing <= 0;
        lane_set(&out->position, i, blend(c.position, i, u, v));
        lane_set(&out->geometric_normal, i, geometric);
        lane_set(&out->normal, i, scale(n, facing < 0 ? -1 : 1));
    }
}

static void find_reflectance(const struct bundle *b, const int behind[LANES],
                             struct vec3_lanes *reflectance) {
    const struct fewray_scene *scene = b->in->world->scene;
    for (int i = 0; i < LANES; i++) {
        struct vec3 c = vec(0, 0, 0);
        const struct mesh *mesh = b->alive[i] ? &scene->meshes[b->rays.hit.geomID[i]] : NULL;
        int side = mesh ? diffuse_side(scene, mesh->bsdf, behind[i]) : -1;
        const struct texture *texture = side >= 0 ? &scene->textures[side] : NULL;
        if (texture && texture->kind == TEXTURE_CONSTANT) {
            c = texture->color0;
        } else if (texture) {
            float uv[2];
            triangle_uv(mesh, b->rays.hit.primID[i], b->rays.hit.u[i], b->rays.hit.v[i], uv);
            c = texture_value(texture, uv[0], uv[1]);
        }
        lane_set(reflectance, i, clamp_color(c));
    }
}

/* --- light that a ray's end sends back by itself */

static inline void lane_add(struct vec3_lanes *sum, int i, struct vec3 a) {
    lane_set(sum, i, add(lane_get(sum, i), a));
}

/* Light that the bounce from vertex `depth` meets at its end. light_pdf: with which
 * next-event estimation would have drawn that end. */
static void add_emission(struct bundle *b, int i, int depth, struct vec3 e, float light_pdf) {
    if (depth == 0) {
        lane_set(&b->emission, i, e);
        b->light_pdf[i] = light_pdf;
        return;
    }
    float light = b->light_chance[i] * light_pdf;
    struct vec3 arriving =
        mul(lane_get(&b->throughput, i), scale(e, power_heuristic(b->pdf[i], light)));
    lane_add(&b->reflected, i, arriving);
    if (depth > 1)
        lane_add(&b->beyond, i, arriving);
    else if (b->starts[i].second)
        b->starts[i].second->bounce_value = mean_component(e) / (light + b->pdf[i]);
}

/* What the bounce from vertex `depth` finds shining at its end. */
static void find_emission(struct bundle *b, int i, const struct vertices *from, int depth) {
    const struct fewray_world *world = b->in->world;
    struct vec3 direction = ray_direction(b, i), e;
    float light = 0;
    if (!is_hit(b, i)) {
        e = lights_sky_and_pdf(world, direction, &light);
    } else if (world->scene->meshes[b->rays.hit.geomID[i]].emission >= 0) {
        struct surface surface;
        lane_surface(b, i, &surface);
        e = lights_emitted(world, &surface, direction);
        if (!is_black(e))
            light = lights_pdf_hit(world, lane_get(&from->position, i), lane_get(&from->normal, i),
                                   direction, &surface);
    } else {
        return;
    }
    if (!is_black(e))
        add_emission(b, i, depth, e, light);
}
