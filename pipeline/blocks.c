/* SPDX-License-Identifier: Apache-2.0 */
/* Is what differs from the reference noise, or bias? z-scores of blocks of pixels. */

#include <math.h>
#include <string.h>

#include "fewray/pipeline.h"

/* Sums over a block of one channel: of both pictures, and of both pictures' variances. */
struct sums {
    double test, reference, variance;
};

static struct sums block_sums(const float *test, const float *reference, const float *variance,
                              const float *stderr_, int width, int x0, int y0, int size) {
    struct sums s = {0};
    for (int y = y0; y < y0 + size; y++)
        for (int x = x0; x < x0 + size; x++) {
            size_t i = (size_t)y * (size_t)width + (size_t)x;
            s.test += test[i];
            s.reference += reference[i];
            s.variance += (double)stderr_[i] * stderr_[i] + (variance ? variance[i] : 0);
        }
    return s;
}

static void add_score(struct fewray_block_scores *s, double z) {
    /* z is beyond any integer where the standard error is next to nothing. */
    int bin = (int)fmin(fmax(z + 0.5 * FEWRAY_SCORE_BINS, 0), FEWRAY_SCORE_BINS - 1);
    s->histogram[bin]++;
    s->count++;
    s->mean += z;
    s->deviation += z * z;
    s->beyond_2 += fabs(z) > 2;
    s->beyond_3 += fabs(z) > 3;
    s->largest = fmax(s->largest, fabs(z));
}

int fewray_block_zscores(const struct fewray_frame *test, const struct fewray_frame *reference,
                         int block, struct fewray_block_scores *scores,
                         struct fewray_error *error) {
    static const char *const channels[3] = {"R", "G", "B"};
    static const char *const errors[3] = {"stderr.R", "stderr.G", "stderr.B"};
    memset(scores, 0, sizeof(*scores));
    float *variance[3];
    if (!fewray_frame_layer(test, FEWRAY_VARIANCE, variance))
        variance[0] = variance[1] = variance[2] = NULL;
    if (test->width != reference->width || test->height != reference->height || block < 1)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "the pictures have different sizes");
    double test_sum = 0, reference_sum = 0;
    for (int c = 0; c < 3; c++) {
        const float *x = fewray_frame_plane(test, channels[c]),
                    *r = fewray_frame_plane(reference, channels[c]);
        const float *e = fewray_frame_plane(reference, errors[c]);
        if (!x || !r || !e)
            return fewray_fail(
                error, FEWRAY_ERROR_FORMAT, NULL, 0,
                "block scores need R, G, B in both pictures and stderr.R/G/B in the reference");
        for (int y = 0; y <= test->height - block; y += block)
            for (int x0 = 0; x0 <= test->width - block; x0 += block) {
                struct sums s = block_sums(x, r, variance[c], e, test->width, x0, y, block);
                double z = (s.test - s.reference) / sqrt(s.variance);
                if (isfinite(s.test) && isfinite(s.reference)) {
                    test_sum += s.test;
                    reference_sum += s.reference;
                }
                if (isfinite(z))
                    add_score(scores, z);
            }
    }
    if (!scores->count)
        return fewray_fail(
            error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
            "no whole block of %d x %d pixels has a standard error; use smaller ones", block,
            block);
    double n = (double)scores->count;
    scores->mean /= n;
    scores->deviation = sqrt(fmax(0, scores->deviation / n - scores->mean * scores->mean));
    scores->ratio_of_means = test_sum / reference_sum;
    return FEWRAY_OK;
}
