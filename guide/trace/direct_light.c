/* SPDX-License-Identifier: Apache-2.0 */
/* Next-event estimation: one sampled point of a light, its shadow ray and its weight. */

#include "guide/trace/direct_light.h"

#include "guide/basis.h"

/* Light that reaches the viewer by way of one sampled point of a light, up to its visibility and
 * MIS weight. */
static struct vec3 unoccluded_light(const struct fewray_world *world, const struct shading *s,
                                    struct sampler *sampler, struct light_sample *light) {
    float u[2], pick = sampler_1d(sampler);
    sampler_2d(sampler, u);
    *light = lights_sample(world, s->position, light_side(s), pick, u);
    if (!(light->pdf > 0))
        return vec(0, 0, 0);
    struct vec3 f = bsdf_times_cosine(s, light->direction);
    if (is_black(f)) /* half of the sky is below a surface: spare the map's memory */
        return f;
    if (light->distant && !light->delta)
        light->radiance = lights_sky(world, light->direction);
    return scale(mul(f, light->radiance), 1 / light->pdf);
}

static bool light_visible(const struct fewray_world *world, const struct shading *s,
                          const struct light_sample *light) {
    return light->distant
               ? !surface_blocked_to_sky(world, s->position, s->geometric_normal, light->direction)
               : !surface_blocked(world, s->position, s->geometric_normal, light->position);
}

struct direct direct_light(const struct fewray_world *world, const struct shading *s,
                           struct sampler *sampler, const struct proposal *p, float bounce_pdf,
                           int *rays, struct look_second *second) {
    static const struct direct none = {{0, 0, 0}, {0, 0, 0}};
    if (!(s->delta_chance < 1)) {
        sampler->dimension += 2;
        return none;
    }
    struct light_sample light;
    struct vec3 direct = unoccluded_light(world, s, sampler, &light);
    if (is_black(direct))
        return none;
    float chance = p->light_chance;
    if (chance < 1 && !(sampler_1d(sampler) < chance))
        return none;
    ++*rays;
    bool visible = light_visible(world, s, &light);
    float pdf = light.delta      ? 0
                : bounce_pdf > 0 ? bounce_pdf
                                 : proposal_pdf(p, s, light.direction).mixture;
    if (second && !light.delta) {
        second->light = light.direction;
        second->light_sent = true;
        second->light_value =
            visible ? mean_component(light.radiance) / (light.pdf * chance + pdf) : 0;
    }
    if (!visible)
        return none;
    float weight = power_heuristic(light.pdf * chance, pdf) / chance;
    float cosine = fmaxf(0, dot(s->normal, light.direction)) / (PI_F * light.pdf);
    return (struct direct){scale(direct, weight), scale(light.radiance, weight * cosine)};
}
