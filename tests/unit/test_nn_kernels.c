/* SPDX-License-Identifier: Apache-2.0 */
/* Every kernel of every instruction set that this CPU has, against double-precision references on
 * random shapes, with guard floats around what a kernel may write. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "denoise/nn/nn.h"

#define GUARD       64 /* floats before and after a buffer */
#define GUARD_VALUE 12345.678f

static uint64_t random_state = 1;

static uint32_t random_bits(void) {
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(random_state >> 33);
}
static int random_int(int low, int high) {
    return low + (int)(random_bits() % (uint32_t)(high - low + 1));
}
static float random_float(float low, float high) {
    return low + (high - low) * (float)(random_bits() & 0xffffff) / 0x1p24f;
}

static float *guarded(size_t floats) {
    size_t bytes = ((floats + 2 * GUARD) * sizeof(float) + 63) & ~(size_t)63;
    float *data = aligned_alloc(64, bytes);
    assert_non_null(data);
    for (size_t i = 0; i < floats + 2 * GUARD; ++i)
        data[i] = GUARD_VALUE;
    return data + GUARD;
}
static void assert_guards(const float *data, size_t floats) {
    for (size_t i = 0; i < GUARD; ++i) {
        assert_true(data[-1 - (ptrdiff_t)i] == GUARD_VALUE);
        assert_true(data[floats + i] == GUARD_VALUE);
    }
}
static void guarded_free(float *data) {
    free(data - GUARD);
}

static size_t tensor_floats(const struct nn_tensor *t) {
    return (size_t)(t->height + 2) * (size_t)(t->width + 2) * (size_t)t->channels;
}
static struct nn_tensor tensor(int height, int width, int channels) {
    struct nn_tensor t = {height, width, channels, NULL};
    t.data = guarded(tensor_floats(&t));
    return t;
}
static struct nn_tensor random_tensor(int height, int width, int channels) {
    struct nn_tensor t = tensor(height, width, channels);
    for (size_t i = 0; i < tensor_floats(&t); ++i)
        t.data[i] = random_float(-1.0f, 1.0f);
    return t;
}
static struct nn_tensor copy_tensor(const struct nn_tensor *t) {
    struct nn_tensor copy = tensor(t->height, t->width, t->channels);
    memcpy(copy.data, t->data, tensor_floats(t) * sizeof(float));
    return copy;
}
static bool same_bits(const struct nn_tensor *a, const struct nn_tensor *b) {
    return memcmp(a->data, b->data, tensor_floats(a) * sizeof(float)) == 0;
}
static void tensor_free(struct nn_tensor *t) {
    assert_guards(t->data, tensor_floats(t));
    guarded_free(t->data);
}

/* The border, and the rows that weren't asked for, must be as they were made. */
static void assert_untouched_outside(const struct nn_tensor *t, int channels, int y0, int y1) {
    for (int y = -1; y <= t->height; ++y)
        for (int x = -1; x <= t->width; ++x)
            for (int c = 0; c < t->channels; ++c)
                if (y < y0 || y >= y1 || x < 0 || x >= t->width || c >= channels)
                    assert_true(nn_at(t, y, x)[c] == GUARD_VALUE);
}

static struct nn_conv random_conv(int kernel, int in_used, int out) {
    struct nn_conv conv = {.kernel = kernel, .in_used = in_used, .out_used = out};
    out = conv.out = (out + NN_LANES - 1) / NN_LANES * NN_LANES;
    conv.in = (in_used + NN_LANES - 1) / NN_LANES * NN_LANES;
    size_t weights = (size_t)out * (size_t)(kernel * kernel * conv.in);
    conv.weights = guarded(weights);
    conv.bias = guarded((size_t)out);
    for (size_t i = 0; i < weights; ++i)
        conv.weights[i] =
            (int)(i / NN_LANES) % conv.in < in_used ? random_float(-0.2f, 0.2f) : 0.0f;
    for (int i = 0; i < out; ++i)
        conv.bias[i] = i < conv.out_used ? random_float(-1.0f, 1.0f) : 0.0f;
    return conv;
}
static void conv_free(struct nn_conv *conv) {
    guarded_free(conv->weights);
    guarded_free(conv->bias);
}

