/* SPDX-License-Identifier: Apache-2.0 */
/* Bundles of paths, compiled once for each instruction set; BUNDLE_NAME is the table it fills. */

#include "guide/bsdf/bsdf.h"
#include "guide/trace/bundle_lights.inc.h"
#include "guide/trace/camera.h"
#include "guide/trace/direct_light.h"
#include "guide/trace/texture.h"

/* A vertex of each path. */
struct vertices {
    struct vec3_lanes position, geometric_normal, normal; /* normal: for shading, towards the
                                                             viewer */
    struct vec3_lanes reflectance;                        /* on the viewer's side */
};

struct bundle {
    const struct integrator *in;
    const struct bundle_start *starts;
    struct path_sample *samples;
    int count;
    bool look;  /* the paths are a first look's */
    bool noted; /* what the bounces see is remembered */
    struct RTCRayHit16 rays LANES_ALIGNMENT;
    int alive[LANES] LANES_ALIGNMENT; /* -1, or 0: as Embree wants it */
    uint32_t seed[LANES] LANES_ALIGNMENT, index[LANES], dimension[LANES];
    struct vertices vertices[2];      /* the present one and the one before, in turns */
    struct vec3_lanes first;          /* weight of the bounce from the first vertex */
    struct vec3_lanes throughput;     /* of the bounces after it */
    struct vec3_lanes direct;         /* next-event estimation at the first vertex, */
    struct vec3_lanes irradiance;     /* and over pi what a white surface would reflect of it */
    struct vec3_lanes emission;       /* of the first bounce's end, */
    float light_pdf[LANES];           /* and with which next-event estimation draws that point */
    struct vec3_lanes reflected;      /* what that end reflects */
    struct vec3_lanes beyond;         /* of that what came by way of its own bounce and didn't shine
                                         itself */
    struct vec3_lanes direction;      /* of the bounce */
    float pdf[LANES] LANES_ALIGNMENT; /* of the bounce (solid angle) */
    float light_chance[LANES] LANES_ALIGNMENT; /* of the shadow ray where it started */
    float first_pdf[LANES];                    /* of the first vertex's */
    float bounce_weight[LANES];                /* of the second vertex's, times its density */
    int rays_traced[LANES];
    struct proposal proposals[LANES]; /* with guides only */
};

static bool may_scatter(const struct integrator *in, int depth) {
    return in->max_depth < 0 || depth + 1 < in->max_depth;
}

static bool any_alive(const struct bundle *b) {
    int any = 0;
    EACH_LANE(i)
    any |= b->alive[i];
    return any != 0;
}

static struct vec3 ray_direction(const struct bundle *b, int i) {
    return vec(b->rays.ray.dir_x[i], b->rays.ray.dir_y[i], b->rays.ray.dir_z[i]);
}

static struct sampler lane_sampler(const struct bundle *b, int i) {
    return (struct sampler){b->seed[i], b->index[i], b->dimension[i]};
}

static void start(struct bundle *b, const struct integrator *in, int count,
                  const struct bundle_start *starts, struct path_sample *samples) {
    b->in = in;
    b->starts = starts;
    b->samples = samples;
    b->count = count;
    b->look = false;
    b->noted = starts[0].record != NULL;
    EACH_LANE(i) {
        const struct sampler *s = &starts[i < count ? i : 0].sampler;
        b->seed[i] = s->seed;
        b->index[i] = s->index;
        b->dimension[i] = s->dimension;
        b->alive[i] = i < count ? -1 : 0;
        lane_set(&b->throughput, i, vec(1, 1, 1));
        lane_set(&b->first, i, vec(0, 0, 0));
        lane_set(&b->direct, i, vec(0, 0, 0));
        lane_set(&b->irradiance, i, vec(0, 0, 0));
        lane_set(&b->emission, i, vec(0, 0, 0));
        lane_set(&b->reflected, i, vec(0, 0, 0));
        lane_set(&b->beyond, i, vec(0, 0, 0));
        b->light_pdf[i] = 0;
        b->light_chance[i] = b->first_pdf[i] = 1;
        b->bounce_weight[i] = 0;
        b->rays_traced[i] = 0;
    }
    for (int i = 0; i < count; i++)
        samples[i] = (struct path_sample){.rays = 0};
}

