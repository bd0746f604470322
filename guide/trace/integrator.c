/* SPDX-License-Identifier: Apache-2.0 */
/* The path integrator: Mitsuba's `path` in depth counting and Russian roulette. */

#include "guide/trace/integrator.h"

#include "guide/basis.h"
#include "guide/trace/camera.h"
#include "guide/trace/direct_light.h"

/* Of a vertex where the look spreads its bounces evenly and maps guide the others. */
#define LEAST_BREADTH 0.5f

/* Radiance that a ray's end emits back along the ray. */
static struct vec3 emitted(const struct fewray_world *world, const struct surface *hit,
                           struct vec3 direction) {
    return hit ? lights_emitted(world, hit, direction) : lights_sky(world, direction);
}

static float light_pdf(const struct fewray_world *world, const struct path_ray *ray,
                       const struct surface *hit) {
    return hit ? lights_pdf_hit(world, ray->position, ray->normal, ray->direction, hit)
               : lights_pdf_sky(world, ray->direction);
}

/* A vertex's next direction. */
struct bounce {
    struct bsdf_sample sample; /* its pdf is the mixture's */
    struct proposal_pdf pdf;   /* not of a perfectly specular one */
    float light_chance;        /* of the vertex's shadow ray */
};

/* False where the direction carries nothing. */
static bool draw_bounce(const struct shading *s, struct sampler *sampler, const struct proposal *p,
                        struct bounce *out) {
    float u[2], choice = 0;
    if (p->bsdf_fraction < 1 || !bsdf_is_diffuse(s))
        choice = sampler_1d(sampler);
    else
        sampler->dimension++; /* so that a path's dimensions mean the same with and without guide */
    sampler_2d(sampler, u);
    out->light_chance = p->light_chance;
    return proposal_sample(p, s, choice, u, &out->sample, &out->pdf) &&
           !is_black(out->sample.weight);
}

/* The ray on which a path leaves s. */
static struct path_ray leave(const struct shading *s, const struct bsdf_sample *sample) {
    return (struct path_ray){s->position, s->geometric_normal, light_side(s), sample->direction,
                             sample->delta ? INFINITY : sample->pdf};
}

static void log_vertex(struct vertex_log *log, const struct shading *s, const struct bounce *b,
                       struct vec3 throughput) {
    if (!log || log->count == VERTEX_LOG_MAX || b->sample.delta)
        return;
    log->throughput[log->count] = throughput;
    log->vertices[log->count++] = (struct path_vertex){.position = s->position,
                                                       .normal = s->normal,
                                                       .direction = b->sample.direction,
                                                       .weight = b->sample.weight,
                                                       .pdf = b->pdf.mixture,
                                                       .bsdf_pdf = b->pdf.bsdf,
                                                       .guide_pdf = b->pdf.guide};
}

static float ratio(float a, float b) {
    return b > 0 ? a / b : 0;
}

/* Credits all vertices so far with radiance that arrived by way of the last of them.
 * throughput: product of the weights of all of them, specular ones included. */
static void log_radiance(struct vertex_log *log, struct vec3 throughput, struct vec3 radiance) {
    for (int k = 0; log && k < log->count; k++) {
        struct path_vertex *v = &log->vertices[k];
        struct vec3 before = mul(log->throughput[k], v->weight);
        v->incident = add(v->incident, mul(radiance, vec(ratio(throughput.x, before.x),
                                                         ratio(throughput.y, before.y),
                                                         ratio(throughput.z, before.z))));
    }
}

/* What the second vertex of a look's path saw at the end of its bounce. */
static void note_bounce(const struct integrator *in, struct look_second *second,
                        const struct bounce *bounce, const struct path_ray *ray,
                        const struct surface *hit, struct vec3 emission) {
    float light = bounce->light_chance * light_pdf(in->world, ray, hit);
    second->bounce = ray->direction;
    second->bounce_value =
        bounce->sample.delta ? 0 : mean_component(emission) / (light + bounce->pdf.mixture);
}

