/* SPDX-License-Identifier: Apache-2.0 */
/* The path integrator: Mitsuba's `path` in depth counting and Russian roulette. */

#include "guide/trace/integrator.h"

#include "guide/trace/basis.h"
#include "guide/trace/camera.h"

static bool is_black(struct vec3 c) {
    return !(c.x > 0 || c.y > 0 || c.z > 0);
}

static bool may_scatter(const struct integrator *in, int depth) {
    return in->max_depth < 0 || depth + 1 < in->max_depth;
}

/* Radiance that a ray's end emits back along the ray. */
static struct vec3 emitted(const struct fewray_world *world, const struct surface *hit,
                           struct vec3 direction) {
    if (!hit)
        return environment_radiance(&world->scene->environment, direction);
    return hit->mesh->emissive && dot(hit->normal, direction) < 0 ? hit->mesh->radiance
                                                                  : vec(0, 0, 0);
}

static float light_pdf(const struct fewray_world *world, const struct surface *hit,
                       struct vec3 direction) {
    return hit ? lights_pdf_hit(world, direction, hit) : lights_pdf_environment(world, direction);
}

/* Light that reaches the viewer by way of one sampled point of a light, up to its visibility and
 * MIS weight. */
static struct vec3 direct_light(const struct fewray_world *world, const struct shading *s,
                                struct sampler *sampler, struct light_sample *light) {
    float u[2], pick = sampler_1d(sampler);
    sampler_2d(sampler, u);
    *light = lights_sample(world, s->position, pick, u);
    if (!(light->pdf > 0))
        return vec(0, 0, 0);
    struct vec3 f = bsdf_times_cosine(s, light->direction);
    if (is_black(f)) /* half of the sky is below a surface: spare the map's memory */
        return f;
    struct vec3 radiance = light->distant
                               ? environment_radiance(&world->scene->environment, light->direction)
                               : light->radiance;
    return scale(mul(f, radiance), 1 / light->pdf);
}

static bool light_visible(const struct fewray_world *world, const struct shading *s,
                          const struct light_sample *light) {
    return light->distant
               ? !surface_blocked_to_sky(world, s->position, s->geometric_normal, light->direction)
               : !surface_blocked(world, s->position, s->geometric_normal, light->position);
}

struct incident trace_incident(const struct integrator *in, struct sampler *sampler,
                               struct vec3 position, struct vec3 geometric_normal,
                               struct vec3 direction, float pdf, int depth,
                               struct vec3 throughput) {
    struct incident out = {.distance = 0};
    struct vec3 reflected = vec(0, 0, 0), relative = vec(1, 1, 1);
    for (bool first = true;; first = false, depth++) {
        struct surface surface;
        out.rays++;
        struct surface *hit =
            surface_trace(in->world, offset_origin(position, geometric_normal, direction),
                          direction, false, &surface)
                ? &surface
                : NULL;
        struct vec3 e = emitted(in->world, hit, direction);
        if (!is_black(e)) {
            float weight = power_heuristic(pdf, light_pdf(in->world, hit, direction));
            struct vec3 weighted = mul(relative, scale(e, weight));
            if (first)
                out.full = e, out.radiance = weighted;
            else
                reflected = add(reflected, weighted);
        }
        if (first && hit) {
            out.distance = hit->distance;
            out.normal = dot(hit->normal, direction) > 0 ? negate(hit->normal) : hit->normal;
        }
        if (!hit || !may_scatter(in, depth))
            break;
        struct shading s = bsdf_at(in->world->scene, hit, negate(direction));
        if (!s.scatters || is_black(s.albedo))
            break;
        struct light_sample light;
        struct vec3 direct = direct_light(in->world, &s, sampler, &light);
        if (!is_black(direct)) {
            out.rays++;
            if (light_visible(in->world, &s, &light)) {
                float weight = power_heuristic(light.pdf, bsdf_pdf(&s, light.direction));
                reflected = add(reflected, mul(relative, scale(direct, weight)));
            }
        }
        float u[2];
        sampler_2d(sampler, u);
        position = s.position;
        geometric_normal = s.geometric_normal;
        direction = bsdf_sample(&s, u);
        pdf = bsdf_pdf(&s, direction);
        if (!(pdf > 0))
            break;
        relative = mul(relative, s.albedo);
        throughput = mul(throughput, s.albedo);
        if (depth + 1 >= in->rr_depth) {
            float survival = fminf(max_component(throughput), 0.95f);
            if (!(sampler_1d(sampler) < survival))
                break;
            relative = scale(relative, 1 / survival);
            throughput = scale(throughput, 1 / survival);
        }
    }
    out.radiance = add(out.radiance, reflected);
    out.full = add(out.full, reflected);
    return out;
}

