/* SPDX-License-Identifier: Apache-2.0 */
/* The path integrator: Mitsuba's `path` in depth counting and Russian roulette. */

#include "guide/trace/integrator.h"

#include "guide/trace/basis.h"
#include "guide/trace/camera.h"

/* A pixel's samples, the look's and the rest, share one sequence for the camera and for next-event
 * estimation at the first hit, so that they are stratified together. What a map learns from mustn't
 * tell where the samples that it guides lie: from the bounce on they are independent, and so are
 * the parts between which maps learn. */
enum { BRANCH_LOOK = 1, BRANCH_PATHS };

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
static struct vec3 unoccluded_light(const struct fewray_world *world, const struct shading *s,
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
    light->radiance = radiance;
    return scale(mul(f, radiance), 1 / light->pdf);
}

static bool light_visible(const struct fewray_world *world, const struct shading *s,
                          const struct light_sample *light) {
    return light->distant
               ? !surface_blocked_to_sky(world, s->position, s->geometric_normal, light->direction)
               : !surface_blocked(world, s->position, s->geometric_normal, light->position);
}

/* Next-event estimation, MIS-weighted against a bounce of density `bounce_pdf` > 0 (0: drawn from
 * `p`). Where a probe expects no light the shadow ray plays Russian roulette, whose chance counts
 * as part of the light's density. */
static struct vec3 direct_light(const struct integrator *in, const struct shading *s,
                                struct sampler *sampler, const struct proposal *p, float bounce_pdf,
                                int *rays, struct look_second *second) {
    struct light_sample light;
    struct vec3 direct = unoccluded_light(in->world, s, sampler, &light);
    if (is_black(direct))
        return direct;
    float chance = p->light_chance;
    if (chance < 1 && !(sampler_1d(sampler) < chance))
        return vec(0, 0, 0);
    ++*rays;
    bool visible = light_visible(in->world, s, &light);
    if (second) {
        second->light = light.direction;
        second->light_sent = true;
        second->light_value =
            visible ? mean_component(light.radiance) /
                          (light.pdf * chance + proposal_pdf(p, s, light.direction).mixture)
                    : 0;
    }
    if (!visible)
        return vec(0, 0, 0);
    float pdf = bounce_pdf > 0 ? bounce_pdf : proposal_pdf(p, s, light.direction).mixture;
    return scale(direct, power_heuristic(light.pdf * chance, pdf) / chance);
}

/* A vertex's next direction. */
struct bounce {
    struct vec3 direction, weight; /* weight: f cos / pdf */
    struct proposal_pdf pdf;
    float light_chance; /* of the vertex's shadow ray */
};

/* False where the direction carries nothing. */
static bool draw_bounce(const struct shading *s, struct sampler *sampler, const struct proposal *p,
                        struct bounce *out) {
    float u[2], choice = 0;
    if (p->bsdf_fraction < 1)
        choice = sampler_1d(sampler);
    else
        sampler->dimension++; /* so that a path's dimensions mean the same with and without guide */
    sampler_2d(sampler, u);
    out->direction = proposal_sample(p, s, choice, u);
    out->pdf = proposal_pdf(p, s, out->direction);
    if (!(out->pdf.bsdf > 0) || !(out->pdf.mixture > 0))
        return false;
    out->weight = scale(bsdf_times_cosine(s, out->direction), 1 / out->pdf.mixture);
    out->light_chance = p->light_chance;
    return true;
}

static void log_vertex(struct vertex_log *log, const struct shading *s, const struct bounce *b,
                       struct vec3 throughput) {
    if (!log || log->count == VERTEX_LOG_MAX)
        return;
    log->throughput[log->count] = throughput;
    log->vertices[log->count++] = (struct path_vertex){.position = s->position,
                                                       .normal = s->normal,
                                                       .direction = b->direction,
                                                       .weight = b->weight,
                                                       .pdf = b->pdf.mixture,
                                                       .bsdf_pdf = b->pdf.bsdf,
                                                       .guide_pdf = b->pdf.guide};
}

static float ratio(float a, float b) {
    return b > 0 ? a / b : 0;
}

