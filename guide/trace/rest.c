/* SPDX-License-Identifier: Apache-2.0 */
/* The samples after the first look, guided where there are maps. */

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

#define KEPT_SAMPLES 2 /* of a pixel between two refinements, for new probes */

struct rest_job {
    const struct fewray_render_settings *settings;
    struct integrator integrator;
    struct fewray_film *film;
    struct fewray_maps *learning; /* maps that the samples teach; NULL: none */
    struct fewray_look *kept;     /* the last samples before a refinement; NULL: not wanted */
    const struct bundle_tracer *bundles;
    int look;                     /* samples a pixel of the look */
    int first, end;               /* samples a pixel after it: first <= s < end */
};

/* Where what sample s of a pixel saw is to be written. */
static struct path_notes notes_for(const struct rest_job *job, int x, int y, int s,
                                   struct look_record *record) {
    struct path_notes notes = {.record = record};
    int kept = s - (job->end - KEPT_SAMPLES);
    if (job->kept && kept >= 0) {
        size_t i = ((size_t)y * (size_t)job->kept->width + (size_t)x) * KEPT_SAMPLES + (size_t)kept;
        notes.record = &job->kept->records[i];
        notes.second = &job->kept->seconds[i];
    }
    return notes;
}

/* Where no sample's path has to be remembered. Pixel by pixel in Morton order, so that a bundle's
 * camera rays lie close together. */
static void bundle_tile(struct rest_job *job, int x0, int y0, int x1, int y1,
                        struct fewray_render_stats *stats) {
    struct fewray_render_stats counts = {0};
    struct tile_paths paths = {.integrator = &job->integrator,
                               .film = job->film,
                               .stats = &counts,
                               .trace = job->bundles->paths,
                               .group = GROUP_REST};
    for (uint32_t k = 0; k < TILE_SIZE * TILE_SIZE; k++) {
        int x = x0 + (int)tile_morton_x(k), y = y0 + (int)tile_morton_x(k >> 1);
        if (x >= x1 || y >= y1 || is_cancelled(job->settings))
            continue;
        uint32_t seed = pixel_seed(job->settings, x, y);
        for (int s = job->first; s < job->end; s++)
            tile_paths_add(&paths,
                           &(struct bundle_start){
                               x, y, sampler_start(seed, sample_index(job->settings, job->look + s)), .second = NULL});
    }
    tile_paths_end(&paths);
    if (job->first > 0) /* the pixels were counted by an earlier part */
        counts.pixels_guided = 0;
    stats_add(stats, &counts);
}

/* Where the maps learn from each sample. */
static void learning_tile(struct rest_job *job, int x0, int y0, int x1, int y1,
                          struct fewray_render_stats *stats) {
    struct look_record record;
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1 && !is_cancelled(job->settings); x++) {
            uint32_t seed = pixel_seed(job->settings, x, y);
            struct pixel_sums sums = {0};
            bool guided = false;
            for (int s = job->first; s < job->end; s++) {
                struct sampler sampler =
                    sampler_start(seed, sample_index(job->settings, job->look + s));
                struct path_notes notes = notes_for(job, x, y, s, &record);
                struct path_sample p = trace_path(&job->integrator, x, y, &sampler, &notes);
                pixel_sums_add(&sums, &p);
                stats->rays += p.rays;
                guided |= p.guided;
                maps_learn(job->learning, x, y, notes.record);
            }
            stats->paths += job->end - job->first;
            stats->dropped += sums.dropped;
            stats->pixels_guided += guided && job->first == 0;
            film_add(job->film, x, y, GROUP_REST, &sums);
        }
}

static void rest_tile(void *user, int x0, int y0, int x1, int y1,
                      struct fewray_render_stats *stats) {
    struct rest_job *job = user;
    if (job->learning)
        learning_tile(job, x0, y0, x1, y1, stats);
    else
        bundle_tile(job, x0, y0, x1, y1, stats);
}

/* Samples a pixel before which the maps are refined next, the look included. */
static int next_refinement(int done) {
    int spp = MAPS_LEARN_SPP;
    while (spp <= done && spp <= INT32_MAX / 4)
        spp *= 4;
    return spp;
}

/* Samples first..end - 1 of each pixel. */
static int trace_part(struct rest_job *job, int samples, struct fewray_render_stats *stats,
                      struct fewray_error *error) {
    const struct fewray_render_settings *settings = job->settings;
    struct fewray_render_settings part = *settings;
    struct progress_part share = {settings, (double)job->first / samples,
                                  (double)job->end / samples};
    part.progress = settings->progress ? progress_of_part : NULL;
    part.progress_user = &share;
    return tiles_run(job->film->width, job->film->height, &part, "render", rest_tile, job, stats,
                     error);
}

/* New maps from all samples so far, new probes from the last ones, which saw more light than the
 * look. */
static int refine(struct rest_job *job, struct fewray_maps *maps, struct fewray_error *error) {
    const struct fewray_team *team = job->settings->team;
    int threads = film_threads(job->settings);
    maps_refine(maps, threads);
    int status = maps_exchange(maps, team, error);
    job->integrator.part++;
    if (status || !job->kept)
        return status;
    if ((status = look_exchange(job->kept, team, error)))
        return status;
    probes_destroy(&maps->probes);
    status = probes_create(job->kept, threads, &maps->probes, error);
    job->integrator.guides.probes = maps->probes;
    return fewray_team_agree(team, status, error);
}

int fewray_trace_rest(const struct fewray_world *world, struct fewray_maps *maps,
                      const struct fewray_render_settings *settings, struct fewray_film *film,
                      struct fewray_render_stats *stats, struct fewray_error *error) {
    int look = maps ? settings->initial : 0, samples = settings->spp - look, status = FEWRAY_OK;
    struct rest_job job = {
        .settings = settings,
        .integrator = film_integrator(world, film, settings),
        .film = film,
        .bundles = bundle_tracer_get(),
        .look = look,
    };
    if (maps)
        job.integrator.guides = (struct guides){.maps = maps, .probes = maps->probes};
    while (job.end < samples && !status) {
        job.first = job.end;
        int refinement = next_refinement(look + job.first) - look;
        bool last = !maps || !maps->sums || refinement >= samples;
        job.end = last ? samples : refinement;
        job.learning = last ? NULL : maps;
        if (job.learning && maps->probes && !job.kept && job.end - job.first >= KEPT_SAMPLES)
            status = look_create(film->width, film->height, KEPT_SAMPLES, true, &job.kept, error);
        status = fewray_team_agree(settings->team, status, error);
        status = status ? status : trace_part(&job, samples, stats, error);
        if (!status && !last)
            status = refine(&job, maps, error);
    }
    fewray_look_destroy(&job.kept);
    return status ? status : fewray_film_share(film, settings->team, error);
}