/* The camera ray's hit, with the features it shows. */
static bool first_hit(const struct integrator *in, int x, int y, struct sampler *sampler,
                      struct path_sample *out, struct shading *shading) {
    float u[2];
    sampler_2d(sampler, u);
    struct vec3 origin, direction;
    camera_ray(&in->world->scene->camera, in->width, in->height, (float)x + u[0], (float)y + u[1],
               &origin, &direction);
    struct surface hit;
    out->rays = 1;
    if (!surface_trace(in->world, origin, direction, true, &hit)) {
        out->emission = out->radiance = emitted(in->world, NULL, direction);
        out->alpha = in->world->scene->environment.kind != ENVIRONMENT_NONE;
        return false;
    }
    *shading = bsdf_at(in->world->scene, &hit, negate(direction));
    out->emission = out->radiance = emitted(in->world, &hit, direction);
    out->albedo = shading->albedo;
    out->normal = dot(hit.normal, direction) > 0 ? negate(hit.normal) : hit.normal;
    out->depth = hit.distance;
    out->alpha = 1;
    return shading->scatters && may_scatter(in, 0);
}

struct vec3 trace_emission(const struct integrator *in, float x, float y) {
    struct vec3 origin, direction;
    camera_ray(&in->world->scene->camera, in->width, in->height, x, y, &origin, &direction);
    struct surface hit;
    bool found = surface_trace(in->world, origin, direction, true, &hit);
    return emitted(in->world, found ? &hit : NULL, direction);
}

/* Adds next-event estimation at the first hit; mixture_pdf tells the density of the bounce for MIS.
 */
static void add_direct(const struct integrator *in, const struct shading *s,
                       struct sampler *sampler, const struct map_mixture *mixture, bool uniform,
                       struct path_sample *out) {
    struct light_sample light;
    struct vec3 direct = direct_light(in->world, s, sampler, &light);
    if (is_black(direct))
        return;
    out->rays++;
    if (!light_visible(in->world, s, &light))
        return;
    float pdf = uniform ? 0.5f / PI_F : bsdf_pdf(s, light.direction);
    if (mixture->count)
        pdf = in->bsdf_fraction * pdf +
              (1 - in->bsdf_fraction) * map_mixture_pdf(mixture, light.direction);
    out->radiance = add(out->radiance, scale(direct, power_heuristic(light.pdf, pdf)));
}

/* Follows the bounce in `direction`, drawn with density pdf, and adds what it brings. */
static struct incident add_bounce(const struct integrator *in, const struct shading *s,
                                  struct sampler *sampler, struct vec3 direction, float pdf,
                                  struct path_sample *out) {
    struct vec3 weight = scale(bsdf_times_cosine(s, direction), 1 / pdf);
    struct incident incident =
        trace_incident(in, sampler, s->position, s->geometric_normal, direction, pdf, 1, weight);
    out->rays += incident.rays;
    out->radiance = add(out->radiance, mul(weight, incident.radiance));
    return incident;
}

struct path_sample trace_path(const struct integrator *in, int x, int y, struct sampler *sampler) {
    struct path_sample out = {.rays = 0};
    struct shading s;
    if (!first_hit(in, x, y, sampler, &out, &s))
        return out;
    struct map_mixture mixture = {.count = 0};
    if (in->maps)
        mixture = maps_at(in->maps, x, y, s.position, s.normal);
    out.guided = mixture.count > 0;
    if (is_black(s.albedo))
        return out;
    add_direct(in, &s, sampler, &mixture, false, &out);

    float u[2], choice = sampler_1d(sampler);
    sampler_2d(sampler, u);
    bool from_map = mixture.count > 0 && choice >= in->bsdf_fraction;
    struct vec3 direction = from_map ? map_mixture_sample(&mixture, u) : bsdf_sample(&s, u);
    float pdf = bsdf_pdf(&s, direction);
    if (!(pdf > 0))
        return out;
    if (mixture.count)
        pdf = in->bsdf_fraction * pdf +
              (1 - in->bsdf_fraction) * map_mixture_pdf(&mixture, direction);
    add_bounce(in, &s, sampler, direction, pdf, &out);
    return out;
}

struct path_sample trace_look_path(const struct integrator *in, int x, int y,
                                   struct sampler *sampler, const float u[2],
                                   struct look_record *record) {
    struct path_sample out = {.rays = 0};
    struct shading s;
    *record = (struct look_record){.depth = 0};
    if (!first_hit(in, x, y, sampler, &out, &s))
        return out;
    struct map_mixture none = {.count = 0};
    add_direct(in, &s, sampler, &none, true, &out);
    struct basis basis = basis_around(s.normal);
    struct vec3 direction = normalize(to_world(&basis, uniform_hemisphere(u)));
    struct incident incident = add_bounce(in, &s, sampler, direction, 0.5f / PI_F, &out);
    *record = (struct look_record){.position = s.position,
                                   .normal = s.normal,
                                   .depth = out.depth,
                                   .direction = direction,
                                   .radiance = incident.full,
                                   .weighted = mean_component(incident.radiance),
                                   .distance = incident.distance,
                                   .second_normal = incident.normal};
    return out;
}
