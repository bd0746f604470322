/* SPDX-License-Identifier: Apache-2.0 */
/* A bundle's paths on their way, and their rays. */

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
    const float unit = b->in->world->unit;
    EACH_LANE(i) {
        struct vec3 d = lane_get(&b->direction, i);
        set_ray(
            &b->rays.ray, i,
            offset_origin(unit, lane_get(&v->position, i), lane_get(&v->geometric_normal, i), d), d,
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
