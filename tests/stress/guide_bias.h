/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_GUIDE_BIAS_H
#define FEWRAY_TESTS_GUIDE_BIAS_H

/* Renders of a stage by its maps against plain path tracing. With the environment variable
 * FEWRAY_SHOW the figures are printed. */

#include "guide_stage.h"

#include "block_means.h"

enum { INITIAL = 4, SPP = 4, RENDERS = 24, PLAIN_RENDERS = 48 };

/* Standard errors that the mean of a block of 8 x 8 pixels, or of the picture, may be off. Of the 7
 * means of each of the cases below chance puts one beyond with probability 0.01. */
#define MOST_Z 4.0

static void assert_finite(const struct fewray_frame *frame, const char *name) {
    for (size_t k = 0; k < frame->plane_count; k++)
        for (int i = 0; i < frame->width * frame->height; i++)
            if (!isfinite(frame->planes[k].data[i]))
                fail_msg("%s: %s is %g at pixel %d", name, frame->planes[k].name,
                         (double)frame->planes[k].data[i], i);
}

/* Renders by maps (NULL: plainly), each with another seed. */
static void render(struct stage *s, struct fewray_maps *maps, int renders, uint64_t seed,
                   const char *name, struct block_means *means) {
    for (int i = 0; i < renders; i++) {
        struct fewray_render_settings settings = s->settings;
        struct fewray_render_stats stats = {0};
        struct fewray_error error = {.line = 0};
        struct fewray_film *film = NULL;
        struct fewray_frame *frame = NULL;
        settings.seed = seed + (uint64_t)i;
        stage_must(fewray_film_create(s->world, &settings, &film, &error), &error);
        stage_must(fewray_trace_rest(s->world, maps, &settings, film, &stats, &error), &error);
        stage_must(fewray_film_frame(film, maps, &frame, &error), &error);
        assert_int_equal(stats.dropped, 0);
        assert_finite(frame, name);
        float *planes[3];
        assert_true(fewray_frame_layer(frame, FEWRAY_COLOR, planes));
        const float *const colour[3] = {planes[0], planes[1], planes[2]};
        assert_true(block_means_add(means, colour, frame->width, frame->height));
        fewray_frame_destroy(&frame);
        fewray_film_destroy(&film);
    }
}

static struct block_means plain; /* by plain path tracing */

static int render_plain(void **state) {
    (void)state;
    struct stage s;
    stage_open(&s, 1, 4 * SPP);
    render(&s, NULL, PLAIN_RENDERS, 1 << 20, "plain", &plain);
    stage_close(&s);
    return 0;
}

static int forget_plain(void **state) {
    (void)state;
    free(plain.blocks);
    return 0;
}

/* resolution: most that the picture mean's standard error may be, in shares of the mean; else the
 * case would say nothing. */
static void assert_unbiased(struct stage *s, const char *name, double resolution) {
    static uint64_t seed = 0; /* each case its own, else all would be off by the same noise */
    struct block_means means = {0};
    render(s, s->maps, RENDERS, seed += RENDERS, name, &means);
    const struct block_comparison c = block_compare(&means, &plain);
    if (getenv("FEWRAY_SHOW"))
        printf("%-32s greatest z %+.2f of %d blocks, picture z %+.2f, standard error %.2f %%\n",
               name, c.greatest, c.blocks, c.picture, 100 * c.resolution);
    if (fabs(c.greatest) > MOST_Z || fabs(c.picture) > MOST_Z)
        fail_msg("%s: block %.2f, picture %.2f standard errors off", name, c.greatest, c.picture);
    if (!(c.resolution < resolution))
        fail_msg("%s: standard error %.3g %%, too large to tell", name, 100 * c.resolution);
    free(means.blocks);
}

#endif
