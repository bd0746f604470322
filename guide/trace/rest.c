/* SPDX-License-Identifier: Apache-2.0 */
/* The samples after the first look, guided where there are maps. */

#include <stdlib.h>

#include "guide/trace/rest.h"
#include "guide/trace/state.h"
#include "guide/trace/team.h"
#include "guide/trace/tile_paths.h"
#include "guide/trace/tiles.h"

/* Progress of a part of the samples as progress of them all. */
struct progress_part {
    const struct fewray_render_settings *settings;
    double begin, end;
};

static void progress_of_part(void *user, const char *phase, double fraction) {
    const struct progress_part *part = user;
    part->settings->progress(part->settings->progress_user, phase,
                             part->begin + (part->end - part->begin) * fraction);
}

#define PASS_SAMPLES 64 /* most of a pixel in one pass over the picture */

/* A tile's number in rows of tiles from the upper left corner. */
static int tile_index(const struct fewray_film *film, int x, int y) {
    return y / TILE_SIZE * film_tile_columns(film) + x / TILE_SIZE;
}

struct fewray_rest {
    const struct fewray_render_settings *settings;
    struct integrator integrator;
    struct fewray_film *film;
    struct fewray_maps *maps;
    struct fewray_maps *learning; /* maps that the samples teach; NULL: none */
    struct fewray_look *kept;     /* the last samples before a refinement; NULL: not wanted */
    const struct bundle_tracer *bundles;
    int look;        /* samples a pixel of the look */
    int *done;       /* (tiles) samples a pixel after it */
    const int *more; /* (tiles) of this pass */
};

/* Sample s of a pixel; of the last ones before a refinement what they saw is kept. */
static struct bundle_start start_sample(const struct fewray_rest *rest, int x, int y, uint32_t seed,
                                        int s, int end) {
    struct bundle_start start = {
        x, y, sampler_start(seed, sample_index(rest->settings, rest->look + s)), .second = NULL};
    int kept = s - (end - KEPT_SAMPLES);
    if (rest->learning && rest->kept && kept >= 0) {
        size_t i =
            ((size_t)y * (size_t)rest->kept->width + (size_t)x) * KEPT_SAMPLES + (size_t)kept;
        start.record = &rest->kept->records[i];
        start.second = &rest->kept->seconds[i];
    }
    return start;
}

/* Samples first..end - 1 of each pixel, pixel by pixel in Morton order, so that a bundle's camera
 * rays lie close together. */
static void trace_tile(struct fewray_rest *rest, int x0, int y0, int x1, int y1, int first, int end,
                       struct fewray_render_stats *stats) {
    struct fewray_render_stats counts = {0};
    struct tile_paths paths = {.integrator = &rest->integrator,
                               .film = rest->film,
                               .stats = &counts,
                               .trace = rest->bundles->paths,
                               .group = GROUP_REST,
                               .learning = rest->learning};
    for (uint32_t k = 0; k < TILE_SIZE * TILE_SIZE; k++) {
        int x = x0 + (int)tile_morton_x(k), y = y0 + (int)tile_morton_x(k >> 1);
        if (x >= x1 || y >= y1 || is_cancelled(rest->settings))
            continue;
        uint32_t seed = pixel_seed(rest->settings, x, y);
        for (int s = first; s < end; s++) {
            const struct bundle_start start = start_sample(rest, x, y, seed, s, end);
            tile_paths_add(&paths, &start);
        }
    }
    tile_paths_end(&paths);
    if (first > 0) /* the pixels were counted by an earlier pass */
        counts.pixels_guided = 0;
    stats_add(stats, &counts);
}

static void rest_tile(void *user, int x0, int y0, int x1, int y1,
                      struct fewray_render_stats *stats) {
    struct fewray_rest *rest = user;
    const int tile = tile_index(rest->film, x0, y0);
    const int first = rest->done[tile], end = first + rest->more[tile];
    trace_tile(rest, x0, y0, x1, y1, first, end, stats);
    rest->done[tile] = end;
}

