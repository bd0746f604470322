/* SPDX-License-Identifier: Apache-2.0 */
/* The guide of another renderer: its first look as records, and its questions. */

#include <math.h>
#include <stdlib.h>

#include "fewray/guiding.h"
#include "guide/host/host.h"
#include "guide/odis/maps.h"
#include "guide/odis/probes.h"
#include "guide/trace/film.h"
#include "guide/trace/proposal.h"

struct fewray_guide {
    struct fewray_maps *maps;
    int threads;
};

void fewray_guide_options_init(struct fewray_guide_options *options) {
    *options =
        (struct fewray_guide_options){.bsdf_fraction = -1, .map_bins = 32, .share_maps = true};
}

/* The settings of a render that has this guide. */
static struct fewray_render_settings settings_of(const struct fewray_guide_options *options,
                                                 const struct fewray_guide_look *look) {
    struct fewray_render_settings settings;
    fewray_render_settings_init(&settings);
    settings.width = look->width;
    settings.height = look->height;
    settings.threads = options->threads;
    settings.bsdf_fraction = options->bsdf_fraction;
    settings.map_bins = options->map_bins;
    settings.share_maps = options->share_maps;
    settings.weights_path = options->weights_path;
    settings.cancel = options->cancel;
    settings.probes = look->second_albedo != NULL;
    settings.refine = false; /* the host's samples aren't seen */
    return settings;
}

static int check_options(const struct fewray_guide_options *o, struct fewray_error *error) {
    if (!(o->bsdf_fraction <= 1))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "the guide's bsdf_fraction is %g; at most 1 is possible",
                           (double)o->bsdf_fraction);
    if (o->map_bins != 32 && o->map_bins != 16 && o->map_bins != 8)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "the guide's map_bins is %d; 32, 16 and 8 are possible", o->map_bins);
    return FEWRAY_OK;
}

int fewray_guide_create(const struct fewray_guide_look *look,
                        const struct fewray_guide_options *options, struct fewray_guide **out,
                        struct fewray_guide_stats *stats, struct fewray_error *error) {
    struct fewray_guide_options defaults;
    struct fewray_guide_stats counts = {0};
    struct fewray_render_stats work = {0};
    struct fewray_look *records = NULL;
    fewray_guide_options_init(&defaults);
    const struct fewray_render_settings settings = settings_of(options ? options : &defaults, look);
    struct fewray_guide *guide = *out = NULL;
    int status = check_options(options ? options : &defaults, error);
    if (!status)
        status = host_look_create(look, film_threads(&settings), &records, &counts, error);
    if (!status && !(guide = calloc(1, sizeof(*guide))))
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the guide");
    if (!status)
        status = fewray_maps_create(records, &settings, &guide->maps, &work, error);
    if (records)
        fewray_look_destroy(&records);
    if (status) {
        free(guide);
        return status;
    }
    guide->threads = film_threads(&settings);
    counts.maps = guide->maps->count;
    counts.probes = guide->maps->probes ? guide->maps->probes->fine.voxels.count : 0;
    if (stats)
        *stats = counts;
    *out = guide;
    return FEWRAY_OK;
}

void fewray_guide_destroy(struct fewray_guide **guide) {
    if (!*guide)
        return;
    fewray_maps_destroy(&(*guide)->maps);
    free(*guide);
    *guide = NULL;
}

static struct vec3 load3(const float *v) {
    return vec(v[0], v[1], v[2]);
}

