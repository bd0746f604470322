/* SPDX-License-Identifier: Apache-2.0 */
/* Mends the bad pixels of a picture that was read from a file.
 *
 * Radiance planes are mended in place without a copy, in passes over values of which all good ones
 * are >= 0: first bad values are marked, by NaN (nothing left of them) or by their sign (outliers,
 * whose magnitude the search for other outliers still has to see); then each is replaced by the
 * negated median of the unmarked values around; at last the signs go and pixels are counted. */
#include "features/features_private.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Radiance above this is cut: no light is so bright, and squares of it are still floats. */
#define RADIANCE_MAX 1e12f
#define VARIANCE_MAX (RADIANCE_MAX * RADIANCE_MAX)
/* What renderers write for the background at the most. */
#define DEPTH_MAX 1e10f
/* A value above OUTLIER_LEAST, more than half floats hold, is bad where it is this many times its
 * surroundings' median. */
#define OUTLIER_LEAST 1e5f
#define OUTLIER_RATIO 1000.0f
enum {
    AROUND_MAX = 24,   /* neighbours in a window of 5 x 5 */
    AROUND_ENOUGH = 3, /* with fewer neighbours in 3 x 3, 5 x 5 are looked at */
    BLOCK = 1024,      /* pixels counted at a time */
};

/* What values a layer may have; layers that aren't radiance get 0 for bad values. Finite values
 * that no layer can mean are cut, so that products of them stay finite. */
static const struct {
    enum fewray_layer layer;
    bool is_radiance;
    float least, most; /* below least is bad in unsigned layers, the rest is cut */
} rules[] = {
    {FEWRAY_COLOR, true, 0, RADIANCE_MAX},
    {FEWRAY_NOISY, true, 0, RADIANCE_MAX},
    {FEWRAY_EMISSION, true, 0, RADIANCE_MAX},
    {FEWRAY_VARIANCE, false, 0, VARIANCE_MAX},
    {FEWRAY_ALBEDO, false, 0, 1},
    {FEWRAY_SHADED_ALBEDO, false, 0, 1},
    {FEWRAY_NORMAL, false, -1, 1},
    {FEWRAY_DEPTH, false, 0, DEPTH_MAX},
    {FEWRAY_IRRADIANCE, false, 0, RADIANCE_MAX},
    {FEWRAY_IRRADIANCE_CONFIDENCE, false, 0, 1},
};
enum { RULES = sizeof rules / sizeof rules[0] };

struct marked_plane {
    float *data;
    int width, height;
};

static bool is_marked(float value) {
    return isnan(value) || signbit(value);
}

/* The magnitudes of the neighbours of (x, y) within radius, but for NaNs and, with unmarked_only,
 * marked ones. Returns their number. */
static int neighbours(const struct marked_plane *plane, int x, int y, int radius,
                      bool unmarked_only, float around[AROUND_MAX]) {
    int count = 0;
    for (int v = y - radius; v <= y + radius; v++)
        for (int u = x - radius; u <= x + radius; u++) {
            if (u < 0 || v < 0 || u >= plane->width || v >= plane->height || (u == x && v == y))
                continue;
            const float value = plane->data[(size_t)v * (size_t)plane->width + (size_t)u];
            if (!isnan(value) && !(unmarked_only && signbit(value)))
                around[count++] = fabsf(value);
        }
    return count;
}

static int neighbours_or_wider(const struct marked_plane *plane, int x, int y, bool unmarked_only,
                               float around[AROUND_MAX]) {
    const int count = neighbours(plane, x, y, 1, unmarked_only, around);
    return count >= AROUND_ENOUGH ? count : neighbours(plane, x, y, 2, unmarked_only, around);
}

/* The lower median of count values, which get sorted; 0 of none. */
static float median(float *values, int count) {
    for (int i = 1; i < count; i++) {
        const float value = values[i];
        int j = i;
        for (; j > 0 && values[j - 1] > value; j--)
            values[j] = values[j - 1];
        values[j] = value;
    }
    return count > 0 ? values[(count - 1) / 2] : 0.0f;
}

/* An outlier stands alone: a light, however small, has at least two bright neighbours at each of
 * its pixels unless it covers less than three. */
static bool is_outlier(const struct marked_plane *plane, int x, int y, float value) {
    float around[AROUND_MAX];
    const int count = neighbours_or_wider(plane, x, y, false, around);
    int bright = 0;
    for (int i = 0; i < count; i++)
        bright += around[i] > value / OUTLIER_RATIO;
    return count >= AROUND_ENOUGH && bright < 2 && median(around, count) < value / OUTLIER_RATIO;
}