/* Credits the first `count` vertices with radiance that arrived by way of the last of them.
 * throughput: product of the weights of all of them. */
static void log_radiance(struct vertex_log *log, int count, struct vec3 throughput,
                         struct vec3 radiance) {
    for (int k = 0; log && k < count && k < log->count; k++) {
        struct path_vertex *v = &log->vertices[k];
        struct vec3 before = mul(log->throughput[k], v->weight);
        v->incident = add(v->incident, mul(radiance, vec(ratio(throughput.x, before.x),
                                                         ratio(throughput.y, before.y),
                                                         ratio(throughput.z, before.z))));
    }
}

/* What the second vertex of a look's path saw at the end of its bounce. */
static void note_bounce(const struct integrator *in, struct look_second *second,
                        const struct bounce *bounce, const struct surface *hit,
                        struct vec3 emission) {
    float light = bounce->light_chance * light_pdf(in->world, hit, bounce->direction);
    second->bounce = bounce->direction;
    second->bounce_value = mean_component(emission) / (light + bounce->pdf.mixture);
}

/* Plays Russian roulette for the path's survival; false where it ends. */
static bool survives(const struct integrator *in, struct sampler *sampler, int depth,
                     struct path_state *state, struct vec3 *relative) {
    if (depth < in->rr_depth)
        return true;
    float survival = fminf(max_component(state->throughput), 0.95f);
    if (!(sampler_1d(sampler) < survival))
        return false;
    *relative = scale(*relative, 1 / survival);
    state->throughput = scale(state->throughput, 1 / survival);
    return true;
}

