/* SPDX-License-Identifier: Apache-2.0 */
/* First bounces for another renderer's look, spread as our own look's are. */

#include "guide/basis.h"
#include "guide/host/host.h"

static void draw_direction(uint32_t seed, int x, int y, int sample, const float normal[3],
                           float direction[3]) {
    const struct vec3 n = host_load(normal);
    const struct basis basis = basis_around(n);
    float u[2];
    look_square(seed, x, y, sample, u);
    host_store(dot(n, n) > 0 ? normalize(to_world(&basis, uniform_hemisphere(u))) : vec(0, 0, 0),
               direction);
}

void fewray_guide_look_direction(uint64_t seed, int x, int y, int sample, const float normal[3],
                                 float direction[3]) {
    draw_direction(look_seed(seed), x, y, sample, normal, direction);
}

void fewray_guide_look_directions(uint64_t seed, int width, int height, int samples, int threads,
                                  const float *normal, float *direction) {
    const uint32_t stream = look_seed(seed);
    const size_t each = 3 * (size_t)samples;
#pragma omp parallel for schedule(static) num_threads(threads > 0 ? threads : omp_get_num_procs())
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int s = 0; s < samples; s++) {
                const size_t i = ((size_t)y * (size_t)width + (size_t)x) * each + 3 * (size_t)s;
                draw_direction(stream, x, y, s, normal + i, direction + i);
            }
}