/* Takes the sample's weight along and plays Russian roulette for the path's survival; false where
 * it ends. */
static bool advance(const struct integrator *in, struct sampler *sampler,
                    const struct bsdf_sample *sample, struct path_state *state,
                    struct vec3 *relative) {
    *relative = mul(*relative, sample->weight);
    state->throughput = mul(state->throughput, sample->weight);
    state->eta *= sample->eta;
    if (state->depth + 1 < in->rr_depth)
        return true;
    float survival = fminf(max_component(state->throughput) * state->eta * state->eta, 0.95f);
    if (!(sampler_1d(sampler) < survival))
        return false;
    *relative = scale(*relative, 1 / survival);
    state->throughput = scale(state->throughput, 1 / survival);
    return true;
}

/* The nearest surface on a ray, or NULL. Of a ray whose end can't scatter: false where that doesn't
 * shine. */
static bool find_hit(const struct integrator *in, const struct path_ray *ray, bool scatters,
                     struct surface *surface, struct surface **hit) {
    struct vec3 origin =
        offset_origin(in->world->unit, ray->position, ray->geometric_normal, ray->direction);
    bool found = false, useful = true;
    if (scatters)
        found = surface_trace(in->world, origin, ray->direction, false, surface);
    else
        useful = surface_trace_light(in->world, origin, ray->direction, surface, &found);
    *hit = found ? surface : NULL;
    return useful;
}

struct incident trace_incident(const struct integrator *in, struct sampler *sampler,
                               struct path_state state, struct path_ray ray,
                               struct look_second *second) {
    struct incident out = {.distance = 0};
    struct vec3 relative = vec(1, 1, 1), beyond = vec(0, 0, 0);
    struct bounce bounce = {.light_chance = 1};
    float bounce_weight = 0; /* f cos of the second vertex's bounce */
    const int first_depth = state.depth;
    for (bool first = true;; first = false, state.depth++) {
        struct surface surface, *hit;
        out.rays++;
        /* A record wants to know the first bounce's end, whatever it is. */
        bool useful = find_hit(in, &ray, first || may_scatter(in, state.depth), &surface, &hit);
        struct vec3 e = useful ? emitted(in->world, hit, ray.direction) : vec(0, 0, 0);
        float light = is_black(e) || !isfinite(ray.pdf)
                          ? 0
                          : bounce.light_chance * light_pdf(in->world, &ray, hit);
        struct vec3 weighted = scale(e, power_heuristic(ray.pdf, light));
        log_radiance(state.log, state.throughput, weighted);
        if (first) {
            out.emission = e;
            out.light_pdf = light;
        } else {
            out.reflected = add(out.reflected, mul(relative, weighted));
            if (second && state.depth == first_depth + 1)
                note_bounce(in, second, &bounce, &ray, hit, e);
            else
                beyond = add(beyond, mul(relative, weighted));
        }
        if (first && hit) {
            out.distance = hit->distance;
            out.normal = dot(hit->normal, ray.direction) > 0 ? negate(hit->normal) : hit->normal;
        }
        if (!hit || !may_scatter(in, state.depth))
            break;
        struct shading s;
        bsdf_at(in->world, hit, negate(ray.direction), &s);
        if (!s.scatters)
            break;
        struct proposal proposal = proposal_at(
            &in->guides, (struct path_place){.last = !may_scatter(in, state.depth + 1)}, &s);
        struct vec3 direct =
            direct_light(in->world, &s, sampler, &proposal, 0, &out.rays, first ? second : NULL)
                .radiance;
        log_radiance(state.log, state.throughput, direct);
        out.reflected = add(out.reflected, mul(relative, direct));
        if (second && first)
            second->albedo = mean_component(s.albedo);
        else
            beyond = add(beyond, mul(relative, direct));
        if (!draw_bounce(&s, sampler, &proposal, &bounce))
            break;
        if (first && !bounce.sample.delta)
            bounce_weight = mean_component(bounce.sample.weight) * bounce.pdf.mixture;
        log_vertex(state.log, &s, &bounce, state.throughput);
        ray = leave(&s, &bounce.sample);
        if (!advance(in, sampler, &bounce.sample, &state, &relative))
            break;
    }
    if (second && bounce_weight > 0)
        second->bounce_value += mean_component(beyond) / bounce_weight;
    return out;
}

