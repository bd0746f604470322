/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a picture, merged pixel by pixel. */

#include <math.h>
#include <string.h>

#include "pipeline/part.h"

#define VARIANCE_MAX 1e30f /* as of the film's own */

struct planes {
    float *count, *factor, *mean[3], *deviation[3];
    float *irradiance[3], *confidence; /* NULL: unguided */
};

static struct planes find_planes(const struct fewray_frame *frame) {
    static const char *const means[3] = {"part.mean.R", "part.mean.G", "part.mean.B"};
    static const char *const deviations[3] = {"part.deviation.R", "part.deviation.G",
                                              "part.deviation.B"};
    struct planes p = {.count = fewray_frame_plane(frame, "part.count"),
                       .factor = fewray_frame_plane(frame, "part.factor")};
    float *confidence[3];
    for (int c = 0; c < 3; c++) {
        p.mean[c] = fewray_frame_plane(frame, means[c]);
        p.deviation[c] = fewray_frame_plane(frame, deviations[c]);
    }
    fewray_frame_layer(frame, FEWRAY_IRRADIANCE, p.irradiance);
    fewray_frame_layer(frame, FEWRAY_IRRADIANCE_CONFIDENCE, confidence);
    p.confidence = p.irradiance[0] ? confidence[0] : NULL;
    return p;
}

/* Planes whose merged value isn't the plain weighted mean. */
static bool is_special(const char *name) {
    return !strncmp(name, "part.", 5) || !strncmp(name, "irradiance.", 11);
}

static bool same_planes(const struct fewray_frame *a, const struct fewray_frame *b) {
    if (a->width != b->width || a->height != b->height || a->plane_count != b->plane_count)
        return false;
    for (size_t k = 0; k < a->plane_count; k++)
        if (!fewray_frame_plane(b, a->planes[k].name))
            return false;
    return true;
}

static float mix(float a, float b, double share) {
    return (float)(a + ((double)b - a) * share);
}

/* Two estimates of one irradiance, whose confidence I^2 / (I^2 + V) tells their variances V. A
 * pixel that has one alone keeps it. */
static void merge_irradiance(const struct planes *a, const struct planes *b, size_t i,
                             double share) {
    const double ca = a->confidence[i], cb = b->confidence[i];
    if (!(cb > 0))
        return;
    if (!(ca > 0))
        share = 1;
    double before = 0, other = 0, after = 0;
    for (int c = 0; c < 3; c++) {
        before += a->irradiance[c][i];
        other += b->irradiance[c][i];
        a->irradiance[c][i] = mix(a->irradiance[c][i], b->irradiance[c][i], share);
        after += a->irradiance[c][i];
    }
    const double of_a = ca > 0 ? before * before * (1 - ca) / ca : 0;
    const double variance =
        (1 - share) * (1 - share) * of_a + share * share * other * other * (1 - cb) / cb;
    a->confidence[i] =
        after > 0 ? (float)(after * after / (after * after + variance)) : (float)fmin(ca, cb);
}

/* Moments of both parts' samples together (Chan, Golub, LeVeque 1979). The factor is that of a
 * weighted sum of independent means. */
static void merge_moments(const struct planes *a, const struct planes *b, size_t i, double share) {
    const double na = a->count[i];
    for (int c = 0; c < 3; c++) {
        const double delta = (double)b->mean[c][i] - a->mean[c][i];
        a->deviation[c][i] += (float)(b->deviation[c][i] + delta * delta * na * share);
        a->mean[c][i] = mix(a->mean[c][i], b->mean[c][i], share);
    }
    a->factor[i] = (float)((1 - share) * (1 - share) * a->factor[i] + share * share * b->factor[i]);
    a->count[i] += b->count[i];
}

bool part_add(struct fewray_frame *sum, const struct fewray_frame *part) {
    if (!same_planes(sum, part))
        return false;
    const size_t pixels = (size_t)sum->width * (size_t)sum->height;
    const struct planes a = find_planes(sum), b = find_planes(part);
    for (size_t k = 0; k < sum->plane_count; k++) {
        if (is_special(sum->planes[k].name))
            continue;
        float *to = sum->planes[k].data;
        const float *from = fewray_frame_plane(part, sum->planes[k].name);
        for (size_t i = 0; i < pixels; i++)
            if (b.count[i] > 0)
                to[i] = mix(to[i], from[i], b.count[i] / ((double)a.count[i] + b.count[i]));
    }
    for (size_t i = 0; i < pixels; i++) {
        if (!(b.count[i] > 0))
            continue;
        const double share = b.count[i] / ((double)a.count[i] + b.count[i]);
        if (a.confidence)
            merge_irradiance(&a, &b, i, share);
        merge_moments(&a, &b, i, share);
    }
    return true;
}

void part_finish(struct fewray_frame *sum) {
    const size_t pixels = (size_t)sum->width * (size_t)sum->height;
    const struct planes p = find_planes(sum);
    float *variance[3];
    if (fewray_frame_layer(sum, FEWRAY_VARIANCE, variance))
        for (size_t i = 0; i < pixels; i++)
            for (int c = 0; c < 3 && p.count[i] > 1; c++)
                variance[c][i] =
                    fminf(p.deviation[c][i] / (p.count[i] - 1) * p.factor[i], VARIANCE_MAX);
    for (size_t k = sum->plane_count; k-- > 0;)
        if (!strncmp(sum->planes[k].name, "part.", 5)) {
            char name[FEWRAY_NAME_MAX];
            memcpy(name, sum->planes[k].name, sizeof name);
            fewray_frame_remove(sum, name);
        }
}
