/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of any shape, within any memory and on any number of threads: constants come back, and
 * bits don't depend on how the work is cut. */

#include "denoise_stage.h"

/* Around the multiples of 2 (U-Net), 16 (coarsest level), 32 (bands) and 64 (blocks, segments). */
static const struct {
    int width, height;
} SIZES[] = {
    {1, 1},   {1, 2},   {2, 1},   {2, 2},   {1, 70},  {70, 1},  {3, 5},     {5, 3},
    {15, 17}, {16, 16}, {17, 15}, {31, 33}, {33, 31}, {63, 65}, {64, 64},   {65, 63},
    {127, 2}, {128, 3}, {129, 1}, {2, 127}, {1, 129}, {96, 33}, {16384, 4},
};
enum { SIZE_COUNT = sizeof SIZES / sizeof *SIZES };

static void check_constant(const struct stage *stage, int model, int width, int height,
                           float radiance) {
    struct picture p = picture_new(width, height);
    for (size_t i = 0; i < count(&p); i++)
        p.color[i] = radiance;
    const struct fewray_denoise_input in = color_alone(&p);
    stage_run(stage, model, &in, p.out);
    for (size_t i = 0; i < count(&p); i++)
        if (!(fabs((double)p.out[i] - radiance) <= MEAN_ERROR * radiance))
            fail_msg("%s, %d x %d: %.9g became %.9g", MODEL_NAMES[model], width, height,
                     (double)radiance, (double)p.out[i]);
    picture_clear(&p);
}

static void test_constants_come_back_at_any_size(void **state) {
    (void)state;
    struct stage stage;
    stage_open(&stage);
    for (int s = 0; s < SIZE_COUNT; s++)
        check_constant(&stage, 1, SIZES[s].width, SIZES[s].height, 0.75f);
    /* The large ones are the fast model's. */
    for (int s = 0; s + 1 < SIZE_COUNT; s++)
        check_constant(&stage, 0, SIZES[s].width, SIZES[s].height, 0.75f);
    stage_close(&stage);
}

static void test_constants_of_any_radiance_come_back(void **state) {
    (void)state;
    static const float radiances[] = {0, 1e-30f, 1e-12f, 1e-6f, 1, 65504, 1e6f, 1e12f};
    struct stage stage;
    stage_open(&stage);
    for (int model = 0; model < MODELS; model++)
        for (size_t r = 0; r < sizeof radiances / sizeof *radiances; r++)
            check_constant(&stage, model, 21, 18, radiances[r]);
    stage_close(&stage);
}

static void test_all_layers_at_any_size_stay_finite(void **state) {
    (void)state;
    struct stage stage;
    stage_open(&stage);
    for (int s = 0; s + 1 < SIZE_COUNT; s++) {
        struct picture p = room(SIZES[s].width, SIZES[s].height);
        const struct fewray_denoise_input in = all_layers(&p);
        stage_run(&stage, 1, &in, p.out);
        assert_all_finite(p.out, count(&p), "a room");
        picture_clear(&p);
    }
    stage_close(&stage);
}

/* --- memory and threads */

static int run_within(struct picture *p, int threads, size_t memory, float *out,
                      struct fewray_denoise_stats *stats, struct fewray_error *error) {
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    fewray_denoise_options_init(&options);
    options.threads = threads;
    options.max_memory = memory;
    options.model = FEWRAY_DENOISE_FAST;
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, error), FEWRAY_OK);
    const struct fewray_denoise_input in = all_layers(p);
    const int status = fewray_denoiser_run(denoiser, &in, out, stats, error);
    fewray_denoiser_destroy(&denoiser);
    return status;
}