/* One output; *scale gets the sum of the magnitudes, which bounds the rounding error. */
static double reference_conv(const struct nn_conv *conv, const struct nn_tensor *in, int y, int x,
                             int o, enum nn_activation activation, double *scale) {
    double sum = conv->bias[o];
    int k = conv->kernel;
    *scale = fabs(sum);
    for (int ky = 0; ky < k; ++ky)
        for (int kx = 0; kx < k; ++kx)
            for (int i = 0; i < conv->in; ++i) {
                size_t row = ((size_t)((o / NN_LANES * k + ky) * k + kx)) * (size_t)conv->in;
                double product = (double)nn_at(in, y + ky - k / 2, x + kx - k / 2)[i] *
                                 conv->weights[(row + (size_t)i) * NN_LANES + o % NN_LANES];
                sum += product;
                *scale += fabs(product);
            }
    return activation == NN_LEAKY_RELU && sum < 0.0 ? 0.2 * sum : sum;
}

/* Calls check for each instruction set of this CPU. */
static void for_each_isa(void (*check)(const struct nn_kernels *kernels)) {
    for (int isa = NN_ISA_PLAIN; isa <= NN_ISA_AVX512; ++isa) {
        const struct nn_kernels *kernels = nn_kernels_get((enum nn_isa)isa);
        random_state = 7;
        if (kernels->isa == (enum nn_isa)isa)
            check(kernels);
    }
}

static void check_conv(const struct nn_kernels *kernels, int height, int width) {
    int kernel = random_int(0, 1) ? 3 : 1, in_used = 4 * random_int(1, 17);
    struct nn_conv conv = random_conv(kernel, in_used, 8 * random_int(1, 10));
    struct nn_tensor in = random_tensor(height, width, conv.in + 16 * random_int(0, 1));
    struct nn_tensor out = tensor(height, width, conv.out + 16 * random_int(0, 1));
    int y0 = random_int(0, height - 1), y1 = random_int(y0, height);
    enum nn_activation activation = random_int(0, 1) ? NN_LEAKY_RELU : NN_LINEAR;
    kernels->conv(&conv, &in, &out, activation, y0, y1);
    assert_untouched_outside(&out, conv.out, y0, y1);
    for (int y = y0; y < y1; ++y)
        for (int x = 0; x < width; ++x)
            for (int o = 0; o < conv.out; ++o) {
                if (o >= conv.out_used) {
                    assert_true(nn_at(&out, y, x)[o] == 0.0f);
                    continue;
                }
                double scale, value = reference_conv(&conv, &in, y, x, o, activation, &scale);
                assert_true(fabs(nn_at(&out, y, x)[o] - value) <= 1e-6 * scale);
            }
    tensor_free(&in);
    tensor_free(&out);
    conv_free(&conv);
}

static void check_conv_shapes(const struct nn_kernels *kernels) {
    for (int width = 1; width <= 33; ++width) /* all register blocks and ways to cut a row */
        check_conv(kernels, random_int(1, 3), width);
    for (int i = 0; i < 20; ++i)
        check_conv(kernels, random_int(1, 8), random_int(1, 60));
}
static void test_conv_equals_reference(void **state) {
    (void)state;
    for_each_isa(check_conv_shapes);
}

static void check_conv_bits(const struct nn_kernels *kernels) {
    for (int i = 0; i < 10; ++i) {
        const int height = 9, width = random_int(1, 40);
        struct nn_conv conv = random_conv(3, 4 * random_int(1, 12), 8 * random_int(1, 8));
        struct nn_tensor in = random_tensor(height, width, conv.in);
        struct nn_tensor whole = tensor(height, width, conv.out), parts = copy_tensor(&whole);
        kernels->conv(&conv, &in, &whole, NN_LEAKY_RELU, 0, height);
        for (int y = 0; y < height;) {
            int y1 = random_int(y, height);
            kernels->conv(&conv, &in, &parts, NN_LEAKY_RELU, y, y1);
            y = y1;
        }
        assert_true(same_bits(&whole, &parts));

        /* The same picture one pixel to the left, in a narrower tensor: other tiles, same bits. */
        if (width > 1) {
            struct nn_tensor cut = tensor(height, width - 1, in.channels);
            struct nn_tensor moved = tensor(height, width - 1, conv.out);
            for (int y = -1; y <= height; ++y)
                memcpy(nn_at(&cut, y, -1), nn_at(&in, y, 0),
                       (size_t)(width + 1) * (size_t)in.channels * sizeof(float));
            kernels->conv(&conv, &cut, &moved, NN_LEAKY_RELU, 0, height);
            for (int y = 0; y < height; ++y)
                assert_memory_equal(nn_at(&moved, y, 0), nn_at(&whole, y, 1),
                                    (size_t)(width - 1) * (size_t)conv.out * sizeof(float));
            tensor_free(&cut);
            tensor_free(&moved);
        }
        tensor_free(&in);
        tensor_free(&whole);
        tensor_free(&parts);
        conv_free(&conv);
    }
}
static void test_conv_has_same_bits_for_any_rows_and_tiles(void **state) {
    (void)state;
    for_each_isa(check_conv_bits);
}