/* Marks what no radiance can be by NaN. Returns whether any value needs the slow passes. */
static bool mark_impossible(float *data, size_t count) {
    int found = 0;
#pragma omp parallel for reduction(| : found) if (count > FEATURES_PARALLEL_MIN)
    for (size_t i = 0; i < count; i++) {
        const float value = data[i];
        const bool possible = value >= 0.0f && value <= FLT_MAX;
        found |= !possible | (value > OUTLIER_LEAST);
        data[i] = possible ? fabsf(value) : NAN;
    }
    return found;
}

static void mark_outliers(const struct marked_plane *plane) {
    size_t i = 0;
    for (int y = 0; y < plane->height; y++)
        for (int x = 0; x < plane->width; x++, i++)
            if (plane->data[i] > OUTLIER_LEAST && is_outlier(plane, x, y, plane->data[i]))
                plane->data[i] = -plane->data[i];
}

static void replace_marked(const struct marked_plane *plane) {
    size_t i = 0;
    for (int y = 0; y < plane->height; y++)
        for (int x = 0; x < plane->width; x++, i++)
            if (is_marked(plane->data[i])) {
                float around[AROUND_MAX];
                const int count = neighbours_or_wider(plane, x, y, true, around);
                plane->data[i] = -median(around, count);
            }
}

/* Mends a block of a plane and sets bad[i] where value i was bad. */
static void finish_block(float *data, int count, bool is_radiance, float least, float most,
                         unsigned char *bad) {
    const float lowest = least < 0.0f || is_radiance ? -FLT_MAX : 0.0f;
    for (int i = 0; i < count; i++) {
        const float value = data[i];
        const bool possible = value >= lowest && value <= FLT_MAX;
        const bool marked = is_radiance && signbit(value);
        const float mended = !possible ? 0.0f : is_radiance ? fabsf(value) : value;
        bad[i] |= !possible || marked;
        data[i] = mended > most ? most : mended < least ? least : mended;
    }
}

/* The last pass, over all known planes together, so that a pixel counts once. */
static size_t finish(const struct fewray_frame *frame) {
    const size_t size = (size_t)frame->width * (size_t)frame->height;
    size_t repaired = 0;
#pragma omp parallel for reduction(+ : repaired) if (size > FEATURES_PARALLEL_MIN)
    for (size_t start = 0; start < size; start += BLOCK) {
        const int count = (int)(size - start < BLOCK ? size - start : BLOCK);
        unsigned char bad[BLOCK] = {0};
        for (int r = 0; r < RULES; r++) {
            int channels;
            const char *const *names = fewray_layer_channels(rules[r].layer, &channels);
            for (int c = 0; c < channels; c++) {
                float *data = fewray_frame_plane(frame, names[c]);
                if (data)
                    finish_block(data + start, count, rules[r].is_radiance, rules[r].least,
                                 rules[r].most, bad);
            }
        }
        for (int i = 0; i < count; i++)
            repaired += bad[i];
    }
    return repaired;
}

/* The passes over a whole plane of radiance; what is left is finish_block(). */
static void mark_and_replace(const struct fewray_frame *frame, float *data) {
    const struct marked_plane plane = {data, frame->width, frame->height};
    const size_t size = (size_t)frame->width * (size_t)frame->height;
    if (mark_impossible(data, size)) {
        mark_outliers(&plane);
        replace_marked(&plane);
    }
}

size_t fewray_frame_repair(struct fewray_frame *frame) {
    for (int r = 0; r < RULES; r++) {
        int channels;
        const char *const *names = fewray_layer_channels(rules[r].layer, &channels);
        for (int c = 0; rules[r].is_radiance && c < channels; c++) {
            float *data = fewray_frame_plane(frame, names[c]);
            if (data)
                mark_and_replace(frame, data);
        }
    }
    return finish(frame);
}

void fewray_frame_repair_radiance(const struct fewray_frame *frame, float *data) {
    const size_t size = (size_t)frame->width * (size_t)frame->height;
    mark_and_replace(frame, data);
    for (size_t start = 0; start < size; start += BLOCK) {
        const int count = (int)(size - start < BLOCK ? size - start : BLOCK);
        unsigned char bad[BLOCK] = {0};
        finish_block(data + start, count, true, 0, RADIANCE_MAX, bad);
    }
}
