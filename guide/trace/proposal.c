/* SPDX-License-Identifier: Apache-2.0 */
/* Mixtures of BSDF and guide. */

#include "guide/trace/proposal.h"

#include "guide/ppg/ppg.h"

/* What a later vertex's bounce brings is for the most part one draw of a noisy estimate: a guide
 * that was wrong there would make it noisier still, so the BSDF keeps half of the samples. */
#define LATER_FRACTION 0.5f

struct proposal proposal_later(const struct guides *guides, bool last, struct vec3 position,
                               struct vec3 normal) {
    struct proposal p = proposal_bsdf();
    p.probe = probes_at(guides->probes, position, normal);
    if (p.probe) {
        p.bsdf_fraction = p.probe->bsdf_fraction;
        p.light_chance = p.probe->light_chance;
    }
    const struct map *map = guides->maps ? maps_near(guides->maps, position, normal) : NULL;
    if (map) {
        p.maps = (struct map_mixture){1, {map}, {1}, map->bsdf_fraction};
        p.bsdf_fraction = map->bsdf_fraction;
        p.probe = NULL;
    }
    if (!last)
        p.bsdf_fraction = fmaxf(p.bsdf_fraction, LATER_FRACTION);
    return p;
}

struct proposal proposal_first(const struct fewray_maps *maps, int x, int y, struct vec3 position,
                               struct vec3 normal) {
    struct proposal p = proposal_bsdf();
    p.maps = maps_at(maps, x, y, position, normal);
    if (p.maps.count)
        p.bsdf_fraction = p.maps.bsdf_fraction;
    return p;
}

struct proposal proposal_at(const struct guides *guides, struct path_place place,
                            const struct shading *s) {
    struct proposal p = proposal_bsdf();
    if (!(s->breadth > 0))
        return p;
    if (guides->ppg) {
        p.leaf = ppg_leaf_at(guides->ppg, s->position);
        if (p.leaf)
            p.bsdf_fraction = ppg_leaf_bsdf_fraction(p.leaf);
    } else if (place.first && guides->maps) {
        p = proposal_first(guides->maps, place.x, place.y, s->position, s->normal);
    } else if (!place.first && guides->probes) {
        p = proposal_later(guides, place.last, s->position, s->normal);
    }
    p.bsdf_fraction = 1 - (1 - p.bsdf_fraction) * s->breadth;
    return p;
}

struct vec3 proposal_draw(const struct proposal *p, const float u[2]) {
    return p->leaf    ? ppg_leaf_sample(p->leaf, u)
           : p->probe ? probe_sample(p->probe, u)
                      : map_mixture_sample(&p->maps, u);
}

float proposal_guide_pdf(const struct proposal *p, struct vec3 direction) {
    return p->leaf    ? ppg_leaf_pdf(p->leaf, direction)
           : p->probe ? probe_pdf(p->probe, direction)
                      : map_mixture_pdf(&p->maps, direction);
}

struct proposal_pdf proposal_pdf(const struct proposal *p, const struct shading *s,
                                 struct vec3 direction) {
    float smooth = 1 - s->delta_chance, bsdf = bsdf_pdf(s, direction);
    struct proposal_pdf pdf = {.mixture = bsdf, .bsdf = smooth > 0 ? bsdf / smooth : 0};
    if (p->bsdf_fraction < 1) {
        pdf.guide = proposal_guide_pdf(p, direction);
        pdf.mixture = p->bsdf_fraction * bsdf + (1 - p->bsdf_fraction) * smooth * pdf.guide;
    }
    return pdf;
}

bool proposal_sample(const struct proposal *p, const struct shading *s, float choice,
                     const float u[2], struct bsdf_sample *out, struct proposal_pdf *pdf) {
    float delta = s->delta_chance, a = p->bsdf_fraction;
    if (choice < delta || a >= 1) {
        if (!bsdf_sample(s, choice, u, out))
            return false;
        if (!out->delta)
            *pdf = (struct proposal_pdf){.mixture = out->pdf, .bsdf = out->pdf / (1 - delta)};
        return true;
    }
    float rest = (choice - delta) / (1 - delta);
    if (rest < a) {
        if (!bsdf_sample(s, fmaxf(delta, delta + (1 - delta) * (rest / a)), u, out))
            return false;
    } else {
        *out = (struct bsdf_sample){.direction = proposal_draw(p, u), .eta = 1};
    }
    *pdf = proposal_pdf(p, s, out->direction);
    out->pdf = pdf->mixture;
    if (!(out->pdf > 0))
        return false;
    out->weight = scale(bsdf_times_cosine(s, out->direction), 1 / out->pdf);
    return true;
}
