/* SPDX-License-Identifier: Apache-2.0 */
/* Where a bundle's paths go next. */

#include "guide/trace/bundle_direct.inc.h"

/* Directions of the BSDF: cosine_hemisphere() about the normal. */
static void diffuse_bounces(const struct vertices *v, float u[2][LANES], struct bundle *b) {
    EACH_LANE(i) {
        const float point[2] = {u[0][i], u[1][i]};
        struct vec3 local = normalize(cosine_hemisphere(point));
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
        float cosine = dot(lane_get(&v->normal, i), lane_get(&b->direction, i));
        b->bounce_weight[i] = mean_component(lane_get(&v->reflectance, i)) * cosine / PI_F;
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
