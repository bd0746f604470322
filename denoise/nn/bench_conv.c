/* SPDX-License-Identifier: Apache-2.0 */
/* fewray-bench-conv: speed of the convolutions on one core at the shapes of our networks, for each
 * instruction set, as a share of the core's peak measured in the same run, and oneDNN's speed where
 * the build found it. Usage: fewray-bench-conv [seconds a shape] */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "denoise/nn/bench_conv.h"
#include "denoise/nn/nn.h"

static const struct bench_shape shapes[] = {
    {200, 350, 32, 32, 3}, {200, 350, 48, 32, 3},  {100, 175, 48, 48, 3}, {50, 88, 64, 64, 3},
    {25, 44, 64, 64, 3},   {200, 350, 32, 144, 1}, {8, 88, 32, 144, 1},   {16, 16, 16, 16, 3},
    {16, 16, 16, 32, 3},   {16, 16, 32, 32, 3},    {16, 16, 48, 16, 3},   {8, 8, 16, 32, 3},
    {8, 8, 32, 32, 3},     {8, 8, 64, 64, 3},      {4, 4, 32, 32, 3},
};

double bench_now(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Multiply-adds of ten or more independent vectors: the most that the core can do, FLOP. */
#define STEPS 2000
#define PEAK(name, lanes, sums, options)                                                           \
    options static double peak_##name(void) {                                                      \
        typedef float vec __attribute__((vector_size(lanes * 4)));                                 \
        vec sum[sums], a = 0.999f - (vec){0}, b = 0.001f - (vec){0};                               \
        _Pragma("GCC unroll 32") for (int k = 0; k < sums; ++k) sum[k] = (float)k - (vec){0};      \
        for (int i = 0; i < STEPS; ++i) {                                                          \
            _Pragma("GCC unroll 32") for (int k = 0; k < sums; ++k) {                              \
                sum[k] = sum[k] * a + b;                                                           \
                __asm__ volatile("" : "+v"(sum[k]));                                               \
            }                                                                                      \
        }                                                                                          \
        volatile float sink = 0.0f;                                                                \
        _Pragma("GCC unroll 32") for (int k = 0; k < sums; ++k) sink += sum[k][0];                 \
        return 2.0 * lanes * sums * STEPS;                                                         \
    }
#if defined(__x86_64__)
PEAK(plain, 4, 12, )
PEAK(avx2, 8, 12, __attribute__((target("avx2,fma"))))
PEAK(avx512, 16, 12, __attribute__((target("avx512f,avx512vl"))))
#endif

static double measure_peak(enum nn_isa isa, double seconds) {
    double best = 0.0;
#if defined(__x86_64__)
    double (*const peaks[])(void) = {NULL, peak_plain, peak_avx2, peak_avx512};
    for (double end = bench_now() + seconds; bench_now() < end;) {
        double start = bench_now(), flop = peaks[isa]();
        double rate = flop / (bench_now() - start);
        best = rate > best ? rate : best;
    }
#else
    (void)isa, (void)seconds;
#endif
    return best;
}

static float *random_floats(size_t bytes) {
    float *data = aligned_alloc(64, bytes);
    if (!data) {
        fputs("fewray-bench-conv: no memory\n", stderr);
        exit(1);
    }
    for (size_t i = 0; i < bytes / sizeof *data; ++i)
        data[i] = (float)(rand() % 2001 - 1000) * 1e-3f;
    return data;
}

/* FLOP/s of the fastest of many short repetitions. */
static double measure_conv(const struct nn_kernels *kernels, const struct bench_shape *s,
                           double seconds) {
    struct nn_conv conv = {.kernel = s->kernel, .in = s->in, .in_used = s->in, .out = s->out};
    size_t weights = (size_t)(s->out * s->kernel * s->kernel * s->in);
    conv.weights = random_floats(weights * sizeof(float));
    conv.bias = random_floats((size_t)s->out * sizeof(float));
    struct nn_tensor in = {s->height, s->width, s->in, NULL}, out = in;
    out.channels = s->out;
    in.data = random_floats(nn_tensor_bytes(s->height, s->width, s->in));
    out.data = random_floats(nn_tensor_bytes(s->height, s->width, s->out));

    double flop = 2.0 * (double)weights * s->height * s->width, best = 0.0;
    int calls = 1 + (int)(2e7 / flop);
    for (double end = bench_now() + seconds; bench_now() < end;) {
        double start = bench_now();
        for (int i = 0; i < calls; ++i)
            kernels->conv(&conv, &in, &out, NN_LEAKY_RELU, 0, s->height);
        double rate = calls * flop / (bench_now() - start);
        best = rate > best ? rate : best;
    }
    free(in.data);
    free(out.data);
    nn_conv_clear(&conv);
    return best;
}

static void measure_softmax(const struct nn_kernels *kernels, int n, double seconds) {
    enum { ROWS = 4096 };
    float *values = random_floats(ROWS * 48 * sizeof(float));
    double best = 1e9;
    for (double end = bench_now() + seconds; bench_now() < end;) {
        double start = bench_now();
        kernels->softmax_rows(values, ROWS, n, n);
        double spent = (bench_now() - start) / ROWS;
        best = spent < best ? spent : best;
    }
    printf("%-7s softmax of %d: %.1f ns\n", kernels->name, n, best * 1e9);
    free(values);
}

static void print_rate(const char *name, const struct bench_shape *s, double rate, double peak) {
    printf("%-7s %dx%d %3d -> %3d at %3dx%3d: %6.1f GFLOP/s", name, s->kernel, s->kernel, s->in,
           s->out, s->width, s->height, rate * 1e-9);
    if (peak > 0.0)
        printf(", %3.0f %% of peak", 100.0 * rate / peak);
    putchar('\n');
}

int main(int argc, char **argv) {
    double seconds = argc > 1 ? atof(argv[1]) : 0.2, peak = 0.0;
    const int count = sizeof shapes / sizeof *shapes;
    for (int isa = NN_ISA_PLAIN; isa <= NN_ISA_AVX512; ++isa) {
        const struct nn_kernels *kernels = nn_kernels_get((enum nn_isa)isa);
        if (kernels->isa != (enum nn_isa)isa)
            continue;
        peak = measure_peak(kernels->isa, seconds);
        printf("%-7s peak %.1f GFLOP/s\n", kernels->name, peak * 1e-9);
        for (int i = 0; i < count; ++i)
            print_rate(kernels->name, &shapes[i], measure_conv(kernels, &shapes[i], seconds), peak);
        measure_softmax(kernels, 35, seconds);
        measure_softmax(kernels, 4, seconds);
    }
#ifdef HAVE_DNNL
    for (int i = 0; i < count; ++i)
        print_rate("oneDNN", &shapes[i], bench_dnnl(&shapes[i], seconds), peak);
#endif
    return 0;
}
