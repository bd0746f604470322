/* SPDX-License-Identifier: Apache-2.0 */
/* Mixtures of BSDF and guide. */

#include "guide/trace/proposal.h"

#include "guide/ppg/ppg.h"

struct proposal proposal_at(const struct guides *guides, int x, int y, int depth,
                            const struct shading *s) {
    struct proposal p = proposal_bsdf();
    if (guides->ppg) {
        p.leaf = ppg_leaf_at(guides->ppg, s->position);
        if (p.leaf)
            p.bsdf_fraction = ppg_leaf_bsdf_fraction(p.leaf);
    } else if (depth == 0 && guides->maps) {
        p.maps = maps_at(guides->maps, x, y, s->position, s->normal);
        if (p.maps.count)
            p.bsdf_fraction = p.maps.bsdf_fraction;
    } else if (depth > 0 && guides->probes) {
        p.probe = probes_at(guides->probes, s->position, s->normal);
        if (p.probe) {
            p.bsdf_fraction = p.probe->bsdf_fraction;
            p.light_chance = p.probe->light_chance;
        }
    }
    return p;
}

static struct vec3 sample_guide(const struct proposal *p, const float u[2]) {
    return p->leaf    ? ppg_leaf_sample(p->leaf, u)
           : p->probe ? probe_sample(p->probe, u)
                      : map_mixture_sample(&p->maps, u);
}

static float guide_pdf(const struct proposal *p, struct vec3 direction) {
    return p->leaf    ? ppg_leaf_pdf(p->leaf, direction)
           : p->probe ? probe_pdf(p->probe, direction)
                      : map_mixture_pdf(&p->maps, direction);
}

struct vec3 proposal_sample(const struct proposal *p, const struct shading *s, float choice,
                            const float u[2]) {
    return choice < p->bsdf_fraction ? bsdf_sample(s, u) : sample_guide(p, u);
}

struct proposal_pdf proposal_pdf(const struct proposal *p, const struct shading *s,
                                 struct vec3 direction) {
    struct proposal_pdf pdf = {.bsdf = bsdf_pdf(s, direction)};
    if (p->bsdf_fraction < 1)
        pdf.guide = guide_pdf(p, direction);
    pdf.mixture = p->bsdf_fraction * pdf.bsdf + (1 - p->bsdf_fraction) * pdf.guide;
    return pdf;
}