/* --- rays */

static void set_ray(struct RTCRay16 *ray, int i, struct vec3 origin, struct vec3 direction,
                    float far) {
    ray->org_x[i] = origin.x;
    ray->org_y[i] = origin.y;
    ray->org_z[i] = origin.z;
    ray->dir_x[i] = direction.x;
    ray->dir_y[i] = direction.y;
    ray->dir_z[i] = direction.z;
    ray->tnear[i] = 0;
    ray->tfar[i] = far;
    ray->mask[i] = ~0u;
    ray->flags[i] = 0;
    ray->time[i] = 0;
}

static void camera_rays(struct bundle *b, const float x[LANES], const float y[LANES]) {
    const struct camera *camera = &b->in->world->scene->camera;
    float lens[2][LANES] = {{0}};
    if (camera->aperture_radius > 0)
        lanes_2d(b->seed, b->index, b->dimension, lens);
    const struct camera_view view = camera_view(camera, b->in->width, b->in->height);
    EACH_LANE(i) {
        struct vec3 origin, direction;
        const float point[2] = {lens[0][i], lens[1][i]};
        camera_view_ray(&view, x[i], y[i], point, &origin, &direction);
        set_ray(&b->rays.ray, i, origin, direction, INFINITY);
    }
}

/* Rays that leave the present vertices along the bounces. */
static void bounce_rays(struct bundle *b, const struct vertices *v) {
    EACH_LANE(i) {
        struct vec3 d = lane_get(&b->direction, i);
        set_ray(&b->rays.ray, i,
                offset_origin(lane_get(&v->position, i), lane_get(&v->geometric_normal, i), d), d,
                INFINITY);
    }
}

static void trace(struct bundle *b, bool coherent) {
    embree_intersect16(b->in->world->embree, b->alive, &b->rays, coherent);
    EACH_LANE(i)
    b->rays_traced[i] -= b->alive[i];
}

/* Rays that can only find lights: what they hit stays in b->rays, and the lanes where something
 * dark is in the way die. */
static void trace_lights(struct bundle *b) {
    struct RTCRay16 way = b->rays.ray;
    int wanted[LANES] LANES_ALIGNMENT;
    embree_intersect16(b->in->world->emitters, b->alive, &b->rays, false);
    EACH_LANE(i) {
        bool hit = b->rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        way.tfar[i] = hit ? b->rays.ray.tfar[i] * LIGHT_REACH : INFINITY;
        wanted[i] = hit || b->in->world->lights.has_sky ? b->alive[i] : 0;
    }
    embree_occluded16(b->in->world->embree, wanted, &way);
    EACH_LANE(i) {
        b->rays_traced[i] -= b->alive[i];
        b->alive[i] = wanted[i] && !(way.tfar[i] < 0) ? -1 : 0;
    }
}

/* --- what rays hit */

static bool is_hit(const struct bundle *b, int i) {
    return b->rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
}

static void lane_surface(const struct bundle *b, int i, struct surface *surface) {
    const struct RTCHit16 *h = &b->rays.hit;
    struct RTCHit hit = {h->Ng_x[i], h->Ng_y[i],   h->Ng_z[i],   h->u[i],
                         h->v[i],    h->primID[i], h->geomID[i], {h->instID[0][i]}};
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
        struct vec3 geometric = cross(sub(p1, p0), sub(p2, p0));
        float l = length(geometric);
        geometric = scale(geometric, l > 0 ? 1 / l : 1);
        struct vec3 n = blend(c.normal, i, u, v);
        l = length(n);
        float inverse = l > 0 ? 1 / l : 0;
        n = vec(l > 0 ? n.x * inverse : geometric.x, l > 0 ? n.y * inverse : geometric.y,
                l > 0 ? n.z * inverse : geometric.z);
        float facing = -dot(n, ray_direction(b, i));
        behind[i] = facing <= 0;
        lane_set(&out->position, i, blend(c.position, i, u, v));
        lane_set(&out->geometric_normal, i, geometric);
        lane_set(&out->normal, i, scale(n, facing < 0 ? -1 : 1));
    }
}

