/* SPDX-License-Identifier: Apache-2.0 */
/* Whether renders have the expectation that they should have, for any scene and each way to render:
 *
 *     stress_bias SCENE [--width 96] [--renders 64] [--spp 4] [--case NAME]...
 *
 * Many independent renders of each setting are averaged and compared with as many of plain path
 * tracing, without Russian roulette, maps, probes or camera rays for edges, at four times the
 * samples. Blocks of 8 x 8 pixels are compared by the difference of their means over its standard
 * error, z (block_means.h). A setting is called the same as the reference if
 *
 *     1. no more blocks have |z| > 3 than chance gives (0.27 % of them) with probability 1 - ALPHA:
 *        the binomial distribution's quantile; and
 *     2. no block's |z| exceeds what one of them all exceeds by chance with probability ALPHA
 *        (Bonferroni's bound); and
 *     3. the |z| of the whole picture's mean isn't beyond ALPHA, either.
 *
 * ALPHA is 0.001, so that of 100 settings that are right about 0.3 are called wrong at most, if
 * block means are normally distributed. Where one render in a hundred has a pixel brighter than all
 * others of a block together they aren't, and a mean without such a one looks too low and too sure
 * of it. So who isn't the same is rendered again with other seeds, twice as often, the reference
 * too, and is called biased only if that isn't the same, either. What is printed is a row of a
 * table for each comparison; the exit code is 1 if a setting is biased. */

#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "block_means.h"
#include "guide/scene/scene.h"
#include "pipeline/options.h"
#include "pipeline/shot.h"

#define ALPHA             0.001
#define REFERENCE_SAMPLES 4  /* times those of the settings */
#define DEEPEST           32 /* vertices before roulette of a reference without a limit of depth */

/* The ways to render. All but the reference and "path tracing" are guided. */
static void as_it_is(struct fewray_job *job) {
    (void)job;
}
static void path_tracing(struct fewray_job *job) {
    job->guided = false;
}
static void reference(struct fewray_job *job) {
    job->guided = false;
    job->settings.camera_rays = 0;
    job->settings.spp *= REFERENCE_SAMPLES;
}
static void no_probes(struct fewray_job *job) {
    job->settings.probes = false;
}
static void look_dropped(struct fewray_job *job) {
    job->settings.look_weight = 0;
}
static void look_whole(struct fewray_job *job) {
    job->settings.look_weight = 1;
}
static void no_bsdf(struct fewray_job *job) {
    job->settings.bsdf_fraction = 0;
}
static void refined(struct fewray_job *job) {
    job->settings.spp *= 2;
}
static void adaptive(struct fewray_job *job) {
    job->settings.spp *= 2;
    job->goal.adaptive = job->denoised = true;
}
static void by_error(struct fewray_job *job) {
    job->goal.error = 0.02;
    job->goal.max_spp = 4 * job->settings.spp;
    job->goal.adaptive = job->denoised = true;
}
static void paper(struct fewray_job *job) {
    fewray_render_settings_paper(&job->settings);
}
static void path_guiding(struct fewray_job *job) {
    job->ppg = true;
}

static const struct setting {
    const char *name, *about;
    void (*set)(struct fewray_job *job);
    bool asked; /* only where --case names it */
} settings[] = {
    {"path-tracing", "unguided, with Russian roulette and camera rays for edges", path_tracing,
     false},
    {"guided", "as `fewray render` does it: probes, the look kept", as_it_is, false},
    {"no-probes", "maps alone", no_probes, false},
    {"look-dropped", "the first look teaches, but isn't in the picture", look_dropped, false},
    {"look-whole", "the look's samples weigh as much as others", look_whole, false},
    {"no-bsdf", "a BSDF fraction of 0", no_bsdf, false},
    {"refined", "twice the samples: the maps learn from the first half", refined, false},
    {"adaptive", "twice the samples, dealt out by expected error", adaptive, false},
    {"by-error", "--error 0.02, at most four times the samples", by_error, false},
    {"paper", "the paper's guide", paper, true},
    {"ppg", "practical path guiding", path_guiding, true},
};
enum { SETTINGS = sizeof settings / sizeof *settings };

struct study {
    const char *scene_path;
    int width, renders, spp, threads;
    uint64_t seed;
    struct text_list cases;
    struct shot shot;         /* the scene, loaded once */
    struct block_means truth; /* the reference's */
    double mean_spp;          /* of the last setting's renders */
};

static bool report(const struct fewray_error *error) {
    fprintf(stderr, "stress_bias: %s:%d: %s\n", error->file, error->line, error->what);
    return false;
}

/* What the samples say, before any filter. */
static bool add_frame(const struct fewray_frame *frame, struct block_means *means) {
    static const char *const names[2][3] = {{"noisy.R", "noisy.G", "noisy.B"}, {"R", "G", "B"}};
    const int which = !fewray_frame_plane(frame, names[0][0]);
    const float *planes[3];
    for (int c = 0; c < 3; c++)
        if (!(planes[c] = fewray_frame_plane(frame, names[which][c])))
            return false;
    return block_means_add(means, planes, frame->width, frame->height);
}

/* Renders `count` times, each with another seed from `seed` on. */
static bool render(struct study *study, void (*set)(struct fewray_job *), int count, uint64_t seed,
                   struct block_means *means) {
    study->mean_spp = 0;
    for (int i = 0; i < count; i++) {
        struct fewray_job job;
        struct fewray_frame *frame = NULL;
        struct fewray_run_stats stats;
        struct fewray_error error = {.line = 0};
        fewray_job_init(&job);
        job.scene_path = study->scene_path;
        job.pilot = job.denoised = false; /* guided even where that doesn't pay */
        job.settings.width = study->width;
        job.settings.spp = study->spp;
        job.settings.threads = study->threads;
        job.settings.seed = seed + (uint64_t)i;
        set(&job);
        const bool planned = job.goal.adaptive; /* not of a shot */
        if (shot_run_frame(&job, planned ? NULL : &study->shot, &frame, &stats, &error))
            return report(&error);
        study->mean_spp += (planned ? stats.plan.spp : stats.spp) / count;
        const bool added = add_frame(frame, means);
        fewray_frame_destroy(&frame);
        if (!added)
            return false;
    }
    return true;
}