/* --- the camera's part of a path */

/* What a camera ray that leaves the scene sees. */
static void see_sky(const struct integrator *in, struct vec3 direction, bool direct,
                    struct vec3 throughput, struct path_sample *out) {
    out->emission = add(out->emission, mul(throughput, emitted(in->world, NULL, direction)));
    if (direct)
        out->alpha = in->world->lights.has_sky;
    else
        out->albedo = throughput;
}

/* What the camera sees of a surface, directly or by mirrors and clear glass. */
static void see_surface(const struct integrator *in, const struct surface *hit,
                        struct vec3 direction, const struct shading *s, struct vec3 throughput,
                        struct path_sample *out) {
    out->emission = add(out->emission, mul(throughput, emitted(in->world, hit, direction)));
    out->albedo = mul(throughput, s->albedo);
    out->normal = s->normal;
    out->depth += hit->distance;
    out->alpha = 1;
}

/* Follows the camera ray by way of perfectly specular surfaces to the first that scatters
 * otherwise, gathers the features and the emission on the way, and stops there: false where there
 * is no such vertex. */
static bool first_vertex(const struct integrator *in, float x, float y, struct sampler *sampler,
                         struct path_sample *out, struct shading *s, struct path_state *state) {
    struct vec3 origin, direction;
    float lens[2] = {0, 0};
    if (in->world->scene->camera.aperture_radius > 0)
        sampler_2d(sampler, lens);
    camera_ray(&in->world->scene->camera, in->width, in->height, x, y, lens, &origin, &direction);
    for (state->depth = 0;; state->depth++) {
        struct surface hit;
        bool direct = state->depth == 0;
        out->rays++;
        if (!surface_trace(in->world, origin, direction, direct, &hit)) {
            see_sky(in, direction, direct, state->throughput, out);
            return false;
        }
        bsdf_at(in->world, &hit, negate(direction), s);
        see_surface(in, &hit, direction, s, state->throughput, out);
        if (!s->scatters || !may_scatter(in, state->depth))
            return false;
        if (s->delta_chance < 1) {
            state->depth++;
            return true;
        }
        struct bsdf_sample sample;
        struct vec3 unused = vec(1, 1, 1);
        float u[2], choice = sampler_1d(sampler);
        sampler_2d(sampler, u);
        if (!bsdf_sample(s, choice, u, &sample) || !advance(in, sampler, &sample, state, &unused))
            return false;
        direction = sample.direction;
        origin = offset_origin(in->world->unit, s->position, s->geometric_normal, direction);
    }
}

static struct path_state start_state(const struct path_notes *notes) {
    return (struct path_state){.throughput = {1, 1, 1}, .eta = 1, .log = notes->log};
}

struct path_sample trace_features(const struct integrator *in, float x, float y,
                                  struct sampler *sampler) {
    static const struct path_notes none = {NULL, NULL, NULL};
    struct path_sample out = {.rays = 0};
    struct path_state state = start_state(&none);
    struct shading s;
    first_vertex(in, x, y, sampler, &out, &s, &state);
    return out;
}

/* The first vertex through the pixel (x, y). */
static bool start_path(const struct integrator *in, int x, int y, struct sampler *sampler,
                       struct path_sample *out, struct shading *s, struct path_state *state) {
    float u[2];
    sampler_2d(sampler, u);
    bool scatters = first_vertex(in, (float)x + u[0], (float)y + u[1], sampler, out, s, state);
    out->radiance = out->emission;
    return scatters;
}

