/* SPDX-License-Identifier: Apache-2.0 */
/* The planner's measurements and memory; what it decides by stands in plan.c. */

#include "pipeline/planner.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "pipeline/change.h"
#include "pipeline/clock.h"
#include "pipeline/plan.h"
#include "pipeline/probe.h"

#define MAX_SPP_DEFAULT 4096
#define LOOK_RECORDS    16000 /* of a first look, that maps can be made of */
#define LOOK_MOST       8     /* samples a pixel, for that */
#define GUIDED_COST     1.8   /* of a sample, over a plain one: 1.7 to 2.2 in the bench's scenes */
#define GUIDE_SAMPLES   1.5   /* that could be traced while the maps are made */
#define GUIDED_NOISE    0.4   /* of the bounce that a guide leaves */
#define LEARN_SPP       3.5   /* samples a pixel; of fewer, maps learn noise */
#define EDGE_SAMPLES    0.25  /* that could be traced while the edges' camera rays are */
#define EDGE_SHARE      0.2   /* of the time that they may take */
#define FAST_SHARE      0.15  /* of the time that the default denoiser may take */
#define DEVELOP_SECONDS 4e-8  /* a pixel: the film becomes a frame */
#define EXIT_SECONDS    0.02  /* and a tenth of the loading: the scene's memory is given back */
#define EXIT_SHARE      0.1

struct planner {
    const struct fewray_job *job;
    const struct fewray_goal *goal;
    struct fewray_plan plan;
    double start, loaded_s, lap; /* clock_seconds() of the start and of the last pass; load's */
    int width, height, tiles;
    int look;         /* samples a pixel of the first look; 0: not guided */
    int *have, *more; /* (tiles) samples a pixel, the look included; of the next pass */
    float *needs;     /* (tiles) */
    struct plan_clock clock;
    double write_s, edges_s;
    bool picture_due; /* after this pass */
    double denoise_s;
    struct change *change; /* NULL: no pictures are compared */
};

bool planner_has_goal(const struct fewray_goal *goal) {
    return goal->seconds > 0 || goal->error > 0 || goal->adaptive;
}

/* Adds a sentence to the plan. */
static void __attribute__((format(printf, 2, 3)))
tell(struct planner *planner, const char *format, ...) {
    struct fewray_plan *plan = &planner->plan;
    if (plan->reason_count == FEWRAY_PLAN_REASONS)
        return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(plan->reasons[plan->reason_count++], sizeof *plan->reasons, format, arguments);
    va_end(arguments);
}

static double elapsed(const struct planner *planner) {
    return planner->goal->spent + clock_seconds() - planner->start;
}

int planner_create(const struct fewray_job *job, double start, struct planner **out,
                   struct fewray_error *error) {
    struct planner *planner = *out = calloc(1, sizeof *planner);
    if (!planner)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the planner");
    planner->job = job;
    planner->goal = &job->goal;
    planner->start = start;
    planner->loaded_s = elapsed(planner);
    planner->clock.total = job->goal.seconds;
    planner->plan = (struct fewray_plan){.made = true,
                                         .wanted_s = job->goal.seconds,
                                         .wanted_error = job->goal.error,
                                         .estimated_error = NAN};
    return FEWRAY_OK;
}

void planner_destroy(struct planner **planner) {
    if (!*planner)
        return;
    change_destroy(&(*planner)->change);
    free((*planner)->have);
    free((*planner)->more);
    free((*planner)->needs);
    free(*planner);
    *planner = NULL;
}

/* Looks at the clock. */
static void update_clock(struct planner *planner) {
    struct plan_clock *clock = &planner->clock;
    const double develop = DEVELOP_SECONDS * planner->width * planner->height;
    clock->left = clock->total - elapsed(planner);
    clock->picture = develop + planner->denoise_s;
    clock->tail = clock->picture + planner->write_s + planner->edges_s + EXIT_SECONDS +
                  EXIT_SHARE * planner->loaded_s;
}

static int create_tables(struct planner *planner, struct fewray_error *error) {
    const int columns = (planner->width + FEWRAY_TILE_SIZE - 1) / FEWRAY_TILE_SIZE;
    const int rows = (planner->height + FEWRAY_TILE_SIZE - 1) / FEWRAY_TILE_SIZE;
    planner->tiles = columns * rows;
    planner->have = calloc((size_t)planner->tiles, sizeof *planner->have);
    planner->more = calloc((size_t)planner->tiles, sizeof *planner->more);
    planner->needs = calloc((size_t)planner->tiles, sizeof *planner->needs);
    if (!planner->have || !planner->more || !planner->needs)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the planner");
    return change_create(planner->width, planner->height, &planner->change, error);
}

/* Noise without a guide over noise with one, by the share of it that the bounce makes. */
static double expected_gain(const struct fewray_pilot *pilot) {
    const double share =
        pilot->variance > 0 ? fmin(pilot->bounce_variance / pilot->variance, 1) : 1;
    return 1 / (1 - share * (1 - GUIDED_NOISE)) / GUIDED_COST;
}

