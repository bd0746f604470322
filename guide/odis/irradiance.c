/* SPDX-License-Identifier: Apache-2.0 */
/* Averages of the look's records. */

#include "guide/odis/irradiance.h"

#define SAME_SURFACE 0.9f /* least cosine between the normals */

struct irradiance_sums {
    int count;
    double value, square; /* channels averaged, bounces pooled */
    struct vec3 color;    /* bounces as they were: for the hue alone */
};

static void add_record(const struct look_record *r, struct irradiance_sums *sums) {
    float weight = dot(r->direction, r->normal) * (1 / (LOOK_PDF * PI_F));
    struct vec3 color = add(r->direct, scale(r->radiance, weight));
    float value = mean_component(r->direct) + r->mean * weight;
    if (!isfinite(value) || !isfinite(mean_component(color)))
        return;
    sums->count++;
    sums->value += value;
    sums->square += (double)value * value;
    sums->color = add(sums->color, color);
}

struct irradiance irradiance_gather(const struct fewray_look *look, int x0, int y0, int x1, int y1,
                                    struct vec3 normal) {
    struct irradiance_sums sums = {0};
    x0 = clamp_int(x0, 0, look->width), x1 = clamp_int(x1, 0, look->width);
    y0 = clamp_int(y0, 0, look->height), y1 = clamp_int(y1, 0, look->height);
    for (int y = y0; y < y1; y++) {
        size_t row = (size_t)y * (size_t)look->width;
        const struct look_record *r = look->records + (row + (size_t)x0) * (size_t)look->samples;
        const struct look_record *end = look->records + (row + (size_t)x1) * (size_t)look->samples;
        for (; r < end; r++)
            if (r->depth > 0 && dot(r->normal, normal) > SAME_SURFACE)
                add_record(r, &sums);
    }
    struct irradiance out = {{0, 0, 0}, 0};
    float level = mean_component(sums.color);
    if (!sums.count || !(sums.value > 0) || !(level > 0))
        return out;
    double mean = sums.value / sums.count, variance = sums.square / sums.count - mean * mean;
    out.value = scale(sums.color, (float)mean / level);
    out.confidence = (float)(mean * mean / (mean * mean + fmax(variance, 0) / sums.count));
    return out;
}
