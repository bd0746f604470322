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

void fewray_guide_options_init(struct fewray_guide_options *options) {
    *options = (struct fewray_guide_options){.bsdf_fraction = -1,
                                             .map_bins = 32,
                                             .share_maps = true,
                                             .bounce_share = 1,
                                             .bounce_variance = INFINITY};
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
    settings.refine = options->learns;
    settings.spp = options->learns ? MAPS_LEARN_SPP + 1 : 1; /* else no sums are kept */
    settings.bounce_share = options->bounce_share;
    settings.bounce_variance = options->bounce_variance;
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
    if (!(o->bounce_share >= 0 && o->bounce_share <= 1 && o->bounce_variance >= 0))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "the guide's bounce_share is %g and bounce_variance %g; 0 to 1, and 0 "
                           "or more, are possible",
                           (double)o->bounce_share, (double)o->bounce_variance);
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
    guide->samples = look->samples;
    guide->learns = settings.refine;
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
                       host_load(position), host_load(normal));
    return at_proposal(&p);
}

struct fewray_guide_at fewray_guide_later(const struct fewray_guide *guide, const float position[3],
                                          const float normal[3], bool last) {
    const struct guides guides = {.maps = guide->maps, .probes = guide->maps->probes};
    struct proposal p = proposal_bsdf();
    if (guides.probes)
        p = proposal_later(&guides, last, host_load(position), host_load(normal));
    return at_proposal(&p);
}

/* A host's random number may have been rounded up to 1. */
static float below_one(float u) {
    return u >= 0 ? fminf(u, 0x1.fffffep-1f) : 0;
}

void fewray_guide_sample(const struct fewray_guide_at *at, const float u[2], float direction[3]) {
    struct vec3 d = vec(0, 0, 0);
    if (at->bsdf_fraction < 1) {
        const struct proposal p = proposal_of(at);
        d = proposal_draw(&p, (float[2]){below_one(u[0]), below_one(u[1])});
    }
    host_store(d, direction);
}

float fewray_guide_pdf(const struct fewray_guide_at *at, const float direction[3]) {
    if (!(at->bsdf_fraction < 1))
        return 0;
    const struct proposal p = proposal_of(at);
    return proposal_guide_pdf(&p, host_load(direction));
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
        fewray_guide_sample(&at, u + 2 * i, direction + 3 * i);
        pdf[i] = fewray_guide_pdf(&at, direction + 3 * i);
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
        pdf[i] = fewray_guide_pdf(&at, direction + 3 * i);
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
        host_store(maps_irradiance(maps, x, y, host_load(points->normal + 3 * i), &confidence[i]),
                   irradiance + 3 * i);
    }
}

float fewray_guide_look_weight(const struct fewray_guide *guide, int x, int y, int guided) {
    const struct fewray_maps *maps = guide->maps;
    const float noise =
        maps_look_noise(maps, clamp_int(x, 0, maps->width - 1), clamp_int(y, 0, maps->height - 1));
    const float a = (float)guide->samples, b = guided > 0 ? (float)guided : 0;
    return a / (a + b * noise);
}

void fewray_guide_look_weights(const struct fewray_guide *guide, int guided, float *share) {
    const int width = guide->maps->width, height = guide->maps->height;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            share[(size_t)y * (size_t)width + (size_t)x] =
                fewray_guide_look_weight(guide, x, y, guided);
}
