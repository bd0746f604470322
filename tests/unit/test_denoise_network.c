/* SPDX-License-Identifier: Apache-2.0 */
/* The network in C against PyTorch, layer by layer, on tensors that denoise/train/export.py stored
 * with the shipped weights; and its instruction sets against each other. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "denoise/kpn.h"
#include "denoise/kpn_bands.h"
#include "denoise/kpn_network.h"
#include "denoise/weights_kpn.h"

/* A stored tensor, (channels, height, width), put together from its two halves. */
struct stored {
    int channels, height, width;
    float *values;
};

static const struct nn_weight *find_stored(const struct nn_weights *file, const char *name) {
    for (int i = 0; i < file->count; i++)
        if (!strcmp(file->tensors[i].name, name))
            return &file->tensors[i];
    return NULL;
}

static struct stored stored_tensor(const struct nn_weights *file, const char *layer) {
    char name[64];
    snprintf(name, sizeof name, "test.%s", layer);
    const struct nn_weight *high = find_stored(file, name);
    if (!high)
        return (struct stored){0};
    snprintf(name, sizeof name, "test.%s.rest", layer);
    const struct nn_weight *rest = find_stored(file, name);
    assert_non_null(rest);
    struct stored s = {high->shape[0], high->shape[2], high->shape[3], NULL};
    size_t count = (size_t)(s.channels * s.height * s.width);
    s.values = malloc(count * sizeof *s.values);
    for (size_t i = 0; i < count; i++)
        s.values[i] = high->data[i] + rest->data[i];
    return s;
}

/* A network that is built into the library, and what PyTorch made of it. */
struct shipped {
    const unsigned char *weights;
    size_t (*size)(void);
    const char *reference;
};

struct fixture {
    struct nn_weights *weights, *reference;
    struct stored raw;
    struct fewray_denoise_input in;
};

static void planes(struct fewray_channels *to, const struct stored *raw, int first, int count) {
    for (int c = 0; c < count; c++)
        to->channel[c] = raw->values + (first + c) * raw->height * raw->width;
    to->pixel_stride = 1;
    to->row_stride = raw->width;
}

static int setup(void **state) {
    const struct shipped *shipped = *state;
    struct fixture *f = calloc(1, sizeof *f);
    struct fewray_error error;
    assert_int_equal(
        nn_weights_parse(shipped->weights, shipped->size(), "kpn", &f->weights, &error), FEWRAY_OK);
    assert_int_equal(nn_weights_read(shipped->reference, &f->reference, &error), FEWRAY_OK);
    f->raw = stored_tensor(f->reference, "raw");
    f->in.width = f->raw.width;
    f->in.height = f->raw.height;
    planes(&f->in.color, &f->raw, 0, 3);
    planes(&f->in.emission, &f->raw, 3, 3);
    planes(&f->in.variance, &f->raw, 6, 3);
    planes(&f->in.albedo, &f->raw, 9, 3);
    planes(&f->in.normal, &f->raw, 12, 3);
    planes(&f->in.depth, &f->raw, 15, 1);
    planes(&f->in.irradiance, &f->raw, 16, 3);
    planes(&f->in.confidence, &f->raw, 19, 1);
    planes(&f->in.shaded_albedo, &f->raw, 20, 3);
    *state = f;
    return 0;
}

static int teardown(void **state) {
    struct fixture *f = *state;
    nn_weights_destroy(&f->weights);
    nn_weights_destroy(&f->reference);
    free(f->raw.values);
    free(f);
    return 0;
}

struct comparison {
    const struct fixture *fixture;
    int compared;
};