static void choose_model(struct planner *planner, const struct probe_seconds *probe,
                         enum fewray_denoise_model *model) {
    const double left = planner->clock.left;
    planner->denoise_s = probe->denoise[*model];
    if (!planner->job->denoised || !planner->goal->any_model || planner->goal->seconds <= 0 ||
        planner->denoise_s <= FAST_SHARE * left)
        return;
    *model = FEWRAY_DENOISE_FAST;
    tell(planner, "The denoiser's fast model: the default one would take %.2f s of %.2f s left.",
         planner->denoise_s, left);
    planner->denoise_s = probe->denoise[*model];
}

static void choose_guide(struct planner *planner, const struct fewray_pilot *pilot,
                         const struct fewray_render_settings *settings, bool *guided) {
    const double gain = expected_gain(pilot);
    const double guide_s = GUIDE_SAMPLES * planner->clock.sample;
    if (planner->job->guided && !*guided)
        tell(planner,
             "No guide: too little noise to pay for one, %.2f of the squared radiance in one "
             "sample, "
             "of which %.0f %% comes by the first bounce.",
             pilot->variance, 100 * fmin(pilot->bounce_variance / pilot->variance, 1));
    if (*guided && planner->goal->seconds > 0) {
        *guided = plan_guide_fits(&planner->clock, guide_s, gain);
        tell(planner, "%s: %.2f s for maps buy noise divided by %.1f, expected from the pilot.",
             *guided ? "Guided" : "No guide, too little time", guide_s, gain);
    } else if (*guided) {
        *guided = gain > 1 || planner->goal->error <= 0;
        tell(planner, "%s: the pilot expects noise divided by %.1f at equal time.",
             *guided ? "Guided" : "No guide", gain);
    }
    planner->look = *guided ? settings->initial : 0;
}

static void choose_edges(struct planner *planner, struct fewray_render_settings *settings) {
    planner->edges_s = EDGE_SAMPLES * planner->clock.sample;
    if (settings->camera_rays == 0)
        planner->edges_s = 0;
    if (planner->edges_s <= EDGE_SHARE * planner->clock.left || planner->goal->seconds <= 0)
        return;
    tell(planner, "No camera rays for edges: they would take about %.2f s of %.2f s left.",
         planner->edges_s, planner->clock.left);
    settings->camera_rays = 0;
    planner->edges_s = 0;
}

/* A small picture's first look takes more samples, if there will be many. */
static void choose_look(struct planner *planner, const struct fewray_pilot *pilot,
                        struct fewray_render_settings *settings, bool *guided) {
    const double pixels = (double)planner->width * planner->height;
    const int samples = (int)ceil(LOOK_RECORDS / pixels);
    struct fewray_pilot larger = *pilot;
    larger.tiny = false;
    const double budget = planner->goal->seconds > 0 ? plan_affordable(&planner->clock)
                          : planner->goal->error > 0 ? 0
                                                     : settings->spp;
    if (!planner->job->guided || !pilot->tiny || samples > LOOK_MOST || budget < 8 * samples ||
        !fewray_pilot_wants_guide(&larger))
        return;
    settings->initial = samples;
    *guided = true;
    tell(planner, "A first look of %d samples a pixel: of fewer, maps of a small picture are poor.",
         samples);
}

int planner_prepare(struct planner *planner, const struct fewray_pilot *pilot, double pilot_s,
                    struct fewray_render_settings *settings, bool *guided,
                    enum fewray_denoise_model *model, struct fewray_error *error) {
    const int width = planner->width = pilot->width, height = planner->height = pilot->height;
    int status = create_tables(planner, error);
    struct probe_seconds probe = {0};
    if (!status && planner->goal->seconds > 0)
        status =
            probe_run(planner->job, settings->threads, (long long)width * height, &probe, error);
    if (status)
        return status;
    planner->write_s = probe.write;
    planner->denoise_s = probe.denoise[*model];
    planner->clock.sample = pilot_s / (pilot->paths > 0 ? pilot->paths : 1) * width * height;
    if (planner->goal->seconds > 0)
        tell(planner, "A sample of every pixel takes about %.3g s by the pilot.",
             planner->clock.sample);
    update_clock(planner);
    choose_model(planner, &probe, model);
    choose_edges(planner, settings);
    update_clock(planner);
    choose_look(planner, pilot, settings, guided);
    choose_guide(planner, pilot, settings, guided);
    update_clock(planner);
    if (planner->goal->seconds > 0) /* whether maps learn */
        settings->spp = (int)fmax(1, fmin(plan_affordable(&planner->clock), MAX_SPP_DEFAULT));
    else if (planner->goal->error > 0)
        settings->spp = planner->goal->max_spp > 0 ? planner->goal->max_spp : MAX_SPP_DEFAULT;
    if (settings->initial > settings->spp)
        settings->initial = settings->spp;
    for (int t = 0; t < planner->tiles; t++)
        planner->have[t] = planner->look;
    planner->plan.spp = planner->look;
    return FEWRAY_OK;
}

static double mean_of(const int *samples, int tiles) {
    double sum = 0;
    for (int t = 0; t < tiles; t++)
        sum += samples[t];
    return sum / tiles;
}

