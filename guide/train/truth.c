/* SPDX-License-Identifier: Apache-2.0 */
/* True maps, for training data (odis_data.c), studies (true_maps.c) and figures (draw_map.c). */

#include "guide/train/truth.h"

#include <math.h>

struct truth_bin truth_bin(const struct integrator *in, struct vec3 position, struct vec3 normal,
                           int bin, int samples, uint32_t seed) {
    struct truth_bin truth = {0, 0, 0};
    double moment = 0;
    for (int s = 0; s < samples; s++) {
        struct sampler sampler = sampler_start(hash_combine(seed, (uint32_t)bin), (uint32_t)s);
        float u[2];
        sampler_2d(&sampler, u);
        struct vec3 direction =
            sphere_direction(bin / SPHERE_COLUMNS, bin % SPHERE_COLUMNS, u[0], u[1]);
        struct path_state state = {.depth = 1, .throughput = vec(1, 1, 1), .eta = 1};
        const struct path_ray ray = {position, normal, normal, direction, LOOK_PDF};
        struct incident i = trace_incident(in, &sampler, state, ray, NULL);
        float full = mean_component(add(i.emission, i.reflected));
        float weighted = mean_component(incident_radiance(&i, LOOK_PDF));
        if (!isfinite(full) || !isfinite(weighted))
            continue;
        truth.mean += full;
        moment += (double)weighted * weighted;
        truth.used++;
    }
    if (truth.used) {
        truth.mean /= truth.used;
        truth.root_moment = sqrt(moment / truth.used);
    }
    return truth;
}
