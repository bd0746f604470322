/* SPDX-License-Identifier: Apache-2.0 */
/* Another renderer's samples teach its maps. */

#include "guide/basis.h"
#include "guide/host/host.h"

static int check_learns(const struct fewray_guide *guide, struct fewray_error *error) {
    return guide->learns ? FEWRAY_OK
                         : fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                                       "this guide can't learn: it was made without the option "
                                       "`learns`");
}

/* False where the sample can't be used. */
static bool make_record(const struct fewray_guide_lesson *l, size_t i, struct look_record *out) {
    const struct vec3 normal = host_load(l->normal + 3 * i);
    const struct vec3 direction = host_load(l->direction + 3 * i);
    const struct vec3 emission = host_load(l->emitted + 3 * i);
    const struct vec3 reflected = host_load(l->reflected + 3 * i);
    const float light_pdf = l->light_pdf ? l->light_pdf[i] : 0;
    if (!host_is_unit(normal) || !host_is_unit(direction) || !host_is_radiance(emission) ||
        !host_is_radiance(reflected) || !(light_pdf >= 0))
        return false;
    *out = (struct look_record){.normal = normal,
                                .depth = 1, /* there is a surface */
                                .direction = direction,
                                .bin = (uint16_t)sphere_bin(direction),
                                .emitted =
                                    mean_component(emission) * power_heuristic(LOOK_PDF, light_pdf),
                                .reflected = mean_component(reflected)};
    return true;
}

int fewray_guide_learn(struct fewray_guide *guide, const struct fewray_guide_lesson *lesson,
                       struct fewray_error *error) {
    const int status = check_learns(guide, error);
    if (status)
        return status;
    if (lesson->count && (!lesson->pixel || !lesson->normal || !lesson->direction ||
                          !lesson->emitted || !lesson->reflected))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "the lesson lacks an array: `pixel`, `normal`, `direction`, `emitted` "
                           "and `reflected` are needed");
    struct fewray_maps *maps = guide->maps;
    for (size_t i = 0; maps->sums && i < lesson->count; i++) {
        const int x = lesson->pixel[2 * i], y = lesson->pixel[2 * i + 1];
        struct look_record record;
        if (x >= 0 && y >= 0 && x < maps->width && y < maps->height &&
            make_record(lesson, i, &record))
            maps_learn(maps, x, y, &record);
    }
    return FEWRAY_OK;
}

int fewray_guide_refine(struct fewray_guide *guide, struct fewray_error *error) {
    const int status = check_learns(guide, error);
    if (!status && guide->maps->sums)
        maps_refine(guide->maps, guide->threads);
    return status;
}