/* Renders the reference. Roulette is the scene's own, which it does without. */
static bool render_reference(struct study *study) {
    struct fewray_scene *scene = study->shot.scene;
    const int rr_depth = scene->rr_depth;
    free(study->truth.blocks);
    study->truth = (struct block_means){0};
    scene->rr_depth = scene->max_depth > 0 ? INT_MAX : DEEPEST;
    const bool done = render(study, reference, study->renders, study->seed, &study->truth);
    scene->rr_depth = rr_depth;
    return done;
}

static bool is_wanted(const struct study *study, const struct setting *s) {
    for (int i = 0; i < study->cases.count; i++)
        if (!strcmp(study->cases.items[i], s->name))
            return true;
    return study->cases.count == 0 && !s->asked;
}

/* Prints a row; returns whether the setting is the same as the reference. */
static bool judge(const struct study *study, const struct setting *s,
                  const struct block_means *means) {
    const struct block_comparison c = block_compare(means, &study->truth);
    const int most_over = binomial_limit(c.blocks, BLOCK_BEYOND_3, ALPHA);
    const double most = normal_limit(ALPHA / c.blocks), most_picture = normal_limit(ALPHA);
    const bool same =
        c.over <= most_over && fabs(c.greatest) <= most && fabs(c.picture) <= most_picture;
    printf(
        "| %s | %d x %.3g | %d of %d (%d) | %+.2f at %d, %d (%.2f) | %+.2f %% +- %.2f %% | %+.2f "
        "(%.2f) | %s |\n",
        s->name, means->renders, study->mean_spp, c.over, c.blocks, most_over, c.greatest, c.x, c.y,
        most, 100 * (means->picture.mean / study->truth.picture.mean - 1), 100 * c.resolution,
        c.picture, most_picture, same ? "same" : "DIFFERENT");
    fflush(stdout);
    return same;
}

/* Renders setting k and compares it; false on failure, too. */
static bool compare(struct study *study, int k) {
    struct block_means means = {0};
    const uint64_t seed = study->seed + 1000003u * (unsigned)(k + 1);
    const bool same = render(study, settings[k].set, study->renders, seed, &means) &&
                      judge(study, &settings[k], &means);
    free(means.blocks);
    return same;
}

/* The same with other seeds, and more of them. */
static bool compare_again(const struct study *study, int k) {
    struct study again = *study;
    again.truth = (struct block_means){0};
    again.renders *= 2;
    again.seed += 0x10000000u + (unsigned)k * 0x1000000u;
    const bool same = render_reference(&again) && compare(&again, k);
    free(again.truth.blocks);
    return same;
}

static bool run(struct study *study) {
    struct fewray_error error = {.line = 0};
    if (fewray_scene_load(study->scene_path, NULL, &study->shot.scene, &error))
        return report(&error);
    printf("| setting | renders x spp | blocks beyond 3 (most) | greatest z, its block (most) | "
           "mean's difference, standard error | its z (most) | |\n|---|---|---|---|---|---|---|\n");
    if (!render_reference(study))
        return false;
    bool same = true;
    for (int k = 0; k < SETTINGS; k++)
        if (is_wanted(study, &settings[k]) && !compare(study, k))
            same &= compare_again(study, k);
    return same;
}

static bool cases_exist(const struct study *study) {
    for (int i = 0; i < study->cases.count; i++) {
        int k = 0;
        while (k < SETTINGS && strcmp(settings[k].name, study->cases.items[i]))
            k++;
        if (k < SETTINGS)
            continue;
        fprintf(stderr, "stress_bias: there is no case '%s'; cases:\n", study->cases.items[i]);
        for (k = 0; k < SETTINGS; k++)
            fprintf(stderr, "  %-14s %s\n", settings[k].name, settings[k].about);
        return false;
    }
    return true;
}

int main(int argc, char **argv) {
    struct study study = {.width = 96, .renders = 64, .spp = 4};
    const struct option_spec specs[] = {
        {"width", 0, OPTION_INT, &study.width, "W", "pixels (96)", 8, 4096, NULL},
        {"renders", 0, OPTION_INT, &study.renders, "N", "of each setting (64)", 4, 100000, NULL},
        {"spp", 0, OPTION_INT, &study.spp, "N", "samples a pixel (4)", 2, 1024, NULL},
        {"case", 0, OPTION_LIST, &study.cases, "NAME", "this setting alone; repeatable", 0, 0,
         NULL},
        {"seed", 0, OPTION_SEED, &study.seed, "S", "of the first render", 0, 0, NULL},
        {"threads", 0, OPTION_INT, &study.threads, "N", "all cores if not given", 1, 256, NULL},
        {0},
    };
    const struct command_line line = {
        "stress_bias", "SCENE [options]", "Looks for bias of each way to render.", specs, 1, 1};
    int first_file;
    switch (parse_command_line(&line, argc, argv, &first_file)) {
    case PARSE_HELP:
        return 0;
    case PARSE_WRONG:
        return 2;
    case PARSE_OK:
        break;
    }
    study.scene_path = argv[first_file];
    if (!cases_exist(&study))
        return 2;
    const bool same = run(&study);
    shot_end(&study.shot);
    free(study.truth.blocks);
    return same ? 0 : 1;
}