/* The least memory that the picture can be denoised within, to 256 KiB. */
static size_t least_memory(struct picture *p, int threads) {
    size_t low = 0, high = (size_t)64 << 20;
    struct fewray_error error;
    volatile int stop = 1; /* whether it fits is known before the first layer */
    while (high - low > 262144) {
        const size_t middle = (low + high) / 2;
        struct fewray_denoise_options options;
        struct fewray_denoiser *denoiser = NULL;
        fewray_denoise_options_init(&options);
        options.threads = threads;
        options.max_memory = middle;
        options.model = FEWRAY_DENOISE_FAST;
        options.cancel = &stop;
        assert_int_equal(fewray_denoiser_create(&options, &denoiser, &error), FEWRAY_OK);
        const struct fewray_denoise_input in = all_layers(p);
        const int status = fewray_denoiser_run(denoiser, &in, p->out, NULL, &error);
        fewray_denoiser_destroy(&denoiser);
        if (status == FEWRAY_ERROR_CANCELLED)
            high = middle;
        else
            low = middle;
    }
    return high;
}

static void test_bits_depend_neither_on_threads_nor_on_columns(void **state) {
    (void)state;
    struct picture p = room(700, 24);
    float *whole = layer(&p, 3);
    struct fewray_denoise_stats stats;
    struct fewray_error error = {0};
    assert_int_equal(run_within(&p, 1, 0, whole, &stats, &error), FEWRAY_OK);
    assert_int_equal(stats.regions, 1);
    static const int threads[] = {1, 2, 7};
    const size_t memories[] = {least_memory(&p, 7), SIZE_MAX}; /* each thread needs some */
    for (int t = 0; t < 3; t++) {
        for (int m = 0; m < 2; m++) {
            memset(p.out, 0, sizeof(float) * count(&p));
            assert_int_equal(run_within(&p, threads[t], memories[m], p.out, &stats, &error),
                             FEWRAY_OK);
            assert_true(stats.buffer_bytes <= memories[m]);
            if (m == 0)
                assert_true(stats.regions > 1);
            assert_memory_equal(p.out, whole, sizeof(float) * count(&p));
        }
    }
    free(whole);
    picture_clear(&p);
}

/* What the message asks for is enough. */
static void test_too_little_memory_names_what_is_enough(void **state) {
    (void)state;
    struct picture p = room(300, 20);
    struct fewray_denoise_stats stats;
    static const size_t memories[] = {1, 4096, 65536};
    for (int m = 0; m < 3; m++) {
        struct fewray_error error = {0};
        assert_int_equal(run_within(&p, 1, memories[m], p.out, &stats, &error),
                         FEWRAY_ERROR_ARGUMENT);
        const char *asked = strstr(error.what, "at least ");
        assert_non_null(asked);
        const size_t enough = (size_t)strtoul(asked + 9, NULL, 10) << 20;
        assert_int_equal(run_within(&p, 1, enough, p.out, &stats, &error), FEWRAY_OK);
    }
    picture_clear(&p);
}

static void test_impossible_sizes_are_refused(void **state) {
    (void)state;
    static const int sizes[][2] = {{0, 1},         {1, 0},         {-1, 5},           {5, -1},
                                   {INT32_MAX, 1}, {1, INT32_MAX}, {1 << 20, 1 << 20}};
    struct stage stage;
    stage_open(&stage);
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        float pixel[3] = {0}, out[3];
        struct fewray_error error = {0};
        const struct fewray_denoise_input in = {
            .width = sizes[s][0], .height = sizes[s][1], .color = fewray_interleaved(pixel, 1)};
        assert_int_equal(fewray_denoiser_run(stage.denoisers[0], &in, out, NULL, &error),
                         FEWRAY_ERROR_ARGUMENT);
        assert_true(error.what[0]);
    }
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_constants_come_back_at_any_size),
        cmocka_unit_test(test_constants_of_any_radiance_come_back),
        cmocka_unit_test(test_all_layers_at_any_size_stay_finite),
        cmocka_unit_test(test_bits_depend_neither_on_threads_nor_on_columns),
        cmocka_unit_test(test_too_little_memory_names_what_is_enough),
        cmocka_unit_test(test_impossible_sizes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