static float clamp_unit(float x) {
    return x > 0 ? (x < 1 ? x : 1) : 0;
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
        lane_set(reflectance, i, vec(clamp_unit(c.x), clamp_unit(c.y), clamp_unit(c.z)));
    }
}

/* --- light that a ray's end sends back by itself */

static inline void lane_add(struct vec3_lanes *sum, int i, struct vec3 a) {
    lane_set(sum, i, add(lane_get(sum, i), a));
}

/* Light that the bounce from vertex `depth`, at `from`, meets at its end. light_pdf: with which
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

/* --- next-event estimation */

struct shadows {
    struct light_lanes lights;
    float cosine[LANES], bounce_pdf[LANES]; /* bounce_pdf: of the same direction (solid angle) */
    float chance[LANES];                    /* of tracing the ray */
    struct RTCRay16 rays;
    int wanted[LANES];
} LANES_ALIGNMENT;

/* A vertex as the guides want to see it. */
static void lane_shading(const struct vertices *v, int i, struct shading *s) {
    static const struct bsdf diffuse = {.kind = BSDF_DIFFUSE};
    s->position = lane_get(&v->position, i);
    s->geometric_normal = lane_get(&v->geometric_normal, i);
    s->normal = lane_get(&v->normal, i);
    s->albedo = lane_get(&v->reflectance, i);
    s->delta_chance = 0;
    s->breadth = 1;
    s->scatters = true;
    s->transmits = false;
    s->count = 1;
    struct bsdf_local *l = &s->locals[0];
    l->bsdf = &diffuse;
    l->weight = 1;
    l->perturbed = false;
    l->frame.n = s->normal;
    l->outgoing = vec(0, 0, 1);
    l->reflectance = s->albedo;
    l->delta_chance = 0;
    l->breadth = 1;
    l->albedo = s->albedo;
}

static bool has_guides(const struct guides *guides) {
    return guides->maps || guides->probes || guides->ppg;
}

/* What guides each path at its vertex. */
static void find_proposals(struct bundle *b, const struct vertices *v, int depth) {
    const struct guides *guides = &b->in->guides;
    if (!has_guides(guides))
        return;
    for (int i = 0; i < LANES; i++) {
        if (!b->alive[i])
            continue;
        struct shading s;
        lane_shading(v, i, &s);
        const struct path_place first = {b->starts[i].x, b->starts[i].y, .first = true},
                                later = {.last = !may_scatter(b->in, depth + 1)};
        b->proposals[i] = proposal_at(guides, depth ? later : first, &s);
        b->light_chance[i] = b->proposals[i].light_chance;
        if (depth == 0)
            b->samples[i].guided = b->proposals[i].bsdf_fraction < 1;
    }
}

/* Shadow rays to the lights that were picked, where they can be of use. */
static void aim(const struct vertices *v, const struct light_lanes *lights, const int alive[LANES],
                struct shadows *out) {
    EACH_LANE(i) {
        struct vec3 p = lane_get(&v->position, i), g = lane_get(&v->geometric_normal, i);
        struct vec3 d = lane_get(&lights->direction, i), q = lane_get(&lights->position, i);
        bool distant = lights->distant[i];
        struct vec3 to =
            vec(distant ? d.x : q.x - p.x, distant ? d.y : q.y - p.y, distant ? d.z : q.z - p.z);
        struct vec3 origin = offset_origin(p, g, to);
        to = vec(distant ? d.x : q.x - origin.x, distant ? d.y : q.y - origin.y,
                 distant ? d.z : q.z - origin.z);
        set_ray(&out->rays, i, origin, to, distant ? INFINITY : SHADOW_REACH);
        float cosine = dot(lane_get(&v->normal, i), d);
        out->cosine[i] = cosine;
        out->bounce_pdf[i] = lights->delta[i] ? 0 : cosine / PI_F;
        out->chance[i] = 1;
        out->wanted[i] = cosine > 0 ? alive[i] : 0;
        out->wanted[i] = lights->pdf[i] > 0 ? out->wanted[i] : 0;
    }
}

