/* SPDX-License-Identifier: Apache-2.0 */
/* Next-event estimation at a bundle's vertices. */

#include "guide/trace/bundle_hits.inc.h"

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
static void aim(float unit, const struct vertices *v, const struct light_lanes *lights,
                const int alive[LANES], struct shadows *out) {
    EACH_LANE(i) {
        struct vec3 p = lane_get(&v->position, i), g = lane_get(&v->geometric_normal, i);
        struct vec3 d = lane_get(&lights->direction, i), q = lane_get(&lights->position, i);
        bool distant = lights->distant[i];
        struct vec3 to =
            vec(distant ? d.x : q.x - p.x, distant ? d.y : q.y - p.y, distant ? d.z : q.z - p.z);
        struct vec3 origin = offset_origin(unit, p, g, to);
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
    aim(b->in->world->unit, v, &out->lights, b->alive, out);
    light_lanes_shine(b->in->world, out->wanted, &out->lights);
    EACH_LANE(i) {
        struct vec3 e = mul(lane_get(&v->reflectance, i), lane_get(&out->lights.radiance, i));
        out->wanted[i] = max_component(e) > 0 ? out->wanted[i] : 0;
    }
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
