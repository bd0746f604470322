/* SPDX-License-Identifier: Apache-2.0 */
/* Kernels of each instruction set that this CPU has, on numbers at their worst, against sums in
 * double precision. */

#include <float.h>
#include <stdio.h>
#include <string.h>

#include "check.h"
#include "denoise/kernel_apply.h"
#include "denoise/nn/nn.h"

/* A sum of n products in any order, with or without FMA, is off by at most n * 2^-24 of the sum of
 * their magnitudes (Higham 2002, "Accuracy and Stability of Numerical Algorithms", eq. 3.7, with 1
 * % for the higher orders); below normal numbers by a denormal for each. */
static double sum_bound(int n, double magnitudes) {
    return 1.01 * n * 0x1p-24 * magnitudes + n * 0x1p-149;
}

static uint64_t random_state;

static double unit(void) {
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (double)(random_state >> 40) * 0x1p-24;
}

/* Magnitudes over so many octaves around 1, of either sign. */
static float wild(int octaves) {
    const double v = exp2((unit() - 0.5) * octaves);
    return (float)(unit() < 0.5 ? -v : v);
}

static void for_each_isa(void (*check)(const struct nn_kernels *kernels)) {
    int found = 0;
    for (int isa = NN_ISA_PLAIN; isa <= NN_ISA_AVX512; isa++) {
        const struct nn_kernels *kernels = nn_kernels_get((enum nn_isa)isa);
        random_state = 3;
        if (kernels->isa == (enum nn_isa)isa) {
            check(kernels);
            found++;
        }
    }
    assert_true(found > 0);
}

/* --- convolution */

/* What fills inputs and weights. */
static const struct {
    const char *name;
    float scale; /* of the inputs */
    int octaves; /* that inputs and weights spread over */
    bool cancel; /* every second input is the first one's negative, nearly */
} CONVS[] = {
    {"ordinary", 1, 2, false}, {"tiny", 1e-30f, 2, false},         {"denormal", 1e-41f, 2, false},
    {"huge", 1e30f, 2, false}, {"mixed magnitudes", 1, 80, false}, {"cancelling", 1, 2, true},
    {"all zero", 0, 2, false},
};

enum { CONV_HEIGHT = 3, CONV_WIDTH = 15 };

static struct nn_conv make_conv(int kernel, int in, int out, int octaves) {
    struct nn_conv conv = {.kernel = kernel, .in_used = in, .out_used = out};
    conv.in = (in + NN_LANES - 1) / NN_LANES * NN_LANES;
    conv.out = (out + NN_LANES - 1) / NN_LANES * NN_LANES;
    const size_t weights = (size_t)conv.out * (size_t)(kernel * kernel * conv.in);
    conv.weights = aligned_alloc(64, weights * sizeof(float));
    conv.bias = aligned_alloc(64, (size_t)conv.out * sizeof(float));
    for (size_t i = 0; i < weights; i++) {
        const bool real = (int)(i / NN_LANES) % conv.in < in;
        conv.weights[i] = real ? 0.1f * wild(octaves) : 0;
    }
    for (int o = 0; o < conv.out; o++)
        conv.bias[o] = 0;
    return conv;
}

static struct nn_tensor make_tensor(int channels) {
    struct nn_tensor t = {CONV_HEIGHT, CONV_WIDTH, channels, NULL};
    const size_t bytes = nn_tensor_bytes(CONV_HEIGHT, CONV_WIDTH, channels);
    t.data = aligned_alloc(64, bytes);
    memset(t.data, 0, bytes);
    return t;
}

static void fill_tensor(const struct nn_tensor *t, float scale, int octaves, bool cancel) {
    const size_t floats = (size_t)(t->height + 2) * (size_t)(t->width + 2) * (size_t)t->channels;
    for (size_t i = 0; i < floats; i++)
        t->data[i] = cancel && i % 2 ? -t->data[i - 1] * (1 + 0x1p-20f) : scale * wild(octaves);
}