/* Picks a point of a light for each vertex. */
static void pick_lights(struct bundle *b, const struct vertices *v, struct shadows *out) {
    float pick[2][LANES], u[2][LANES];
    lanes_2d(b->seed, b->index, b->dimension, pick);
    lanes_2d(b->seed, b->index, b->dimension, u);
    light_lanes_sample(b->in->world, b->alive, &v->position, &v->normal, pick[0], u, &out->lights);
    aim(v, &out->lights, b->alive, out);
    light_lanes_shine(b->in->world, out->wanted, &out->lights);
}

/* Where guides are: their say in the bounce's density, and Russian roulette of shadow rays. */
static void guide_lights(struct bundle *b, const struct vertices *v, struct shadows *s) {
    for (int i = 0; i < LANES; i++) {
        if (!s->wanted[i])
            continue;
        const struct proposal *p = &b->proposals[i];
        s->chance[i] = p->light_chance;
        struct sampler sampler = lane_sampler(b, i);
        if (p->light_chance < 1 && !(sampler_1d(&sampler) < p->light_chance))
            s->wanted[i] = 0;
        b->dimension[i] = sampler.dimension;
        if (!s->wanted[i] || p->bsdf_fraction >= 1 || !(s->bounce_pdf[i] > 0))
            continue;
        struct shading shading;
        lane_shading(v, i, &shading);
        s->bounce_pdf[i] = proposal_pdf(p, &shading, lane_get(&s->lights.direction, i)).mixture;
    }
}

/* What the second vertex of a look's path saw of lights. */
static void note_lights(const struct bundle *b, const struct shadows *s) {
    for (int i = 0; i < LANES; i++) {
        struct look_second *second = b->starts[i < b->count ? i : 0].second;
        if (!s->wanted[i] || !second || s->lights.delta[i])
            continue;
        bool visible = !(s->rays.tfar[i] < 0);
        second->light = lane_get(&s->lights.direction, i);
        second->light_sent = true;
        second->light_value = visible ? mean_component(lane_get(&s->lights.radiance, i)) /
                                            (s->lights.pdf[i] * s->chance[i] + s->bounce_pdf[i])
                                      : 0;
    }
}

/* Next-event estimation at the vertices `depth`. */
static void add_direct(struct bundle *b, const struct vertices *v, int depth) {
    struct shadows s;
    pick_lights(b, v, &s);
    if (has_guides(&b->in->guides))
        guide_lights(b, v, &s);
    int any = 0;
    EACH_LANE(i) {
        any |= s.wanted[i];
        /* A look's bounce doesn't come from the BSDF. */
        s.bounce_pdf[i] = b->look && depth == 0 && s.bounce_pdf[i] > 0 ? LOOK_PDF : s.bounce_pdf[i];
    }
    if (!any)
        return;
    embree_occluded16(b->in->world->embree, s.wanted, &s.rays);
    struct vec3_lanes *sum = depth == 0 ? &b->direct : &b->reflected;
    EACH_LANE(i) {
        float weight = power_heuristic(s.lights.pdf[i] * s.chance[i], s.bounce_pdf[i]) *
                       s.cosine[i] / (PI_F * s.chance[i] * s.lights.pdf[i]);
        bool visible = s.wanted[i] != 0 && !(s.rays.tfar[i] < 0);
        struct vec3 e = scale(lane_get(&s.lights.radiance, i), weight);
        e = vec(visible ? e.x : 0, visible ? e.y : 0, visible ? e.z : 0);
        struct vec3 light = mul(mul(lane_get(&b->throughput, i), lane_get(&v->reflectance, i)), e);
        lane_set(&b->irradiance, i, depth == 0 ? e : lane_get(&b->irradiance, i));
        lane_add(sum, i, light);
        lane_add(&b->beyond, i, scale(light, depth > 1));
        b->rays_traced[i] -= s.wanted[i];
    }
    if (b->noted && depth == 1)
        note_lights(b, &s);
}

