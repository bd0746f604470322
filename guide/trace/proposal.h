/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_PROPOSAL_H
#define FEWRAY_GUIDE_PROPOSAL_H

/* What a path vertex's next direction is drawn from: its BSDF, and what guides there, in a
 * one-sample mixture. The same for every kind of guide. */

#include "guide/bsdf/bsdf.h"
#include "guide/odis/maps.h"
#include "guide/odis/probes.h"

struct ppg;
struct ppg_leaf;

/* The guides of a path; NULL where there is none. */
struct guides {
    const struct fewray_maps *maps; /* of the first vertex */
    const struct probes *probes;    /* of those after it */
    const struct ppg *ppg;          /* of all, instead of both */
};

struct proposal {
    float bsdf_fraction; /* share of the directions that the BSDF draws; 1: nothing guides here */
    float light_chance;  /* with which a shadow ray is worth tracing here, (0, 1] */
    struct map_mixture maps;
    const struct probe *probe;
    const struct ppg_leaf *leaf;
};

struct proposal_pdf {
    float mixture;     /* solid angle; (1 - delta_chance) (fraction bsdf + (1 - fraction) guide) */
    float bsdf, guide; /* of the two where the direction isn't a perfectly specular one */
};

/* Nothing but the BSDF. */
static inline struct proposal proposal_bsdf(void) {
    return (struct proposal){.bsdf_fraction = 1, .light_chance = 1};
}

/* Which vertex of a path wants a proposal. */
struct path_place {
    int x, y;   /* the path's pixel; of the first vertex alone */
    bool first; /* the first vertex that isn't perfectly specular */
    bool last;  /* the bounce from here can only find lights */
};

/* At a first vertex, by maps alone; normal: unit, towards the viewer. */
struct proposal proposal_first(const struct fewray_maps *maps, int x, int y, struct vec3 position,
                               struct vec3 normal);
/* At a later one; guides->probes must be there. last: as in path_place. */
struct proposal proposal_later(const struct guides *guides, bool last, struct vec3 position,
                               struct vec3 normal);
/* A direction of the guide alone, and its density (solid angle); bsdf_fraction < 1. */
struct vec3 proposal_draw(const struct proposal *p, const float u[2]);
float proposal_guide_pdf(const struct proposal *p, struct vec3 direction);

struct proposal proposal_at(const struct guides *guides, struct path_place place,
                            const struct shading *s);
/* choice, u: in [0, 1). */
/* False where nothing is drawn. *pdf isn't filled for a perfectly specular direction. */
bool proposal_sample(const struct proposal *p, const struct shading *s, float choice,
                     const float u[2], struct bsdf_sample *out, struct proposal_pdf *pdf);
struct proposal_pdf proposal_pdf(const struct proposal *p, const struct shading *s,
                                 struct vec3 direction);

#endif