static void check_output(const struct nn_conv *conv, const struct nn_tensor *in, int y, int x,
                         int o, float found, const char *what) {
    const int k = conv->kernel;
    double sum = 0, magnitudes = 0;
    for (int ky = 0; ky < k; ky++)
        for (int kx = 0; kx < k; kx++)
            for (int i = 0; i < conv->in; i++) {
                const size_t row = (size_t)((o / NN_LANES * k + ky) * k + kx) * (size_t)conv->in;
                const double product = (double)nn_at(in, y + ky - k / 2, x + kx - k / 2)[i] *
                                       conv->weights[(row + (size_t)i) * NN_LANES + o % NN_LANES];
                sum += product;
                magnitudes += fabs(product);
            }
    const double expected = sum < 0 ? 0.2 * sum : sum;
    const double bound = sum_bound(k * k * conv->in + 2, magnitudes);
    if (!(fabs(found - expected) <= bound))
        fail_msg("%s: %g instead of %g +- %g", what, (double)found, expected, bound);
}

static void check_conv(const struct nn_kernels *kernels) {
    for (size_t c = 0; c < sizeof CONVS / sizeof *CONVS; c++)
        for (int kernel = 1; kernel <= 3; kernel += 2) {
            char what[96];
            snprintf(what, sizeof what, "%s, %s, %dx%d", kernels->name, CONVS[c].name, kernel,
                     kernel);
            struct nn_conv conv = make_conv(kernel, 20, 24, CONVS[c].octaves);
            struct nn_tensor in = make_tensor(conv.in), out = make_tensor(conv.out);
            fill_tensor(&in, CONVS[c].scale, CONVS[c].octaves, CONVS[c].cancel);
            kernels->conv(&conv, &in, &out, NN_LEAKY_RELU, 0, CONV_HEIGHT);
            for (int y = 0; y < CONV_HEIGHT; y++)
                for (int x = 0; x < CONV_WIDTH; x++)
                    for (int o = 0; o < conv.out_used; o++)
                        check_output(&conv, &in, y, x, o, nn_at(&out, y, x)[o], what);
            free(conv.weights);
            free(conv.bias);
            free(in.data);
            free(out.data);
        }
}

static void test_convolutions_are_double_precisions_sums(void **state) {
    (void)state;
    for_each_isa(check_conv);
}

/* --- softmax */

enum { LOGITS = 34, ROOM = 48, ROWS = 9 };

/* exp's own error (kernels.inc.h), that of the rounded logits' difference, whose magnitude is at
 * most 80 where it matters, and of the sum; weights below e^-80 of the largest count as that. */
#define SOFTMAX_ERROR (3e-7 + 80 * 0x1p-24 + (LOGITS + 2) * 0x1p-24)
#define SOFTMAX_LEAST 2e-35

static const struct {
    const char *name;
    float scale, offset;
} SOFTMAXES[] = {
    {"equal", 0, 0},          {"ordinary", 3, 0},
    {"one rules", 1000, 0},   {"far above", 3, 1e6f},
    {"far below", 3, -1e30f}, {"far apart", 1e30f, 0},
    {"denormal", 1e-41f, 0},  {"near the largest", 1e38f, 0},
};

static void check_softmax_row(const float *logits, const float *weights, const char *what) {
    double most = -INFINITY, sum = 0, total = 0;
    for (int i = 0; i < LOGITS; i++)
        most = fmax(most, logits[i]);
    for (int i = 0; i < LOGITS; i++)
        sum += exp(logits[i] - most);
    for (int i = 0; i < LOGITS; i++) {
        const double expected = exp(logits[i] - most) / sum;
        total += weights[i];
        if (!(fabs(weights[i] - expected) <= SOFTMAX_ERROR * expected + SOFTMAX_LEAST))
            fail_msg("%s: weight %d is %g instead of %g", what, i, (double)weights[i], expected);
    }
    assert_near(total, 1, (LOGITS + 2) * 0x1p-24);
}