/* --- the bounce */

/* Directions of the BSDF: cosine_hemisphere() about the normal. */
static void diffuse_bounces(const struct vertices *v, float u[2][LANES], struct bundle *b) {
    EACH_LANE(i) {
        float r = sqrtf(u[0][i]), sine, cosine;
        sin_cos_turns(u[1][i], &sine, &cosine);
        struct vec3 local = vec(r * cosine, r * sine, sqrtf(max_float(0, 1 - u[0][i])));
        local = scale(local, 1 / length(local));
        struct basis basis = basis_around(lane_get(&v->normal, i));
        lane_set(&b->direction, i, to_world(&basis, local));
        b->pdf[i] = local.z / PI_F;
        b->throughput.x[i] *= v->reflectance.x[i];
        b->throughput.y[i] *= v->reflectance.y[i];
        b->throughput.z[i] *= v->reflectance.z[i];
        b->alive[i] = b->pdf[i] > 0 ? b->alive[i] : 0;
    }
}

/* The directions of lanes whose proposals know more than the BSDF, `before` their bounce. */
static void guided_bounces(const struct vertices *v, const float choice[LANES], float u[2][LANES],
                           const struct vec3_lanes *before, const int alive[LANES],
                           struct bundle *b) {
    for (int i = 0; i < LANES; i++) {
        if (!alive[i] || b->proposals[i].bsdf_fraction >= 1)
            continue;
        struct shading s;
        struct bsdf_sample sample;
        struct proposal_pdf pdf;
        const float point[2] = {u[0][i], u[1][i]};
        lane_shading(v, i, &s);
        b->alive[i] = proposal_sample(&b->proposals[i], &s, choice[i], point, &sample, &pdf) &&
                              !is_black(sample.weight)
                          ? -1
                          : 0;
        if (!b->alive[i])
            continue;
        lane_set(&b->direction, i, sample.direction);
        lane_set(&b->throughput, i, mul(lane_get(before, i), sample.weight));
        b->pdf[i] = sample.pdf;
    }
}

static void draw_bounces(struct bundle *b, const struct vertices *v) {
    float choice[2][LANES], u[2][LANES];
    if (!has_guides(&b->in->guides)) {
        EACH_LANE(i)
        b->dimension[i]++;
        lanes_2d(b->seed, b->index, b->dimension, u);
        diffuse_bounces(v, u, b);
        return;
    }
    lanes_2d(b->seed, b->index, b->dimension, choice);
    lanes_2d(b->seed, b->index, b->dimension, u);
    struct vec3_lanes before = b->throughput;
    int alive[LANES];
    EACH_LANE(i)
    alive[i] = b->alive[i];
    diffuse_bounces(v, u, b);
    guided_bounces(v, choice[0], u, &before, alive, b);
}

/* A look's: uniform over the hemisphere. */
static void draw_look_bounces(struct bundle *b, const struct vertices *v) {
    for (int i = 0; i < b->count; i++) {
        if (!b->alive[i])
            continue;
        struct vec3 normal = lane_get(&v->normal, i);
        struct basis basis = basis_around(normal);
        struct vec3 d = normalize(to_world(&basis, uniform_hemisphere(b->starts[i].direction)));
        struct vec3 weight =
            scale(lane_get(&v->reflectance, i), max_float(0, dot(normal, d)) / (PI_F * LOOK_PDF));
        lane_set(&b->direction, i, d);
        lane_set(&b->throughput, i, weight);
        b->pdf[i] = LOOK_PDF;
    }
}