/* Within 1e-4 of the tensor's largest value. */
static void compare(void *user, const char *layer, const float *pixels, int height, int width,
                    int channels, size_t row_stride, size_t pixel_stride) {
    struct comparison *comparison = user;
    struct stored expected = stored_tensor(comparison->fixture->reference, layer);
    if (!expected.values)
        return;
    if (!strcmp(layer, "features")) /* PyTorch's are before 2x2 pixels became one */
        goto done;
    assert_int_equal(expected.height, height);
    assert_int_equal(expected.width, width);
    assert_true(expected.channels <= channels);
    float largest = 0, worst = 0;
    for (int c = 0; c < expected.channels; c++)
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++) {
                float wanted = expected.values[(c * height + y) * width + x];
                float got = pixels[(size_t)y * row_stride + (size_t)x * pixel_stride + (size_t)c];
                largest = fmaxf(largest, fabsf(wanted));
                worst = fmaxf(worst, fabsf(wanted - got));
                assert_true(isfinite(got));
            }
    if (worst > 1e-4f * largest)
        fail_msg("%s differs by %g where the largest value is %g", layer, (double)worst,
                 (double)largest);
    comparison->compared++;
done:
    free(expected.values);
}

static void run(const struct fixture *f, enum nn_isa isa, int threads, float *out,
                struct comparison *comparison) {
    struct kpn *kpn = NULL;
    struct kpn_scale scale;
    assert_int_equal(kpn_create(f->weights, nn_kernels_get(isa), &kpn, NULL), FEWRAY_OK);
    assert_int_equal(kpn_measure(&f->in, threads, &scale, NULL), FEWRAY_OK);
    struct kpn_region all = {0, 0, f->in.width, f->in.height};
    size_t bytes = kpn_memory(kpn, 1, all.height, all.width, threads, 0);
    void *memory = aligned_alloc(64, bytes);
    struct kpn_output output = {{out, out + 1, out + 2}, 3, 3 * (ptrdiff_t)all.width};
    struct kpn_job job = {.in = &f->in,
                          .scale = &scale,
                          .region = all,
                          .core = all,
                          .memory = memory,
                          .memory_bytes = bytes,
                          .threads = threads,
                          .out = &output};
    if (comparison) {
        job.trace = compare;
        job.trace_user = comparison;
    }
    assert_int_equal(kpn_run(kpn, &job, NULL), FEWRAY_OK);
    free(memory);
    kpn_destroy(&kpn);
}

static void test_every_layer_equals_pytorch(void **state) {
    const struct fixture *f = *state;
    float *out = malloc((size_t)(f->in.width * f->in.height * 3) * sizeof *out);
    struct comparison comparison = {f, 0};
    run(f, NN_ISA_AUTO, 2, out, &comparison);
    assert_int_equal(comparison.compared, 17 + 4 + 4 + 1);
    struct stored filtered = stored_tensor(f->reference, "kernel0");
    for (int y = 0; y < f->in.height; y++)
        for (int x = 0; x < f->in.width; x++)
            for (int c = 0; c < 3; c++) {
                int i = y * f->in.width + x;
                float wanted = filtered.values[c * f->in.width * f->in.height + i] *
                                   fmaxf(f->in.albedo.channel[c][i], KPN_ALBEDO_MIN) +
                               f->in.emission.channel[c][i];
                assert_float_equal(out[3 * i + c], wanted, 1e-4f * (1 + fabsf(wanted)));
            }
    free(filtered.values);
    free(out);
}

static void test_stored_features_are_those_of_the_code(void **state) {
    const struct fixture *f = *state;
    struct kpn_scale scale;
    struct stored wanted = stored_tensor(f->reference, "features");
    int w = f->in.width, h = f->in.height;
    assert_int_equal(kpn_measure(&f->in, 1, &scale, NULL), FEWRAY_OK);
    float *memory =
        malloc((KPN_FEATURE_SCRATCH(w) + (size_t)(3 + KPN_FEATURES) * (size_t)w) * sizeof *memory);
    float *light = memory + KPN_FEATURE_SCRATCH(w), *features = light + 3 * w;
    for (int y = 0; y < h; y++) {
        kpn_feature_row(&f->in, &scale, y, 0, w, memory, light, features);
        for (int i = 0; i < KPN_FEATURES * w; i++)
            assert_float_equal(features[i], wanted.values[(i / w * h + y) * w + i % w], 2e-5f);
    }
    free(memory);
    free(wanted.values);
}

