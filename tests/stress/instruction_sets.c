/* SPDX-License-Identifier: Apache-2.0 */
/* Each instruction set against plain C, within stated bounds: the guide's network, the denoiser,
 * and whole pictures. (Bundles of paths: tests/unit/test_bundle.c; kernels: test_nn_kernels.c.) */

#include "tests/unit/check.h"

#include <stdio.h>
#include <string.h>

#include "denoise/nn/nn.h"
#include "guide/odis/network.h"
#include "picture_jobs.h"

static const struct {
    const char *name;
    enum nn_isa isa;
} sets[] = {{"avx2", NN_ISA_AVX2}, {"avx512", NN_ISA_AVX512}};

static bool cpu_has(enum nn_isa isa) {
    return nn_kernels_get(isa)->isa == isa;
}

/* Fused and plain sums of up to 540 products differ by their rounding alone, 540 * 6e-8. */
#define NETWORK_BOUND 3e-5

static void fill_gathered(struct gathered *g, uint32_t seed) {
    memset(g, 0, sizeof *g);
    for (uint32_t b = 0; b < SPHERE_BINS; b++) {
        const uint32_t bits = (b * 2654435761u) ^ (seed * 40503u);
        const float u = (float)(bits >> 8) * 0x1p-24f, v = (float)(bits & 0xffff) * 0x1p-16f;
        g->cosine[b] = fmaxf(0, 1 - (float)(b / SPHERE_COLUMNS) / 16);
        g->mask[b] = u < 0.4f && g->cosine[b] > 0 ? 1.0f : 0.0f;
        for (int p = 0; p < GATHER_PLANES; p++)
            g->planes[p][b] = g->mask[b] * (p % 2 ? u : v);
        g->fill[b] = 4 * v - 3;
    }
}

/* wanted: logarithms differ by no more than the bound, likewise the radiance's compressed. */
static void test_guide_network_is_the_same_with_any_instruction_set(void **state) {
    (void)state;
    static struct gathered g;
    float wanted[2][SPHERE_BINS], radiance[2][SPHERE_BINS], fraction[2];
    for (int i = 0; i < 2; i++) {
        if (!cpu_has(sets[i].isa))
            continue;
        for (uint32_t seed = 0; seed < 8; seed++) {
            fill_gathered(&g, seed);
            for (int k = 0; k < 2; k++) {
                struct odis_weights *weights = NULL;
                setenv("FEWRAY_ISA", k ? sets[i].name : "plain", 1);
                assert_int_equal(odis_weights_load(NULL, &weights, NULL), 0);
                struct odis_network *network = odis_network_create(weights);
                assert_non_null(network);
                odis_network_run(network, &g, wanted[k], radiance[k], &fraction[k]);
                odis_network_destroy(&network);
                odis_weights_destroy(&weights);
            }
            unsetenv("FEWRAY_ISA");
            assert_near(fraction[1], fraction[0], NETWORK_BOUND);
            for (int b = 0; b < SPHERE_BINS; b++) {
                assert_near(log((double)wanted[1][b] + 1e-30), log((double)wanted[0][b] + 1e-30),
                            NETWORK_BOUND);
                assert_near(range_compress(radiance[1][b]), range_compress(radiance[0][b]),
                            NETWORK_BOUND);
            }
        }
    }
}

/* Values of two pictures. */
struct difference {
    double most;  /* of a value and a hundredth of the mean, of a value */
    double share; /* of the values that differ by more than PIXEL_BOUND of that */
    double mean;  /* of the picture's mean */
};

/* What the arithmetic of a pixel may add up to; more is another path. */
#define PIXEL_BOUND 2e-3