/* The bounces from the first vertices begin their records. */
static void begin_records(const struct bundle *b, const struct vertices *v) {
    for (int i = 0; i < b->count; i++)
        if (b->alive[i])
            *b->starts[i].record =
                (struct look_record){.position = lane_get(&v->position, i),
                                     .normal = lane_get(&v->normal, i),
                                     .depth = b->samples[i].depth,
                                     .direction = lane_get(&b->direction, i),
                                     .bin = (uint16_t)sphere_bin(lane_get(&b->direction, i))};
}

/* What the second vertex of a look's path does next. */
static void note_bounces(struct bundle *b, const struct vertices *v) {
    for (int i = 0; i < b->count; i++) {
        if (!b->alive[i])
            continue;
        b->bounce_weight[i] = mean_component(lane_get(&v->reflectance, i)) * b->pdf[i];
        if (b->starts[i].second)
            b->starts[i].second->bounce = lane_get(&b->direction, i);
    }
}

/* Russian roulette by the throughput. */
static void play_roulette(struct bundle *b) {
    float u[2][LANES];
    lanes_2d(b->seed, b->index, b->dimension, u);
    EACH_LANE(i) {
        float most = max_component(mul(lane_get(&b->first, i), lane_get(&b->throughput, i)));
        float survival = most < 0.95f ? most : 0.95f;
        b->alive[i] = u[0][i] < survival ? b->alive[i] : 0;
        float gain = survival > 0 ? 1 / survival : 0;
        lane_set(&b->throughput, i, scale(lane_get(&b->throughput, i), gain));
    }
}

/* --- the camera's part */

static void see_first(struct bundle *b, const struct vertices *v, int i) {
    struct path_sample *out = &b->samples[i];
    const struct fewray_world *world = b->in->world;
    out->albedo = lane_get(&v->reflectance, i);
    out->normal = lane_get(&v->normal, i);
    out->depth = b->rays.ray.tfar[i];
    out->alpha = 1;
    if (world->scene->meshes[b->rays.hit.geomID[i]].emission < 0)
        return;
    struct surface surface;
    lane_surface(b, i, &surface);
    out->emission = lights_emitted(world, &surface, ray_direction(b, i));
}

/* What the camera's rays hit; lanes where that isn't plain go by `alone`, those that miss end. */
static void first_hits(struct bundle *b, struct vertices *v, bool alone[LANES]) {
    for (int i = 0; i < LANES; i++) {
        alone[i] = b->alive[i] && is_hit(b, i) && !is_plain(b, i);
        if (b->alive[i] && !is_hit(b, i)) {
            b->samples[i].emission = lights_sky(b->in->world, ray_direction(b, i));
            b->samples[i].alpha = b->in->world->lights.has_sky;
        }
        if (alone[i] || !is_hit(b, i))
            b->alive[i] = 0;
    }
    int behind[LANES];
    find_vertices(b, v, behind);
    find_reflectance(b, behind, &v->reflectance);
    for (int i = 0; i < LANES; i++)
        if (b->alive[i])
            see_first(b, v, i);
}

/* Vertices that reflect nothing end their paths. */
static void end_at_black(struct bundle *b, const struct vertices *v) {
    EACH_LANE(i)
    b->alive[i] = max_component(lane_get(&v->reflectance, i)) > 0 ? b->alive[i] : 0;
}

/* A path that meets more than a diffuse triangle goes on alone from the end of the bounce of vertex
 * `depth`. */
static void go_alone(struct bundle *b, const struct vertices *from, int i, int depth) {
    struct sampler sampler = lane_sampler(b, i);
    const struct vec3 throughput = lane_get(&b->throughput, i);
    const struct path_state state = {depth + 1, mul(lane_get(&b->first, i), throughput), 1, NULL};
    const struct path_ray ray = {lane_get(&from->position, i), lane_get(&from->geometric_normal, i),
                                 lane_get(&from->normal, i), ray_direction(b, i), b->pdf[i]};
    struct incident incident =
        trace_incident(b->in, &sampler, state, ray, depth == 0 ? b->starts[i].second : NULL);
    if (depth == 0 && b->starts[i].record) {
        b->starts[i].record->distance = incident.distance;
        b->starts[i].record->second_normal = incident.normal;
    }
    add_emission(b, i, depth, incident.emission, incident.light_pdf);
    struct vec3 reflected = mul(throughput, incident.reflected);
    lane_add(&b->reflected, i, reflected);
    if (depth > 0)
        lane_add(&b->beyond, i, reflected);
    b->rays_traced[i] += incident.rays - 1; /* the bundle has traced the first one, too */
    b->alive[i] = 0;
}