static void test_conv_has_same_bits_on_all_fma_sets(void **state) {
    (void)state;
    const struct nn_kernels *a = nn_kernels_get(NN_ISA_AVX2), *b = nn_kernels_get(NN_ISA_AVX512);
    if (a->isa == b->isa || a->isa == NN_ISA_PLAIN)
        skip();
    struct nn_conv conv = random_conv(3, 36, 56);
    struct nn_tensor in = random_tensor(11, 37, conv.in);
    struct nn_tensor one = tensor(11, 37, conv.out), other = copy_tensor(&one);
    a->conv(&conv, &in, &one, NN_LEAKY_RELU, 0, 11);
    b->conv(&conv, &in, &other, NN_LEAKY_RELU, 0, 11);
    assert_true(same_bits(&one, &other));
    tensor_free(&in);
    tensor_free(&one);
    tensor_free(&other);
    conv_free(&conv);
}

static void check_conv_ignores_padding(const struct nn_kernels *kernels) {
    struct nn_conv conv = random_conv(3, 20, 16);
    struct nn_tensor in = random_tensor(4, 9, conv.in), dirty = copy_tensor(&in);
    struct nn_tensor one = tensor(4, 9, conv.out), other = copy_tensor(&one);
    for (size_t i = 0; i < tensor_floats(&dirty); ++i)
        if ((int)(i % (size_t)conv.in) >= conv.in_used)
            dirty.data[i] = NAN;
    kernels->conv(&conv, &in, &one, NN_LINEAR, 0, 4);
    kernels->conv(&conv, &dirty, &other, NN_LINEAR, 0, 4);
    assert_true(same_bits(&one, &other));
    tensor_free(&in);
    tensor_free(&dirty);
    tensor_free(&one);
    tensor_free(&other);
    conv_free(&conv);
}
static void test_conv_ignores_padding_channels(void **state) {
    (void)state;
    for_each_isa(check_conv_ignores_padding);
}

static void check_average_pool(const struct nn_kernels *kernels) {
    for (int i = 0; i < 20; ++i) {
        int height = random_int(1, 6), width = random_int(1, 9), channels = 16 * random_int(1, 4);
        struct nn_tensor in = random_tensor(2 * height, 2 * width, channels);
        struct nn_tensor out = tensor(height, width, channels);
        int y0 = random_int(0, height - 1), y1 = random_int(y0, height);
        kernels->average_pool(&in, &out, y0, y1);
        assert_untouched_outside(&out, channels, y0, y1);
        for (int y = y0; y < y1; ++y)
            for (int x = 0; x < width; ++x)
                for (int c = 0; c < channels; ++c) {
                    double sum = 0.0;
                    for (int k = 0; k < 4; ++k)
                        sum += nn_at(&in, 2 * y + k / 2, 2 * x + k % 2)[c];
                    assert_true(fabs(nn_at(&out, y, x)[c] - sum / 4) < 1e-6);
                }
        tensor_free(&in);
        tensor_free(&out);
    }
}
static void test_average_pool_equals_reference(void **state) {
    (void)state;
    for_each_isa(check_average_pool);
}

static void check_upsample_add(const struct nn_kernels *kernels) {
    for (int i = 0; i < 20; ++i) {
        int height = random_int(1, 6), width = random_int(1, 9), channels = 16 * random_int(1, 4);
        struct nn_tensor in = random_tensor(height, width, channels);
        struct nn_tensor out = random_tensor(2 * height, 2 * width, channels);
        struct nn_tensor before = copy_tensor(&out);
        int y0 = random_int(0, 2 * height - 1), y1 = random_int(y0, 2 * height);
        kernels->upsample_add(&in, &out, y0, y1);
        for (int y = -1; y <= out.height; ++y)
            for (int x = -1; x <= out.width; ++x)
                for (int c = 0; c < channels; ++c) {
                    float expected = nn_at(&before, y, x)[c];
                    if (y >= y0 && y < y1 && x >= 0 && x < out.width)
                        expected += nn_at(&in, y / 2, x / 2)[c];
                    assert_true(nn_at(&out, y, x)[c] == expected);
                }
        tensor_free(&in);
        tensor_free(&out);
        tensor_free(&before);
    }
}
static void test_upsample_add_equals_reference(void **state) {
    (void)state;
    for_each_isa(check_upsample_add);
}

/* --- affinity: against its formula, for every size and step that the network uses */

