/* SPDX-License-Identifier: Apache-2.0 */
/* A film's moments, by which parts of a picture are merged. */

#include "guide/trace/film.h"

struct moment_planes {
    float *count, *factor, *mean[3], *deviation[3];
};

static bool add_planes(struct fewray_frame *frame, struct moment_planes *p) {
    static const char *const means[3] = {"part.mean.R", "part.mean.G", "part.mean.B"};
    static const char *const deviations[3] = {"part.deviation.R", "part.deviation.G",
                                              "part.deviation.B"};
    for (int c = 0; c < 3; c++)
        if (!(p->mean[c] = fewray_frame_add(frame, means[c])) ||
            !(p->deviation[c] = fewray_frame_add(frame, deviations[c])))
            return false;
    return (p->count = fewray_frame_add(frame, "part.count")) &&
           (p->factor = fewray_frame_add(frame, "part.factor"));
}

static void fill_pixel(const struct fewray_film *film, const struct fewray_maps *maps, int x, int y,
                       const struct moment_planes *p) {
    size_t i = (size_t)y * (size_t)film->width + (size_t)x;
    const struct pixel_group *look = &film->group[GROUP_LOOK][i];
    const struct pixel_group *rest = &film->group[GROUP_REST][i];
    float a = (float)look->count, b = (float)rest->count;
    float s = film_look_share(film, maps, x, y, look, rest);
    p->count[i] = a + b;
    p->factor[i] = (a > 0 ? s * s / a : 0) + (b > 0 ? (1 - s) * (1 - s) / b : 0);
    for (int c = 0; c < 3; c++) {
        float between = look->radiance[c] - rest->radiance[c];
        p->mean[c][i] = s * look->radiance[c] + (1 - s) * rest->radiance[c];
        p->deviation[c][i] = look->deviation[c] + rest->deviation[c] +
                             (a > 0 && b > 0 ? between * between * a * b / (a + b) : 0);
    }
}

int fewray_film_add_moments(const struct fewray_film *film, const struct fewray_maps *maps,
                            struct fewray_frame *frame, struct fewray_error *error) {
    struct moment_planes p;
    if (!add_planes(frame, &p))
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                           "no memory for the picture's layers");
    for (int y = 0; y < film->height; y++)
        for (int x = 0; x < film->width; x++)
            fill_pixel(film, maps, x, y, &p);
    return FEWRAY_OK;
}
