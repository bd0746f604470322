/* SPDX-License-Identifier: Apache-2.0 */
/* The pilot: a few plain paths that tell how much of the noise a guide could touch at all. */

#include <stdlib.h>

#include "guide/trace/tiles.h"

#define STREAM_PILOT  0x70696c6fu
#define PILOT_SPACING 12    /* pixels; two paths at each: 1.4 % of a sample a pixel */
#define RADIUS        3     /* of the neighbourhood whose mean stands for a pixel's, in spacings */
#define DARK          1e-2f /* of the mean radiance: darker pixels count as this bright */

#define LEAST_VARIANCE 1.0f  /* of the bounce: below, a guide gains less than its own time */
#define LEAST_RECORDS  16000 /* of a look: below, maps and probes are made of too little */
#define LEAST_SHARE    0.25f /* of the bounce in all variance */

/* What two paths through one pixel differ by, squared. */
struct pilot_pair {
    float all, bounce; /* without directly seen emission; of what came by the first bounce alone */
    float level;       /* mean radiance */
};

static float squared_length(struct vec3 v) {
    return dot(v, v);
}

static struct pilot_pair trace_pair(const struct integrator *in, int x, int y, uint32_t seed,
                                    int *rays) {
    struct path_sample p[2];
    uint32_t pixel = hash_combine(hash_combine(seed, (uint32_t)x), (uint32_t)y);
    for (uint32_t s = 0; s < 2; s++) {
        struct sampler sampler = sampler_start(hash_combine(pixel, s), 0);
        p[s] = trace_path(in, x, y, &sampler, NULL);
        *rays += p[s].rays;
    }
    struct vec3 a = sub(p[0].radiance, p[0].emission), b = sub(p[1].radiance, p[1].emission);
    struct pilot_pair pair = {.all = squared_length(sub(a, b)),
                              .bounce = squared_length(sub(p[0].bounce, p[1].bounce)),
                              .level = 0.5f * length(add(a, b))};
    return isfinite(pair.all) && isfinite(pair.bounce) && isfinite(pair.level)
               ? pair
               : (struct pilot_pair){0, 0, 0};
}

/* Mean level of the pairs around one. */
static double level_around(const struct pilot_pair *pairs, int columns, int rows, int i) {
    double sum = 0;
    int count = 0;
    for (int y = i / columns - RADIUS; y <= i / columns + RADIUS; y++)
        for (int x = i % columns - RADIUS; x <= i % columns + RADIUS; x++)
            if (x >= 0 && y >= 0 && x < columns && y < rows) {
                sum += pairs[y * columns + x].level;
                count++;
            }
    return sum / count;
}

/* Mean over the pairs of the variance that two samples show, relative to the squared radiance
 * around them. */
static void relative_variance(const struct pilot_pair *pairs, int columns, int rows,
                              struct fewray_pilot *pilot) {
    int count = columns * rows;
    double mean = 0, all = 0, bounce = 0;
    for (int i = 0; i < count; i++)
        mean += pairs[i].level / count;
    for (int i = 0; i < count && mean > 0; i++) {
        double level = level_around(pairs, columns, rows, i) + DARK * mean;
        all += pairs[i].all / (2 * level * level * count);
        bounce += pairs[i].bounce / (2 * level * level * count);
    }
    pilot->variance = (float)all;
    pilot->bounce_variance = (float)bounce;
    pilot->dark = !(mean > 0);
}

int fewray_trace_pilot(const struct fewray_world *world,
                       const struct fewray_render_settings *settings,
                       const struct fewray_film *film, struct fewray_pilot *pilot,
                       struct fewray_render_stats *stats, struct fewray_error *error) {
    struct integrator in = film_integrator(world, film, settings);
    int columns = (film->width + PILOT_SPACING - 1) / PILOT_SPACING;
    int rows = (film->height + PILOT_SPACING - 1) / PILOT_SPACING, count = columns * rows;
    uint32_t seed =
        hash_combine((uint32_t)settings->seed ^ STREAM_PILOT, (uint32_t)(settings->seed >> 32));
    struct pilot_pair *pairs = malloc((size_t)count * sizeof(*pairs));
    if (!pairs)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the pilot");
    long long traced = 0;
    int pairs_traced = 0;
#pragma omp parallel for schedule(dynamic, 16) num_threads(film_threads(settings))                 \
    reduction(+ : traced, pairs_traced)
    for (int i = 0; i < count; i++) {
        uint32_t place = hash_combine(seed, (uint32_t)i);
        int x = i % columns * PILOT_SPACING + (int)(place % PILOT_SPACING);
        int y = i / columns * PILOT_SPACING + (int)(place / PILOT_SPACING % PILOT_SPACING);
        int rays = 0;
        pairs[i] = (struct pilot_pair){0, 0, 0};
        if (x < film->width && y < film->height && !is_cancelled(settings)) {
            pairs[i] = trace_pair(&in, x, y, seed, &rays);
            pairs_traced++;
        }
        traced += rays;
    }
    relative_variance(pairs, columns, rows, pilot);
    pilot->width = film->width;
    pilot->height = film->height;
    pilot->paths = 2 * pairs_traced;
    pilot->tiny = (long long)film->width * film->height * settings->initial < LEAST_RECORDS;
    free(pairs);
    stats->rays += traced;
    return is_cancelled(settings)
               ? fewray_fail(error, FEWRAY_ERROR_CANCELLED, NULL, 0, "interrupted")
               : FEWRAY_OK;
}

bool fewray_pilot_wants_guide(const struct fewray_pilot *pilot) {
    if (pilot->tiny)
        return false;
    return pilot->dark || (pilot->bounce_variance >= LEAST_VARIANCE &&
                           pilot->bounce_variance >= LEAST_SHARE * pilot->variance);
}