static void test_instruction_sets_agree(void **state) {
    const struct fixture *f = *state;
    int count = f->in.width * f->in.height * 3;
    float *plain = malloc((size_t)count * sizeof *plain),
          *fast = malloc((size_t)count * sizeof *fast);
    run(f, NN_ISA_PLAIN, 1, plain, NULL);
    static const enum nn_isa sets[] = {NN_ISA_AVX2, NN_ISA_AVX512};
    for (int s = 0; s < 2; s++) {
        run(f, sets[s], 2, fast, NULL);
        for (int i = 0; i < count; i++)
            assert_float_equal(fast[i], plain[i], 1e-5f * (1 + fabsf(plain[i])));
    }
    free(plain);
    free(fast);
}

/* Whatever a layer writes lies in the rows that are kept: the border above with its first row, and
 * never more than there is room for. */
static void check_bands(const struct kpn *kpn, int height, int band) {
    struct kpn_bands bands;
    int room[BUFFER_COUNT];
    kpn_bands_capacity(kpn->layers, KPN_LAYER_COUNT, kpn->levels, height, band, room);
    kpn_bands_start(&bands, kpn->layers, KPN_LAYER_COUNT, kpn->levels, height);
    for (int end = 0; end < height; kpn_bands_drop(&bands)) {
        end = end + band < height ? end + band : height;
        for (int i = 0; i < KPN_LAYER_COUNT; i++) {
            const struct kpn_layer *layer = &kpn->layers[i];
            const int b = (int)layer->output, begin = bands.made[i];
            bands.made[i] = kpn_bands_limit(&bands, i, end);
            if (b == NONE || bands.made[i] == begin)
                continue;
            const int border = b >= FIRST_IMAGE ? KPN_BORDER : 1;
            const int first = begin == 0 ? -border : layer->op == OP_KEY ? 2 * begin : begin;
            assert_true(bands.first[b] <= first);
            assert_true(kpn_bands_end(&bands, b) - bands.first[b] <= room[b]);
            if (layer->op == OP_DOWN)
                assert_true(bands.first[kpn_keys_of(layer->output)] <= first);
        }
    }
    for (int i = 0; i < KPN_LAYER_COUNT; i++)
        assert_int_equal(bands.made[i], kpn_bands_rows(&bands, i));
}

static void test_bands_keep_what_layers_write(void **state) {
    const struct fixture *f = *state;
    struct kpn *kpn = NULL;
    assert_int_equal(kpn_create(f->weights, nn_kernels_get(NN_ISA_AUTO), &kpn, NULL), FEWRAY_OK);
    for (int height = KPN_ALIGN; height <= 1200; height += 3 * KPN_ALIGN)
        for (int band = KPN_ALIGN; band <= height; band += KPN_ALIGN)
            check_bands(kpn, height, band);
    kpn_destroy(&kpn);
}

int main(void) {
    static struct shipped whole = {kpn_weights, kpn_weights_size, TEST_DATA "/kpn_reference.bin"},
                          fast = {kpn_fast_weights, kpn_fast_weights_size,
                                  TEST_DATA "/kpn_fast_reference.bin"};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate_setup_teardown(test_stored_features_are_those_of_the_code, setup,
                                                 teardown, &whole),
        cmocka_unit_test_prestate_setup_teardown(test_every_layer_equals_pytorch, setup, teardown,
                                                 &whole),
        cmocka_unit_test_prestate_setup_teardown(test_every_layer_equals_pytorch, setup, teardown,
                                                 &fast),
        cmocka_unit_test_prestate_setup_teardown(test_bands_keep_what_layers_write, setup, teardown,
                                                 &whole),
        cmocka_unit_test_prestate_setup_teardown(test_instruction_sets_agree, setup, teardown,
                                                 &whole),
        cmocka_unit_test_prestate_setup_teardown(test_instruction_sets_agree, setup, teardown,
                                                 &fast),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