/* The vertices at the ends of the bounces from vertices `depth`, `from`. */
static void next_hits(struct bundle *b, const struct vertices *from, struct vertices *v,
                      int depth) {
    for (int i = 0; i < LANES; i++) {
        if (!b->alive[i])
            continue;
        if (is_hit(b, i) && !is_plain(b, i)) {
            go_alone(b, from, i, depth);
            continue;
        }
        find_emission(b, i, from, depth);
        if (!is_hit(b, i))
            b->alive[i] = 0;
    }
    int behind[LANES];
    find_vertices(b, v, behind);
    find_reflectance(b, behind, &v->reflectance);
}

/* What the look's record wants of the first bounce's end. */
static void note_ends(struct bundle *b, const struct vertices *v) {
    for (int i = 0; i < LANES; i++) {
        struct look_record *record = b->alive[i] ? b->starts[i].record : NULL;
        if (!record)
            continue;
        record->distance = b->rays.ray.tfar[i];
        record->second_normal = lane_get(&v->normal, i);
        if (b->starts[i].second && may_scatter(b->in, 1))
            b->starts[i].second->albedo = mean_component(lane_get(&v->reflectance, i));
    }
}

/* The bounces from vertices `depth`. */
static void bounce(struct bundle *b, const struct vertices *v, int depth) {
    if (depth > 0) {
        draw_bounces(b, v);
        if (b->noted && depth == 1)
            note_bounces(b, v);
        if (depth + 1 >= b->in->rr_depth)
            play_roulette(b);
        return;
    }
    if (b->look)
        draw_look_bounces(b, v);
    else
        draw_bounces(b, v);
    if (b->noted)
        begin_records(b, v);
    b->first = b->throughput;
    EACH_LANE(i) {
        b->first_pdf[i] = b->pdf[i];
        lane_set(&b->throughput, i, vec(1, 1, 1));
    }
}

/* From vertex to vertex until all paths have ended. */
static void follow(struct bundle *b) {
    for (int depth = 0;; depth++) {
        struct vertices *v = &b->vertices[depth & 1], *next = &b->vertices[(depth + 1) & 1];
        end_at_black(b, v);
        if (!may_scatter(b->in, depth) || !any_alive(b))
            return;
        find_proposals(b, v, depth);
        add_direct(b, v, depth);
        if (depth == 0)
            EACH_LANE(i)
        b->seed[i] =
            hash_combine(b->seed[i], b->look ? (uint32_t)BRANCH_LOOK : BRANCH_PATHS + b->in->part);
        bounce(b, v, depth);
        bounce_rays(b, v);
        if (!may_scatter(b->in, depth + 1) && !(b->noted && depth == 0)) {
            trace_lights(b);
            for (int i = 0; i < LANES; i++)
                if (b->alive[i])
                    find_emission(b, i, v, depth);
            return;
        }
        trace(b, false);
        next_hits(b, v, next, depth);
        if (b->noted && depth == 0)
            note_ends(b, next);
    }
}

/* The camera's rays through the starts' pixels to their first vertices. */
static void trace_camera(struct bundle *b, bool alone[LANES]) {
    float u[2][LANES], x[LANES], y[LANES];
    lanes_2d(b->seed, b->index, b->dimension, u);
    for (int i = 0; i < LANES; i++) {
        const struct bundle_start *s = &b->starts[i < b->count ? i : 0];
        x[i] = (float)s->x + u[0][i];
        y[i] = (float)s->y + u[1][i];
    }
    camera_rays(b, x, y);
    trace(b, true);
    first_hits(b, &b->vertices[0], alone);
}

