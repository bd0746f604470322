/* SPDX-License-Identifier: Apache-2.0 */
/* Finds a pixel's surface in the previous frame. */

#include <math.h>

#include "denoise/temporal.h"

#define DEPTH_SLACK     0.01f /* of the depth, on a surface that is seen head-on */
#define DEPTH_SLACK_MAX 0.04f /* and on any */
#define COS_NORMALS     0.97f
#define ALBEDO_SLACK    0.1f /* and half of the larger albedo: colours of a texture blur */
#define WEIGHT_MIN      0.05f

static float dot3(const float a[3], const float b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* How much the depth changes to the nearer one of two neighbours: across an edge it tells nothing.
 */
static float slope(const struct temporal_pixel *p, ptrdiff_t step, bool has_before,
                   bool has_after) {
    float least = INFINITY;
    if (has_before && p[-step].depth > 0)
        least = fabsf(p[-step].depth - p->depth);
    if (has_after && p[step].depth > 0)
        least = fminf(least, fabsf(p[step].depth - p->depth));
    return least < INFINITY ? least : 0;
}

static bool same_surface(const struct temporal_pixel *past, const struct temporal_pixel *now,
                         float depth, float slack) {
    if (!(past->frames > 0) || !(fabsf(past->depth - depth) <= slack))
        return false;
    const float squares = dot3(now->normal, now->normal) * dot3(past->normal, past->normal);
    if (squares > 0 && !(dot3(now->normal, past->normal) >= COS_NORMALS * sqrtf(squares)))
        return false;
    for (int c = 0; c < 3; c++)
        if (!(fabsf(past->albedo[c] - now->albedo[c]) <=
              ALBEDO_SLACK + 0.5f * fmaxf(past->albedo[c], now->albedo[c])))
            return false;
    return true;
}

struct temporal_taps temporal_find(const struct temporal_pixel *past,
                                   const struct temporal_pixel *now, int width, int height, int x,
                                   int y, const float position[2], float previous_depth) {
    struct temporal_taps taps = {0};
    const struct temporal_pixel *here = &now[(size_t)y * (size_t)width + (size_t)x];
    const float px = position[0] - 0.5f, py = position[1] - 0.5f;
    if (!(previous_depth > 0 && previous_depth < INFINITY) ||
        !(px > -1 && py > -1 && px < (float)width && py < (float)height))
        return taps;
    const float slopes =
        slope(here, 1, x > 0, x + 1 < width) + slope(here, width, y > 0, y + 1 < height);
    const float slack =
        fminf(DEPTH_SLACK * previous_depth + 1.5f * slopes, DEPTH_SLACK_MAX * previous_depth);
    const int x0 = (int)floorf(px), y0 = (int)floorf(py);
    const float fx = px - (float)x0, fy = py - (float)y0;
    float sum = 0;
    for (int k = 0; k < 4; k++) {
        const int tx = x0 + (k & 1), ty = y0 + (k >> 1);
        const float weight = (k & 1 ? fx : 1 - fx) * (k >> 1 ? fy : 1 - fy);
        const size_t i = (size_t)ty * (size_t)width + (size_t)tx;
        if (tx < 0 || ty < 0 || tx >= width || ty >= height || !(weight > 0) ||
            !same_surface(&past[i], here, previous_depth, slack))
            continue;
        taps.index[taps.count] = i;
        taps.weight[taps.count++] = weight;
        sum += weight;
    }
    if (sum < WEIGHT_MIN)
        taps.count = 0;
    for (int k = 0; k < taps.count; k++)
        taps.weight[k] /= sum;
    return taps;
}

void temporal_mix(const struct temporal_pixel *past, const struct temporal_taps *taps,
                  struct temporal_pixel *out) {
    *out = (struct temporal_pixel){.frames = 0};
    float least = INFINITY;
    for (int k = 0; k < taps->count; k++) {
        const struct temporal_pixel *from = &past[taps->index[k]];
        const float w = taps->weight[k];
        for (int c = 0; c < 3; c++) {
            out->light[c] += w * from->light[c];
            out->variance[c] += w * from->variance[c];
        }
        least = fminf(least, from->frames);
    }
    if (taps->count > 0)
        out->frames = least;
}