static struct plan_step next_step(struct planner *planner) {
    const struct fewray_goal *goal = planner->goal;
    const double done = mean_of(planner->have, planner->tiles);
    const double most = goal->max_spp > 0 ? goal->max_spp : MAX_SPP_DEFAULT;
    if (goal->seconds > 0)
        return plan_step_in_time(&planner->clock, done);
    if (goal->error <= 0)
        return plan_step_for_samples(done, planner->job->settings.spp);
    const struct plan_step step =
        plan_step_for_error(done, planner->change->error, goal->error, most);
    planner->plan.hit_max_spp = step.more <= 0 && planner->change->error > goal->error;
    return step;
}

/* Of all samples that there will be, for the progress bar. */
static double progress_at(const struct planner *planner, double done) {
    const struct fewray_goal *goal = planner->goal;
    if (goal->seconds > 0)
        return fmin(1, elapsed(planner) / goal->seconds);
    if (goal->error <= 0)
        return done / planner->job->settings.spp;
    if (planner->change->error < 0)
        return 0;
    const double needed = done * pow(planner->change->error / goal->error, 1 / PLAN_SLOPE);
    return needed > done ? done / needed : 1;
}

bool planner_next_pass(struct planner *planner, struct fewray_pass *pass) {
    update_clock(planner);
    const double done = mean_of(planner->have, planner->tiles);
    const struct plan_step step = next_step(planner);
    const bool by_needs = planner->goal->adaptive && planner->change->error >= 0;
    *pass = (struct fewray_pass){.tile_samples = planner->more};
    if (step.more <= 0)
        return false;
    if (by_needs)
        plan_needs(planner->change->cells, planner->change->columns, planner->change->rows,
                   planner->needs, planner->change->tile_columns, planner->change->tile_rows);
    plan_deal(by_needs ? planner->needs : NULL, planner->have, planner->tiles, step.more,
              (uint32_t)planner->plan.passes, planner->more);
    const double more = mean_of(planner->more, planner->tiles);
    if (more <= 0)
        return false;
    planner->plan.adaptive |= by_needs;
    planner->picture_due = step.picture;
    planner->plan.predicted_s =
        elapsed(planner) + more * planner->clock.sample + planner->clock.tail;
    pass->learn = pass->refine = (step.picture || step.part) && done + more > LEARN_SPP;
    pass->progress_begin = progress_at(planner, done);
    pass->progress_end = fmax(pass->progress_begin, progress_at(planner, done + more));
    planner->lap = clock_seconds();
    return true;
}

void planner_passed(struct planner *planner) {
    const double seconds = clock_lap(&planner->lap);
    planner->clock.sample = seconds / mean_of(planner->more, planner->tiles);
    planner->clock.measured = true;
    for (int t = 0; t < planner->tiles; t++)
        planner->have[t] += planner->more[t];
    planner->plan.spp = mean_of(planner->have, planner->tiles);
    planner->plan.passes++;
}

int planner_least_samples(const struct planner *planner) {
    int least = planner->have[0];
    for (int t = 1; t < planner->tiles; t++)
        least = planner->have[t] < least ? planner->have[t] : least;
    return least;
}

void planner_edges_traced(struct planner *planner) {
    planner->edges_s = 0;
    planner->lap = clock_seconds();
}

bool planner_wants_picture(const struct planner *planner) {
    return planner->picture_due;
}

void planner_see(struct planner *planner, const struct fewray_frame *frame) {
    change_see(planner->change, frame, planner->have, planner->job->denoised);
    planner->denoise_s = clock_lap(&planner->lap);
    planner->picture_due = false;
    planner->plan.pictures++;
}

static void tell_end(struct planner *planner) {
    struct fewray_plan *plan = &planner->plan;
    if (plan->adaptive)
        tell(planner,
             "Tiles got %d to %d samples a pixel, by what the last samples changed around "
             "them.",
             plan->least_spp, plan->most_spp);
    if (plan->hit_max_spp)
        tell(planner,
             "Stopped at %.0f samples a pixel, the most allowed, before the error was "
             "reached.",
             plan->spp);
    if (plan->too_short)
        tell(planner, "One sample a pixel alone takes longer than the %.3g s wanted.",
             plan->wanted_s);
    if (plan->estimated_error >= 0)
        tell(planner, "The error, estimated from the change that the last samples made, is %.3g.",
             plan->estimated_error);
    else
        tell(planner, "%s", "The error isn't known: there was no earlier picture to compare with.");
}

void planner_finish(struct planner *planner, struct fewray_plan *plan) {
    struct fewray_plan *own = &planner->plan;
    own->least_spp = own->most_spp = planner_least_samples(planner);
    for (int t = 0; t < planner->tiles; t++)
        own->most_spp = planner->have[t] > own->most_spp ? planner->have[t] : own->most_spp;
    own->estimated_error = planner->change->error >= 0 ? planner->change->error : NAN;
    own->too_short = own->wanted_s > 0 && own->spp <= 1 &&
                     elapsed(planner) + planner->write_s > 1.1 * own->wanted_s;
    tell_end(planner);
    *plan = *own;
}