static void check_softmax(const struct nn_kernels *kernels) {
    for (size_t s = 0; s < sizeof SOFTMAXES / sizeof *SOFTMAXES; s++) {
        char what[96];
        float logits[ROWS * ROOM], weights[ROWS * ROOM];
        snprintf(what, sizeof what, "%s, %s", kernels->name, SOFTMAXES[s].name);
        for (int i = 0; i < ROWS * ROOM; i++)
            logits[i] = SOFTMAXES[s].offset + SOFTMAXES[s].scale * (float)(unit() - 0.5) * 2;
        kernels->softmax_to(logits, ROWS, ROOM, NULL, LOGITS, weights);
        for (int r = 0; r < ROWS; r++) {
            check_softmax_row(logits + r * ROOM, weights + r * ROOM, what);
            float own[LOGITS];
            memcpy(own, logits + r * ROOM, sizeof own);
            kernels->softmax(own, LOGITS);
            check_softmax_row(logits + r * ROOM, own, what);
        }
    }
}

static void test_softmax_is_double_precisions(void **state) {
    (void)state;
    for_each_isa(check_softmax);
}

/* A network with weights beyond reason may overflow; its kernels still don't make light. */
static void check_damaged_logits(const struct nn_kernels *kernels) {
    static const float bad[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX};
    for (int which = 0; which < 5 * 5; which++)
        for (int place = -1; place < LOGITS; place++) {
            float logits[ROOM] = {0}, weights[ROOM];
            for (int i = 0; i < LOGITS; i++)
                logits[i] = place < 0 || i == place ? bad[which % 5] : 0.1f * (float)i;
            logits[7] = bad[which / 5];
            kernels->softmax_to(logits, 1, ROOM, NULL, LOGITS, weights);
            double sum = 0;
            for (int i = 0; i < LOGITS; i++) {
                assert_true(weights[i] >= 0 && weights[i] <= 1);
                sum += weights[i];
            }
            assert_true(sum <= 1 + (LOGITS + 2) * 0x1p-24);
        }
}

static void test_damaged_logits_give_finite_weights(void **state) {
    (void)state;
    for_each_isa(check_damaged_logits);
}

/* --- affinity */

/* A tap's logit: seven scaled squares of differences, each rounded three times, a key and the
 * logit. */
enum { AFFINITY_ROUNDINGS = 8 + 1 + 3 };

static void check_affinity(const struct nn_kernels *kernels) {
    static const float scales[] = {1, 1e-20f, 1e12f, 1e-41f};
    enum { SIZE = 5, TAPS = SIZE * SIZE };
    for (size_t s = 0; s < sizeof scales / sizeof *scales; s++) {
        float own[NN_KEY], taps[TAPS * NN_KEY], scale[NN_KEY], logits[TAPS], before[TAPS];
        for (int i = 0; i < TAPS * NN_KEY; i++)
            taps[i] = scales[s] * wild(20);
        for (int i = 0; i < NN_KEY; i++) {
            own[i] = taps[NN_KEY + i] * (1 + 0x1p-18f * (float)i); /* one tap nearly alike */
            scale[i] = i < NN_KEY - 1 ? (float)unit() : 0;
        }
        for (int t = 0; t < TAPS; t++)
            before[t] = logits[t] = wild(10);
        const struct nn_affinity job = {.count = 1,
                                        .size = SIZE,
                                        .logits = logits,
                                        .pitch = TAPS,
                                        .own = own,
                                        .own_step = NN_KEY,
                                        .taps = taps,
                                        .taps_step = NN_KEY,
                                        .taps_row = SIZE * NN_KEY,
                                        .scale = scale};
        kernels->add_affinity(&job);
        for (int t = 0; t < TAPS; t++) {
            double expected = before[t] + (double)taps[t * NN_KEY + NN_KEY - 1];
            double magnitudes = fabs(before[t]) + fabs(taps[t * NN_KEY + NN_KEY - 1]);
            for (int c = 0; c < NN_KEY - 1; c++) {
                const double d = (double)own[c] - taps[t * NN_KEY + c];
                expected -= scale[c] * d * d;
                magnitudes += scale[c] * d * d;
            }
            assert_near(logits[t], expected, sum_bound(AFFINITY_ROUNDINGS, magnitudes));
        }
    }
}