static struct difference compare(const struct fewray_frame *a, const struct fewray_frame *b,
                                 const char *const names[3]) {
    const int pixels = a->width * a->height;
    double sums[2] = {0, 0};
    struct difference d = {0, 0, 0};
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < pixels; i++) {
            sums[0] += (double)fewray_frame_plane(a, names[c])[i];
            sums[1] += (double)fewray_frame_plane(b, names[c])[i];
        }
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < pixels; i++) {
            const double x = (double)fewray_frame_plane(a, names[c])[i];
            const double y = (double)fewray_frame_plane(b, names[c])[i];
            const double off = fabs(x - y) / (fabs(x) + 0.01 * sums[0] / (3 * pixels));
            d.most = off > d.most ? off : d.most;
            d.share += (off > PIXEL_BOUND) / (3.0 * pixels);
        }
    d.mean = fabs(sums[1] / sums[0] - 1);
    return d;
}

static const char *const finished[3] = {"R", "G", "B"};
static const char *const noisy[3] = {"noisy.R", "noisy.G", "noisy.B"};

static void tell(const char *name, const char *set, struct difference d) {
    if (getenv("FEWRAY_SHOW"))
        printf("%-36s %-7s most %.2e, %.2f %% differ, mean %.2e\n", name, set, d.most,
               100 * d.share, d.mean);
}

/* A path whose direction lies where two roundings of a map differ by a bin goes another way: a few
 * samples differ, and what the denoiser makes of them. */
#define MOST_DIFFERENT 0.05 /* share of the noisy values */
#define MEAN_BOUND     4e-3

static void test_picture_is_nearly_the_same_with_any_instruction_set(void **state) {
    (void)state;
    for (int p = 0; p < PICTURES; p++) {
        setenv("FEWRAY_ISA", "plain", 1);
        struct fewray_frame *plain = picture_render(&pictures[p], 1, NULL);
        const bool denoised = fewray_frame_plane(plain, noisy[0]) != NULL;
        for (int i = 0; i < 2; i++) {
            setenv("FEWRAY_ISA", sets[i].name, 1);
            if (nn_kernels_get(NN_ISA_AUTO)->isa != sets[i].isa)
                continue;
            struct fewray_frame *fast = picture_render(&pictures[p], 1, NULL);
            const struct difference d = compare(plain, fast, denoised ? noisy : finished);
            const struct difference whole = compare(plain, fast, finished);
            tell(pictures[p].name, sets[i].name, d);
            if (d.share > MOST_DIFFERENT || d.mean > MEAN_BOUND || whole.mean > MEAN_BOUND)
                fail_msg("%s by %s: %.2f %% of the values differ from plain C's, the mean by %.3g, "
                         "denoised %.3g",
                         pictures[p].name, sets[i].name, 100 * d.share, d.mean, whole.mean);
            fewray_frame_destroy(&fast);
        }
        unsetenv("FEWRAY_ISA");
        fewray_frame_destroy(&plain);
    }
}

/* The same noisy picture filtered: sums of up to 540 products, each rounded by 6e-8, of weights
 * that sum to 1. */
#define DENOISED_BOUND 3e-5

static void test_denoiser_is_the_same_with_any_instruction_set(void **state) {
    (void)state;
    for (int p = 1; p <= 2; p++) { /* the two models */
        struct fewray_frame *plain = picture_render(&pictures[p], 1, "plain");
        for (int i = 0; i < 2; i++) {
            if (!cpu_has(sets[i].isa))
                continue;
            struct fewray_frame *fast = picture_render(&pictures[p], 1, sets[i].name);
            assert_true(compare(plain, fast, noisy).most == 0);
            const struct difference d = compare(plain, fast, finished);
            tell(pictures[p].name, sets[i].name, d);
            if (!(d.most <= DENOISED_BOUND))
                fail_msg("%s denoised by %s: a value %.3g off plain C's", pictures[p].name,
                         sets[i].name, d.most);
            fewray_frame_destroy(&fast);
        }
        fewray_frame_destroy(&plain);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_guide_network_is_the_same_with_any_instruction_set),
        cmocka_unit_test(test_picture_is_nearly_the_same_with_any_instruction_set),
        cmocka_unit_test(test_denoiser_is_the_same_with_any_instruction_set),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
