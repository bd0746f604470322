/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_BSDF_SAMPLES_H
#define FEWRAY_TESTS_BSDF_SAMPLES_H

/* That the samples of a plain BSDF follow its density and carry its value. */

#include "tests/unit/check.h"

#include "guide/bsdf/bsdf_local.h"
#include "guide/trace/sampler.h"

typedef struct vec3 bsdf_eval_function(const struct bsdf_local *, struct vec3);
typedef float bsdf_pdf_function(const struct bsdf_local *, struct vec3);
typedef bool bsdf_sample_function(const struct bsdf_local *, float, const float[2],
                                  struct bsdf_sample *);

enum { SAMPLE_ROWS = 16, SAMPLE_COLUMNS = 8, SAMPLE_CELLS = SAMPLE_ROWS * SAMPLE_COLUMNS };

/* Cells of equal solid angle on the sphere. */
static inline int sample_cell(struct vec3 d) {
    int row = (int)((1 - d.z) * 0.5f * SAMPLE_ROWS);
    float turn = atan2f(d.y, d.x) / (2 * PI_F);
    int column = (int)((turn < 0 ? turn + 1 : turn) * SAMPLE_COLUMNS);
    return (row < SAMPLE_ROWS ? row : SAMPLE_ROWS - 1) * SAMPLE_COLUMNS +
           (column < SAMPLE_COLUMNS ? column : SAMPLE_COLUMNS - 1);
}

/* For lobes wider than a degree or so. */
static inline void check_samples(const struct bsdf_local *b, bsdf_eval_function *eval,
                                 bsdf_pdf_function *pdf, bsdf_sample_function *sample) {
    enum { FINE = 24, N = 20000 };
    double observed[SAMPLE_CELLS + 1] = {0}, expected[SAMPLE_CELLS + 1] = {0}, whole = 0;
    for (int i = 0; i < SAMPLE_ROWS * FINE; i++)
        for (int j = 0; j < SAMPLE_COLUMNS * FINE; j++) {
            float z = 1 - ((float)i + 0.5f) * 2 / (SAMPLE_ROWS * FINE), r = sqrtf(1 - z * z);
            float phi = 2 * PI_F * ((float)j + 0.5f) / (SAMPLE_COLUMNS * FINE);
            double part = pdf(b, vec(r * cosf(phi), r * sinf(phi), z)) * 4 * M_PI * N /
                          (SAMPLE_CELLS * FINE * FINE);
            expected[i / FINE * SAMPLE_COLUMNS + j / FINE] += part;
            whole += part;
        }
    expected[SAMPLE_CELLS] = fmax(N - whole, 0); /* specular ones, and those that fail */
    for (uint32_t i = 0; i < N; i++) {
        float u[2] = {to_unit_float(hash_combine(3 * i, 1)), to_unit_float(hash_combine(3 * i, 2))};
        struct bsdf_sample s;
        if (!sample(b, to_unit_float(hash_combine(3 * i, 3)), u, &s) || s.delta) {
            observed[SAMPLE_CELLS]++;
            continue;
        }
        observed[sample_cell(s.direction)]++;
        struct vec3 f = eval(b, s.direction);
        assert_near(s.pdf, pdf(b, s.direction), 1e-5 * s.pdf);
        assert_near(s.weight.x * s.pdf, f.x, 1e-5 * f.x);
        assert_near(s.weight.z * s.pdf, f.z, 1e-5 * f.z);
    }
    int degrees;
    double statistic = chi_square(observed, expected, SAMPLE_CELLS + 1, &degrees);
    if (!(statistic < chi_square_limit(degrees)))
        fail_msg("chi-square %.4g of %d degrees", statistic, degrees);
}

#endif