struct incident trace_incident(const struct integrator *in, struct sampler *sampler,
                               struct path_state state, struct vec3 position,
                               struct vec3 geometric_normal, struct vec3 direction, float pdf,
                               struct look_second *second) {
    struct incident out = {.distance = 0};
    struct vec3 relative = vec(1, 1, 1), beyond = vec(0, 0, 0);
    struct bounce bounce = {.direction = direction, .light_chance = 1};
    float bounce_weight = 0; /* f cos of the second vertex's bounce */
    const int first_depth = state.depth;
    for (bool first = true;; first = false, state.depth++) {
        struct surface surface;
        out.rays++;
        struct surface *hit =
            surface_trace(in->world, offset_origin(position, geometric_normal, direction),
                          direction, false, &surface)
                ? &surface
                : NULL;
        struct vec3 e = emitted(in->world, hit, direction);
        float light = is_black(e) ? 0 : bounce.light_chance * light_pdf(in->world, hit, direction);
        struct vec3 weighted = scale(e, power_heuristic(pdf, light));
        log_radiance(state.log, state.depth, state.throughput, weighted);
        if (first) {
            out.emission = e;
            out.light_pdf = light;
        } else {
            out.reflected = add(out.reflected, mul(relative, weighted));
            if (second && state.depth == first_depth + 1)
                note_bounce(in, second, &bounce, hit, e);
            else
                beyond = add(beyond, mul(relative, weighted));
        }
        if (first && hit) {
            out.distance = hit->distance;
            out.normal = dot(hit->normal, direction) > 0 ? negate(hit->normal) : hit->normal;
        }
        if (!hit || !may_scatter(in, state.depth))
            break;
        struct shading s = bsdf_at(in->world->scene, hit, negate(direction));
        if (!s.scatters || is_black(s.albedo))
            break;
        struct proposal proposal = proposal_at(&in->guides, 0, 0, state.depth, &s);
        struct vec3 direct =
            direct_light(in, &s, sampler, &proposal, 0, &out.rays, first ? second : NULL);
        log_radiance(state.log, state.depth, state.throughput, direct);
        out.reflected = add(out.reflected, mul(relative, direct));
        if (second && first)
            second->albedo = mean_component(s.albedo);
        else
            beyond = add(beyond, mul(relative, direct));
        if (!draw_bounce(&s, sampler, &proposal, &bounce))
            break;
        if (first)
            bounce_weight = mean_component(bounce.weight) * bounce.pdf.mixture;
        log_vertex(state.log, &s, &bounce, state.throughput);
        position = s.position;
        geometric_normal = s.geometric_normal;
        direction = bounce.direction;
        pdf = bounce.pdf.mixture;
        relative = mul(relative, bounce.weight);
        state.throughput = mul(state.throughput, bounce.weight);
        if (!survives(in, sampler, state.depth + 1, &state, &relative))
            break;
    }
    if (second && bounce_weight > 0)
        second->bounce_value += mean_component(beyond) / bounce_weight;
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

static const struct path_notes no_notes = {NULL, NULL, NULL};

/* Follows the bounce from the first hit and adds what it brings. */
static void add_bounce(const struct integrator *in, const struct shading *s,
                       struct sampler *sampler, const struct bounce *b,
                       const struct path_notes *notes, struct path_sample *out) {
    struct path_state state = {.depth = 1, .throughput = b->weight, .log = notes->log};
    log_vertex(notes->log, s, b, vec(1, 1, 1));
    struct incident incident = trace_incident(in, sampler, state, s->position, s->geometric_normal,
                                              b->direction, b->pdf.mixture, notes->second);
    out->rays += incident.rays;
    out->bounce = mul(b->weight, incident_radiance(&incident, b->pdf.mixture));
    out->radiance = add(out->radiance, out->bounce);
    if (!notes->record)
        return;
    *notes->record = (struct look_record){.position = s->position,
                                          .normal = s->normal,
                                          .depth = out->depth,
                                          .direction = b->direction,
                                          .bin = (uint16_t)sphere_bin(b->direction),
                                          .radiance = add(incident.emission, incident.reflected),
                                          .emitted = mean_component(incident.emission) *
                                                     power_heuristic(LOOK_PDF, incident.light_pdf),
                                          .reflected = mean_component(incident.reflected),
                                          .distance = incident.distance,
                                          .second_normal = incident.normal};
}

static void clear_notes(const struct path_notes *notes) {
    if (notes->log)
        notes->log->count = 0;
    if (notes->record)
        *notes->record = (struct look_record){.depth = 0};
    if (notes->second)
        *notes->second = (struct look_second){.albedo = 0};
}

struct path_sample trace_path(const struct integrator *in, int x, int y, struct sampler *sampler,
                              const struct path_notes *notes) {
    struct path_sample out = {.rays = 0};
    struct shading s;
    notes = notes ? notes : &no_notes;
    clear_notes(notes);
    if (!first_hit(in, x, y, sampler, &out, &s))
        return out;
    struct proposal proposal = proposal_at(&in->guides, x, y, 0, &s);
    out.guided = proposal.bsdf_fraction < 1;
    if (is_black(s.albedo))
        return out;
    out.radiance = add(out.radiance, direct_light(in, &s, sampler, &proposal, 0, &out.rays, NULL));
    sampler_branch(sampler, BRANCH_PATHS + in->part);
    struct bounce bounce;
    if (draw_bounce(&s, sampler, &proposal, &bounce))
        add_bounce(in, &s, sampler, &bounce, notes, &out);
    return out;
}

struct path_sample trace_look_path(const struct integrator *in, int x, int y,
                                   struct sampler *sampler, const float u[2],
                                   const struct path_notes *notes) {
    struct path_sample out = {.rays = 0};
    struct shading s;
    clear_notes(notes);
    if (!first_hit(in, x, y, sampler, &out, &s))
        return out;
    struct proposal none = proposal_bsdf();
    struct vec3 direct = direct_light(in, &s, sampler, &none, LOOK_PDF, &out.rays, NULL);
    out.radiance = add(out.radiance, direct);
    sampler_branch(sampler, BRANCH_LOOK);
    struct basis basis = basis_around(s.normal);
    struct bounce b = {.direction = normalize(to_world(&basis, uniform_hemisphere(u))),
                       .pdf = {.mixture = LOOK_PDF}};
    b.weight = scale(bsdf_times_cosine(&s, b.direction), 1 / LOOK_PDF);
    add_bounce(in, &s, sampler, &b, notes, &out);
    if (notes->record)
        notes->record->direct = vec(ratio(direct.x, s.albedo.x), ratio(direct.y, s.albedo.y),
                                    ratio(direct.z, s.albedo.z));
    return out;
}