static void test_affinity_is_double_precisions(void **state) {
    (void)state;
    for_each_isa(check_affinity);
}

/* --- kernels on light */

static struct kpn_image make_image(int height, int width, int channels, float scale) {
    struct kpn_image image = {height, width, channels, NULL};
    const size_t bytes = kpn_image_bytes(height, width, channels);
    image.data = aligned_alloc(64, bytes);
    for (size_t i = 0; i < bytes / sizeof(float); i++)
        image.data[i] = scale * fabsf(wild(40));
    return image;
}

/* The 34 products of a channel and the sum of their magnitudes. */
static double reference_apply(const float *weights, const struct kpn_image *fine,
                              const struct kpn_image *coarse, int y, int x, int c) {
    double sum = 0;
    for (int t = 0; t < KPN_TAPS_FINE; t++)
        sum += (double)weights[t] * kpn_pixel(fine, y + t / 5 - 2, x + t % 5 - 2)[c];
    for (int t = 0; t < KPN_TAPS_COARSE; t++)
        sum += (double)weights[KPN_TAPS_FINE + t] *
               kpn_pixel(coarse, y / 2 + t / 3 - 1, x / 2 + t % 3 - 1)[c];
    return sum;
}

static void test_kernels_applied_are_double_precisions_means(void **state) {
    (void)state;
    static const float scales[] = {1, 1e-41f, 1e-12f, 1e14f, 1e25f};
    enum { W = 8, H = 6 };
    random_state = 9;
    for (size_t s = 0; s < sizeof scales / sizeof *scales; s++) {
        struct kpn_image fine = make_image(H, W, 4, scales[s]),
                         coarse = make_image(H / 2, W / 2, 4, scales[s]);
        for (int i = 0; i < W * H; i++) {
            float weights[ROOM], out[4], slots[4];
            for (int t = 0; t < KPN_TAPS; t++)
                weights[t] = (float)(20 * unit());
            nn_kernels_get(NN_ISA_AUTO)->softmax(weights, KPN_TAPS);
            kpn_apply(weights, &fine, &coarse, i / W, i % W, out);
            kpn_apply_slots(weights, &fine, &coarse, i / W, i % W, slots, 4);
            assert_memory_equal(out, slots, sizeof out);
            for (int c = 0; c < 4; c++) {
                const double expected = reference_apply(weights, &fine, &coarse, i / W, i % W, c);
                assert_near(out[c], expected, sum_bound(KPN_TAPS, expected));
            }
        }
        for (int x = 0; x < W / 2; x++) {
            float weights[4], out[4];
            for (int t = 0; t < 4; t++)
                weights[t] = (float)(20 * unit());
            nn_kernels_get(NN_ISA_AUTO)->softmax(weights, 4);
            kpn_downsample_row(weights, &fine, 1, x, 1, out);
            for (int c = 0; c < 4; c++) {
                double expected = 0;
                for (int t = 0; t < 4; t++)
                    expected += (double)weights[t] * kpn_pixel(&fine, 2 + t / 2, 2 * x + t % 2)[c];
                assert_near(out[c], expected, sum_bound(4, expected));
            }
        }
        free(fine.data);
        free(coarse.data);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_convolutions_are_double_precisions_sums),
        cmocka_unit_test(test_softmax_is_double_precisions),
        cmocka_unit_test(test_damaged_logits_give_finite_weights),
        cmocka_unit_test(test_affinity_is_double_precisions),
        cmocka_unit_test(test_kernels_applied_are_double_precisions_means),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