static void store3(struct vec3 v, float *out) {
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static int clamp_int(int i, int low, int high) {
    return i < low ? low : i > high ? high : i;
}

static struct fewray_guide_at at_proposal(const struct proposal *p) {
    struct fewray_guide_at at = {p->bsdf_fraction, p->light_chance, p->maps.count, {0},
                                 {NULL},           p->probe};
    for (int k = 0; k < p->maps.count; k++) {
        at.maps[k] = p->maps.maps[k];
        at.share[k] = p->maps.share[k];
    }
    return at;
}

static struct proposal proposal_of(const struct fewray_guide_at *at) {
    struct proposal p = {.bsdf_fraction = at->bsdf_fraction, .probe = at->probe};
    p.maps.count = at->count;
    for (int k = 0; k < at->count; k++) {
        p.maps.maps[k] = at->maps[k];
        p.maps.share[k] = at->share[k];
    }
    return p;
}

struct fewray_guide_at fewray_guide_first(const struct fewray_guide *guide, int x, int y,
                                          const float position[3], const float normal[3]) {
    const struct fewray_maps *maps = guide->maps;
    const struct proposal p =
        proposal_first(maps, clamp_int(x, 0, maps->width - 1), clamp_int(y, 0, maps->height - 1),
                       load3(position), load3(normal));
    return at_proposal(&p);
}

struct fewray_guide_at fewray_guide_later(const struct fewray_guide *guide, const float position[3],
                                          const float normal[3], bool last) {
    const struct guides guides = {.maps = guide->maps, .probes = guide->maps->probes};
    struct proposal p = proposal_bsdf();
    if (guides.probes)
        p = proposal_later(&guides, last, load3(position), load3(normal));
    return at_proposal(&p);
}

void fewray_guide_sample(const struct fewray_guide_at *at, const float u[2], float direction[3]) {
    const struct proposal p = proposal_of(at);
    store3(proposal_draw(&p, u), direction);
}

float fewray_guide_pdf(const struct fewray_guide_at *at, const float direction[3]) {
    const struct proposal p = proposal_of(at);
    return proposal_guide_pdf(&p, load3(direction));
}

static struct fewray_guide_at at_point(const struct fewray_guide *guide,
                                       const struct fewray_guide_points *points, size_t i) {
    const float *position = points->position + 3 * i, *normal = points->normal + 3 * i;
    return points->pixel ? fewray_guide_first(guide, points->pixel[2 * i], points->pixel[2 * i + 1],
                                              position, normal)
                         : fewray_guide_later(guide, position, normal, points->last);
}

void fewray_guide_sample_many(const struct fewray_guide *guide,
                              const struct fewray_guide_points *points, const float *u,
                              float *direction, float *pdf, float *fraction) {
#pragma omp parallel for schedule(static) num_threads(guide->threads)
    for (size_t i = 0; i < points->count; i++) {
        const struct fewray_guide_at at = at_point(guide, points, i);
        const bool guided = at.bsdf_fraction < 1;
        store3(vec(0, 0, 0), direction + 3 * i);
        if (guided)
            fewray_guide_sample(&at, u + 2 * i, direction + 3 * i);
        pdf[i] = guided ? fewray_guide_pdf(&at, direction + 3 * i) : 0;
        if (fraction)
            fraction[i] = at.bsdf_fraction;
    }
}

void fewray_guide_pdf_many(const struct fewray_guide *guide,
                           const struct fewray_guide_points *points, const float *direction,
                           float *pdf, float *fraction) {
#pragma omp parallel for schedule(static) num_threads(guide->threads)
    for (size_t i = 0; i < points->count; i++) {
        const struct fewray_guide_at at = at_point(guide, points, i);
        pdf[i] = at.bsdf_fraction < 1 ? fewray_guide_pdf(&at, direction + 3 * i) : 0;
        if (fraction)
            fraction[i] = at.bsdf_fraction;
    }
}

void fewray_guide_irradiance_many(const struct fewray_guide *guide,
                                  const struct fewray_guide_points *points, float *irradiance,
                                  float *confidence) {
    const struct fewray_maps *maps = guide->maps;
#pragma omp parallel for schedule(static) num_threads(guide->threads)
    for (size_t i = 0; i < points->count; i++) {
        const int x = clamp_int(points->pixel[2 * i], 0, maps->width - 1);
        const int y = clamp_int(points->pixel[2 * i + 1], 0, maps->height - 1);
        store3(maps_irradiance(maps, x, y, load3(points->normal + 3 * i), &confidence[i]),
               irradiance + 3 * i);
    }
}