/* Samples a pixel before which the maps are refined next, the look included. */
static int next_refinement(int done) {
    int spp = MAPS_LEARN_SPP;
    while (spp <= done && spp <= INT32_MAX / 4)
        spp *= 4;
    return spp;
}

/* Samples a pixel, the look included, at which a pass ends: 4, 16, 64, 128, 192, ... Who waits
 * sees the whole picture early, and tiles stay short. The same for every run: where passes end
 * decides how the film's sums are rounded. */
static int next_pass(int done) {
    int spp = 4;
    while (spp <= done && spp < PASS_SAMPLES)
        spp *= 4;
    return spp > done ? spp : (done / PASS_SAMPLES + 1) * PASS_SAMPLES;
}

/* A pass of all tiles alike. */
struct even_pass {
    int end; /* samples a pixel after the look */
    bool learn, refine;
};

/* That which begins with sample `first` of `samples` after the look. */
static struct even_pass even_pass(bool learns, int look, int samples, int first) {
    const int refinement = next_refinement(look + first) - look;
    const bool learn = learns && refinement < samples;
    const int end = min_int(next_pass(look + first) - look, learn ? refinement : samples);
    return (struct even_pass){end, learn, learn && end == refinement};
}

bool rest_passes_agree(bool refine, int look, int spp_a, int spp_b, int first, int next) {
    const bool learns_a = refine && spp_a > MAPS_LEARN_SPP;
    const bool learns_b = refine && spp_b > MAPS_LEARN_SPP;
    if (learns_a != learns_b)
        return false;
    for (int f = 0; f < first || (f == first && next > 0);) {
        const struct even_pass a = even_pass(learns_a, look, spp_a - look, f);
        const struct even_pass b = even_pass(learns_b, look, spp_b - look, f);
        if (a.end != b.end || a.learn != b.learn || a.refine != b.refine || a.end <= f)
            return false;
        f = a.end;
    }
    return first <= spp_b - look;
}

/* New maps from all samples so far, new probes from the last ones, which saw more light than the
 * look. */
static int refine(struct fewray_rest *rest, struct fewray_error *error) {
    const struct fewray_team *team = rest->settings->team;
    struct fewray_maps *maps = rest->learning;
    int threads = film_threads(rest->settings);
    maps_refine(maps, threads);
    int status = maps_exchange(maps, team, error);
    rest->integrator.part++;
    if (status || !rest->kept)
        return status;
    if ((status = look_exchange(rest->kept, team, error)))
        return status;
    probes_destroy(&maps->probes);
    status = probes_create(rest->kept, threads, &maps->probes, error);
    rest->integrator.guides.probes = maps->probes;
    return fewray_team_agree(team, status, error);
}

int fewray_rest_create(const struct fewray_world *world, struct fewray_maps *maps,
                       const struct fewray_render_settings *settings, struct fewray_film *film,
                       struct fewray_rest **out, struct fewray_error *error) {
    struct fewray_rest *rest = *out = calloc(1, sizeof *rest);
    if (rest)
        rest->done = calloc((size_t)film_tile_count(film), sizeof *rest->done);
    if (!rest || !rest->done) {
        fewray_rest_destroy(out);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                           "no memory for the samples' counts");
    }
    rest->settings = settings;
    rest->integrator = film_integrator(world, film, settings);
    rest->film = film;
    rest->bundles = bundle_tracer_get();
    rest->maps = maps;
    rest->look = maps ? settings->initial : 0;
    if (maps)
        rest->integrator.guides = (struct guides){.maps = maps, .probes = maps->probes};
    return FEWRAY_OK;
}

void fewray_rest_destroy(struct fewray_rest **rest) {
    if (!*rest)
        return;
    fewray_look_destroy(&(*rest)->kept);
    free((*rest)->done);
    free(*rest);
    *rest = NULL;
}

