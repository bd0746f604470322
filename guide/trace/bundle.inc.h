/* SPDX-License-Identifier: Apache-2.0 */
/* Bundles of paths, compiled once for each instruction set; BUNDLE_NAME is the table it fills. */

#include "guide/trace/bundle_bounce.inc.h"

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
        if (depth + 1 >= b->in->rr_depth)
            play_roulette(b);
        if (b->noted && depth == 1) /* of the paths that survived */
            note_bounces(b, v);
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
                b->seed[i] = hash_combine(b->seed[i], b->look ? (uint32_t)BRANCH_LOOK
                                                              : BRANCH_PATHS + b->in->part);
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

/* The path of a lane that left the bundle at its first hit. */
static struct path_sample trace_alone(const struct bundle *b, int i) {
    const struct bundle_start *start = &b->starts[i];
    struct sampler sampler = start->sampler;
    const struct path_notes notes = {.record = start->record, .second = start->second};
    return b->look ? trace_look_path(b->in, start->x, start->y, &sampler, start->direction, &notes)
                   : trace_path(b->in, start->x, start->y, &sampler, &notes);
}

static void trace_bundle(struct bundle *b) {
    bool alone[LANES];
    clear_notes(b);
    trace_camera(b, alone);
    follow(b);
    for (int i = 0; i < b->count; i++)
        if (alone[i]) {
            b->samples[i] = trace_alone(b, i);
        } else {
            finish_sample(b, i);
            finish_record(b, i);
        }
}

static void trace_paths(const struct integrator *in, int count, const struct bundle_start *starts,
                        struct path_sample *samples) {
    struct bundle b;
    start(&b, in, count, starts, samples);
    trace_bundle(&b);
}

static void trace_looks(const struct integrator *in, int count, const struct bundle_start *starts,
                        struct path_sample *samples) {
    struct bundle b;
    start(&b, in, count, starts, samples);
    b.look = true;
    trace_bundle(&b);
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