static void check_affinity(const struct nn_kernels *kernels) {
    enum { COUNT = 7, COLUMNS = 2 * COUNT + 4, ROWS = 5, PITCH = 40 };
    static float keys[ROWS][COLUMNS][NN_KEY];
    float scale[NN_KEY] = {0.9f, 0.1f, 2, 1, 0, 0.5f, 3, 0}, logits[COUNT * PITCH];
    for (int y = 0; y < ROWS; y++)
        for (int x = 0; x < COLUMNS; x++)
            for (int c = 0; c < NN_KEY; c++)
                keys[y][x][c] = random_float(-2, 2);
    for (int size = 3; size <= 5; size += 2)
        for (int step = 1; step <= 2; step++) {
            struct nn_affinity affinity = {COUNT,
                                           size,
                                           logits,
                                           PITCH,
                                           keys[2][2],
                                           NN_KEY,
                                           keys[0][0],
                                           (size_t)(step * NN_KEY),
                                           COLUMNS * NN_KEY,
                                           scale};
            for (int i = 0; i < COUNT * PITCH; i++)
                logits[i] = (float)i;
            kernels->add_affinity(&affinity);
            for (int i = 0; i < COUNT; i++)
                for (int t = 0; t < PITCH; t++) {
                    double wanted = i * PITCH + t;
                    const float *own = keys[2][2 + i];
                    const float *tap = keys[t / size % ROWS][step * i + t % size];
                    for (int c = 0; c < NN_KEY - 1 && t < size * size; c++)
                        wanted -= scale[c] * pow((double)own[c] - tap[c], 2);
                    wanted += t < size * size ? tap[NN_KEY - 1] : 0;
                    assert_float_equal(logits[i * PITCH + t], wanted, 1e-4);
                }
        }
}

static void test_affinity_equals_formula(void **state) {
    (void)state;
    for_each_isa(check_affinity);
}

static void check_softmax_row(const float *in, const float *out, int n) {
    double maximum = -INFINITY, total = 0.0, sum = 0.0;
    for (int i = 0; i < n; ++i)
        maximum = fmax(maximum, in[i]);
    for (int i = 0; i < n; ++i)
        total += exp(in[i] - maximum);
    for (int i = 0; i < n; ++i) {
        double value = exp((double)in[i] - maximum) / total;
        /* The argument is rounded as well: half an ulp of it. */
        double tolerance = 1e-6 + 0x1p-24 * fabs(in[i] - maximum);
        assert_true(out[i] >= 0.0f);
        assert_true(fabs(out[i] - value) <= tolerance * value + 1e-34);
        sum += out[i];
    }
    assert_true(fabs(sum - 1.0) < 1e-6);
}

static void check_softmax(const struct nn_kernels *kernels) {
    static const float ranges[] = {0.0f, 0.1f, 5.0f, 60.0f, 1e4f, 1e30f};
    for (int n = 1; n <= 100; ++n) {
        float *values = guarded((size_t)n), before[100];
        for (int i = 0; i < n; ++i) {
            before[i] = random_float(-ranges[n % 6], ranges[n % 6]);
            values[i] = before[i];
        }
        kernels->softmax(values, n);
        check_softmax_row(before, values, n);
        assert_guards(values, (size_t)n);
        guarded_free(values);
    }
}
static void test_softmax_equals_reference(void **state) {
    (void)state;
    for_each_isa(check_softmax);
}

static void check_softmax_rows(const struct nn_kernels *kernels) {
    for (int i = 0; i < 100; ++i) {
        int n = random_int(1, 40), stride = n + random_int(0, 5), rows = random_int(1, 6);
        size_t floats = (size_t)(rows * stride);
        float *values = guarded(floats), *expected = guarded(floats);
        for (size_t k = 0; k < floats; ++k)
            values[k] = expected[k] = random_float(-9.0f, 9.0f);
        kernels->softmax_rows(values, rows, stride, n);
        for (int row = 0; row < rows; ++row)
            kernels->softmax(expected + row * stride, n);
        assert_memory_equal(values, expected, floats * sizeof(float));
        assert_guards(values, floats);
        guarded_free(values);
        guarded_free(expected);
    }
}
static void test_softmax_rows_equals_softmax_of_each_row(void **state) {
    (void)state;
    for_each_isa(check_softmax_rows);
}