/* Whether some tile gets enough samples to make new probes of. */
static bool can_keep(const struct fewray_rest *rest) {
    for (int t = 0; t < film_tile_count(rest->film); t++)
        if (rest->more[t] >= KEPT_SAMPLES)
            return true;
    return false;
}

int fewray_rest_pass(struct fewray_rest *rest, const struct fewray_pass *pass,
                     struct fewray_render_stats *stats, struct fewray_error *error) {
    const struct fewray_film *film = rest->film;
    struct fewray_render_settings part = *rest->settings;
    struct progress_part share = {rest->settings, pass->progress_begin, pass->progress_end};
    part.progress = part.progress ? progress_of_part : NULL;
    part.progress_user = &share;
    rest->more = pass->tile_samples;
    rest->learning = pass->learn && rest->maps && rest->maps->sums ? rest->maps : NULL;
    int status = FEWRAY_OK;
    if (rest->learning && rest->maps->probes && !rest->kept && can_keep(rest))
        status = look_create(film->width, film->height, KEPT_SAMPLES, true, &rest->kept, error);
    status = fewray_team_agree(rest->settings->team, status, error);
    if (!status)
        status =
            tiles_run(film->width, film->height, &part, "render", rest_tile, rest, stats, error);
    return status || !rest->learning || !pass->refine ? status : refine(rest, error);
}

const struct fewray_look *rest_kept(const struct fewray_rest *rest) {
    return rest && rest->learning ? rest->kept : NULL;
}

uint32_t rest_part(const struct fewray_rest *rest) {
    return rest ? rest->integrator.part : 0;
}

/* Goes on where the state was read; its tiles before `next` have their samples of the pass.
 * Returns the sample after the look with which the pass begins. */
static int resume(struct fewray_rest *rest, struct fewray_state *state) {
    if (!state_resumes(state, STATE_REST))
        return 0;
    rest->integrator.part = state->read_part;
    rest->kept = state->read_kept;
    state->read_kept = NULL;
    for (int t = 0; t < film_tile_count(rest->film); t++)
        rest->done[t] = t < state->next ? state->end : state->first;
    return state->first;
}

/* Passes of all tiles alike. */
static int trace_evenly(struct fewray_rest *rest, int *more, struct fewray_render_stats *stats,
                        struct fewray_error *error) {
    const bool learns = rest->maps && rest->maps->sums;
    const int samples = rest->settings->spp - rest->look;
    int status = FEWRAY_OK;
    for (int first = resume(rest, rest->settings->state), end; first < samples && !status;
         first = end) {
        const struct even_pass even = even_pass(learns, rest->look, samples, first);
        end = even.end;
        for (int t = 0; t < film_tile_count(rest->film); t++)
            more[t] = end - first;
        const struct fewray_pass pass = {more, even.learn, even.refine, (double)first / samples,
                                         (double)end / samples};
        state_enter(rest->settings->state, STATE_REST, first, end);
        status = fewray_rest_pass(rest, &pass, stats, error);
    }
    if (!status && rest->settings->state) {
        rest->settings->state->resumes = false;
        state_enter(rest->settings->state, STATE_REST, samples, samples);
    }
    return status;
}

int fewray_trace_rest(const struct fewray_world *world, struct fewray_maps *maps,
                      const struct fewray_render_settings *settings, struct fewray_film *film,
                      struct fewray_render_stats *stats, struct fewray_error *error) {
    struct fewray_rest *rest = NULL;
    int status = fewray_rest_create(world, maps, settings, film, &rest, error);
    int *more = malloc((size_t)film_tile_count(film) * sizeof *more);
    if (!status && !more)
        status =
            fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the samples' counts");
    status = fewray_team_agree(settings->team, status, error);
    if (!status && settings->state) {
        settings->state->look_samples = rest->look;
        settings->state->rest = rest;
    }
    if (!status)
        status = trace_evenly(rest, more, stats, error);
    if (settings->state)
        settings->state->rest = NULL;
    free(more);
    fewray_rest_destroy(&rest);
    return status ? status : fewray_film_share(film, settings->team, error);
}