/* What a lane's path brought. */
static void finish_sample(const struct bundle *b, int i) {
    struct path_sample *out = &b->samples[i];
    struct vec3 first = lane_get(&b->first, i), reflected = lane_get(&b->reflected, i);
    struct vec3 emission =
        scale(lane_get(&b->emission, i), power_heuristic(b->first_pdf[i], b->light_pdf[i]));
    out->bounce = mul(first, add(emission, reflected));
    out->indirect = mul(first, reflected);
    out->radiance = add(add(out->emission, lane_get(&b->direct, i)), out->bounce);
    out->rays = b->rays_traced[i];
}

static void clear_notes(const struct bundle *b) {
    for (int i = 0; i < b->count && b->noted; i++) {
        *b->starts[i].record = (struct look_record){.depth = 0};
        if (b->starts[i].second)
            *b->starts[i].second = (struct look_second){.albedo = 0};
    }
}

/* What a path has learnt beside its sample: only where it had a bounce. */
static void finish_record(const struct bundle *b, int i) {
    struct look_record *record = b->starts[i].record;
    struct look_second *second = b->starts[i].second;
    if (!record || !(record->depth > 0))
        return;
    struct vec3 emission = lane_get(&b->emission, i), reflected = lane_get(&b->reflected, i);
    record->radiance = add(emission, reflected);
    record->emitted = mean_component(emission) * power_heuristic(LOOK_PDF, b->light_pdf[i]);
    record->reflected = mean_component(reflected);
    if (b->look)
        record->direct = lane_get(&b->irradiance, i);
    if (second && b->bounce_weight[i] > 0)
        second->bounce_value += mean_component(lane_get(&b->beyond, i)) / b->bounce_weight[i];
}

static void trace_paths(const struct integrator *in, int count, const struct bundle_start *starts,
                        struct path_sample *samples) {
    struct bundle b;
    bool alone[LANES];
    start(&b, in, count, starts, samples);
    clear_notes(&b);
    trace_camera(&b, alone);
    follow(&b);
    for (int i = 0; i < count; i++)
        if (alone[i]) {
            struct sampler sampler = starts[i].sampler;
            const struct path_notes notes = {.record = starts[i].record,
                                             .second = starts[i].second};
            samples[i] = trace_path(in, starts[i].x, starts[i].y, &sampler, &notes);
        } else {
            finish_sample(&b, i);
            finish_record(&b, i);
        }
}

static void trace_looks(const struct integrator *in, int count, const struct bundle_start *starts,
                        struct path_sample *samples) {
    struct bundle b;
    bool alone[LANES];
    start(&b, in, count, starts, samples);
    b.look = true;
    clear_notes(&b);
    trace_camera(&b, alone);
    follow(&b);
    for (int i = 0; i < count; i++)
        if (alone[i]) {
            struct sampler sampler = starts[i].sampler;
            const struct path_notes notes = {.record = starts[i].record,
                                             .second = starts[i].second};
            samples[i] = trace_look_path(in, starts[i].x, starts[i].y, &sampler,
                                         starts[i].direction, &notes);
        } else {
            finish_sample(&b, i);
            finish_record(&b, i);
        }
}

static void trace_points(const struct integrator *in, int count, const float *x, const float *y,
                         const struct bundle_start *starts, struct path_sample *samples) {
    struct bundle b;
    float px[LANES], py[LANES];
    bool alone[LANES];
    start(&b, in, count, starts, samples);
    for (int i = 0; i < LANES; i++) {
        px[i] = x[i < count ? i : 0];
        py[i] = y[i < count ? i : 0];
    }
    camera_rays(&b, px, py);
    trace(&b, true);
    first_hits(&b, &b.vertices[0], alone);
    for (int i = 0; i < count; i++) {
        samples[i].rays = 1;
        if (alone[i]) {
            struct sampler sampler = starts[i].sampler;
            samples[i] = trace_features(in, x[i], y[i], &sampler);
        }
    }
}

const struct bundle_tracer BUNDLE_NAME = {trace_paths, trace_looks, trace_points};