static void check_softmax_to(const struct nn_kernels *kernels) {
    static const int lengths[] = {1, 4, 9, 25, 34, 40, 70};
    for (size_t k = 0; k < 2 * sizeof lengths / sizeof *lengths; ++k) {
        int n = lengths[k / 2], room = (n + NN_LANES - 1) / NN_LANES * NN_LANES;
        int rows = random_int(1, 19), stride = n + random_int(0, 3);
        size_t logit_floats = (size_t)((rows - 1) * stride + n);
        float *logits = guarded(logit_floats), *bias = guarded((size_t)(2 * room)),
              *weights = guarded((size_t)(rows * room)), *expected = guarded((size_t)n);
        for (int i = 0; i < 2 * room; ++i)
            bias[i] = i % room < n && k % 2 ? random_float(-2.0f, 2.0f) : 0.0f;
        for (size_t i = 0; i < logit_floats; ++i)
            logits[i] = random_float(-30.0f, 30.0f);
        kernels->softmax_to(logits, rows, stride, k % 2 ? bias : NULL, n, weights);
        for (int row = 0; row < rows; ++row) {
            for (int i = 0; i < n; ++i)
                expected[i] = logits[row * stride + i] + bias[row % 2 * room + i];
            kernels->softmax(expected, n);
            for (int i = 0; i < n; ++i)
                assert_true(fabsf(weights[row * room + i] - expected[i]) <=
                            1e-6f * expected[i] + 1e-30f);
        }
        assert_guards(logits, logit_floats);
        assert_guards(bias, (size_t)(2 * room));
        assert_guards(weights, (size_t)(rows * room));
        guarded_free(logits);
        guarded_free(bias);
        guarded_free(weights);
        guarded_free(expected);
    }
}
static void test_softmax_to_equals_softmax(void **state) {
    (void)state;
    for_each_isa(check_softmax_to);
}

static void test_border_is_zero_or_wraps(void **state) {
    (void)state;
    for (int wrap = 0; wrap < 2; ++wrap) {
        struct nn_tensor t = random_tensor(random_int(1, 5), random_int(1, 5), 32);
        struct nn_tensor before = copy_tensor(&t);
        nn_fill_border(&t, wrap ? NN_BORDER_WRAP_X : NN_BORDER_ZERO);
        for (int y = -1; y <= t.height; ++y)
            for (int x = -1; x <= t.width; ++x)
                for (int c = 0; c < t.channels; ++c) {
                    bool row_inside = y >= 0 && y < t.height, inside = x >= 0 && x < t.width;
                    float expected = 0.0f;
                    if (row_inside && (inside || wrap))
                        expected = nn_at(&before, y, (x + t.width) % t.width)[c];
                    assert_true(nn_at(&t, y, x)[c] == expected);
                }
        tensor_free(&t);
        tensor_free(&before);
    }
}

static void test_isa_is_limited_by_option_and_environment(void **state) {
    (void)state;
    enum nn_isa best = nn_kernels_get(NN_ISA_AUTO)->isa;
    assert_int_equal(nn_kernels_get(NN_ISA_PLAIN)->isa, NN_ISA_PLAIN);
    assert_true(nn_kernels_get(NN_ISA_AVX2)->isa <= NN_ISA_AVX2);
    setenv("FEWRAY_ISA", "plain", 1);
    assert_int_equal(nn_kernels_get(NN_ISA_AUTO)->isa, NN_ISA_PLAIN);
    assert_int_equal(nn_kernels_get(NN_ISA_AVX512)->isa, NN_ISA_PLAIN);
    setenv("FEWRAY_ISA", "no such thing", 1);
    assert_int_equal(nn_kernels_get(NN_ISA_AUTO)->isa, best);
    unsetenv("FEWRAY_ISA");

    enum nn_isa isa = NN_ISA_AUTO;
    assert_true(nn_isa_from_name("avx2", &isa));
    assert_int_equal(isa, NN_ISA_AVX2);
    assert_false(nn_isa_from_name("sse9", &isa));
}

int main(void) {
    unsetenv("FEWRAY_ISA"); /* every set is tested, whatever the caller prefers */
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_conv_equals_reference),
        cmocka_unit_test(test_conv_has_same_bits_for_any_rows_and_tiles),
        cmocka_unit_test(test_conv_has_same_bits_on_all_fma_sets),
        cmocka_unit_test(test_conv_ignores_padding_channels),
        cmocka_unit_test(test_average_pool_equals_reference),
        cmocka_unit_test(test_upsample_add_equals_reference),
        cmocka_unit_test(test_affinity_equals_formula),
        cmocka_unit_test(test_softmax_equals_reference),
        cmocka_unit_test(test_softmax_rows_equals_softmax_of_each_row),
        cmocka_unit_test(test_softmax_to_equals_softmax),
        cmocka_unit_test(test_border_is_zero_or_wraps),
        cmocka_unit_test(test_isa_is_limited_by_option_and_environment),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