/* Follows the bounce from the first vertex and adds what it brings. */
static void add_bounce(const struct integrator *in, const struct shading *s,
                       struct sampler *sampler, const struct bounce *b, struct path_state state,
                       const struct path_notes *notes, struct path_sample *out) {
    struct vec3 weight = mul(state.throughput, b->sample.weight);
    log_vertex(notes->log, s, b, state.throughput);
    state.throughput = weight;
    state.eta *= b->sample.eta;
    struct path_ray ray = leave(s, &b->sample);
    bool record = notes->record && !b->sample.delta && s->breadth >= LEAST_BREADTH;
    struct incident incident =
        trace_incident(in, sampler, state, ray, record ? notes->second : NULL);
    out->rays += incident.rays;
    out->bounce = mul(weight, incident_radiance(&incident, ray.pdf));
    out->indirect = mul(weight, incident.reflected);
    out->radiance = add(out->radiance, out->bounce);
    if (!record)
        return;
    *notes->record = (struct look_record){.position = s->position,
                                          .normal = s->normal,
                                          .depth = out->depth,
                                          .direction = ray.direction,
                                          .bin = (uint16_t)sphere_bin(ray.direction),
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
    static const struct path_notes none = {NULL, NULL, NULL};
    struct path_sample out = {.rays = 0};
    struct shading s;
    notes = notes ? notes : &none;
    struct path_state state = start_state(notes);
    clear_notes(notes);
    if (!start_path(in, x, y, sampler, &out, &s, &state))
        return out;
    struct proposal proposal =
        proposal_at(&in->guides, (struct path_place){x, y, .first = true}, &s);
    out.guided = proposal.bsdf_fraction < 1;
    struct vec3 direct =
        direct_light(in->world, &s, sampler, &proposal, 0, &out.rays, NULL).radiance;
    out.radiance = add(out.radiance, mul(state.throughput, direct));
    sampler_branch(sampler, BRANCH_PATHS + in->part);
    struct bounce bounce;
    if (draw_bounce(&s, sampler, &proposal, &bounce))
        add_bounce(in, &s, sampler, &bounce, state, notes, &out);
    return out;
}

/* The look's bounce: uniform over the hemisphere, but where a mirror's part is due. */
static bool draw_look_bounce(const struct shading *s, struct sampler *sampler, const float u[2],
                             struct bounce *out) {
    *out = (struct bounce){.light_chance = 1};
    float choice = s->delta_chance > 0 ? sampler_1d(sampler) : 0;
    if (choice < s->delta_chance)
        return bsdf_sample(s, choice, u, &out->sample);
    struct basis basis = basis_around(s->normal);
    out->sample.direction = normalize(to_world(&basis, uniform_hemisphere(u)));
    out->sample.pdf = out->pdf.mixture = (1 - s->delta_chance) * LOOK_PDF;
    out->sample.eta = 1;
    out->sample.weight = scale(bsdf_times_cosine(s, out->sample.direction), 1 / out->sample.pdf);
    return true;
}

struct path_sample trace_look_path(const struct integrator *in, int x, int y,
                                   struct sampler *sampler, const float u[2],
                                   const struct path_notes *notes) {
    struct path_sample out = {.rays = 0};
    struct shading s;
    struct path_state state = start_state(notes);
    clear_notes(notes);
    if (!start_path(in, x, y, sampler, &out, &s, &state))
        return out;
    bool even = s.breadth >= LEAST_BREADTH;
    struct proposal bsdf = proposal_bsdf();
    struct direct direct = direct_light(
        in->world, &s, sampler, &bsdf, even ? (1 - s.delta_chance) * LOOK_PDF : 0, &out.rays, NULL);
    out.radiance = add(out.radiance, mul(state.throughput, direct.radiance));
    sampler_branch(sampler, BRANCH_LOOK);
    struct bounce b;
    if (!(even ? draw_look_bounce(&s, sampler, u, &b) : draw_bounce(&s, sampler, &bsdf, &b)))
        return out;
    add_bounce(in, &s, sampler, &b, state, notes, &out);
    if (notes->record && notes->record->depth > 0)
        notes->record->direct = direct.irradiance;
    return out;
}
