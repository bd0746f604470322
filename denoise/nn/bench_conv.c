/* SPDX-License-Identifier: Apache-2.0 */
/* fewray-bench-conv: speed of the convolutions at the shapes of the denoiser's networks on a
 * 1920x1080 picture, as a share of the peak measured in the same run, and oneDNN's speed where the
 * build found it. Usage: fewray-bench-conv [plain|avx2|avx512 [threads [seconds a shape]]] */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "denoise/nn/bench_conv.h"

enum { WIDTH = 1920, HEIGHT = 1088, LEVELS = 4, SLICE_ROWS = 8, CHUNK = 4, SEGMENT = 64 };

/* Networks of the U-Net in denoise/kpn.c, by their channels at levels 1 to 4. */
static const struct {
    const char *name;
    int channels[LEVELS];
} networks[] = {
    {"default", {32, 48, 64, 64}},
    {"fast", {16, 24, 32, 32}},
    {"wide", {32, 64, 96, 128}},
};

/* The layers: from the channels of a level or a fixed number to those of a level or a fixed one. */
enum { C1 = -1, C2 = -2, C3 = -3, C4 = -4 };
static const struct {
    int level, kernel, in, out, count;
} layers[] = {
    {1, 3, 64, C1, 1}, {1, 3, C1, C1, 3}, {1, 1, C1, 136, 1}, {1, 1, C1, 34, 1},
    {2, 3, C1, C2, 1}, {2, 3, C2, C2, 3}, {2, 1, C2, C1, 1},  {2, 1, C2, 34, 1},
    {3, 3, C2, C3, 1}, {3, 3, C3, C3, 3}, {3, 1, C3, C2, 1},  {3, 1, C3, 34, 1},
    {4, 3, C3, C4, 1}, {4, 3, C4, C4, 1}, {4, 1, C4, C3, 1},  {4, 1, C4, 25, 1},
};
enum { LAYERS = sizeof layers / sizeof *layers };

double bench_now(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* --- peak: multiply-adds of many independent vectors, the most that the core can do; FLOP */

#define STEPS 40000
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

/* FLOP/s of one core; 0 where it isn't known. */
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

/* --- ours */

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

static int round_up(int n, int to) {
    return (n + to - 1) / to * to;
}

static struct nn_tensor random_tensor(const struct bench_shape *s, int channels) {
    channels = round_up(channels, NN_LANES);
    return (struct nn_tensor){s->height, s->width, channels,
                              random_floats(nn_tensor_bytes(s->height, s->width, channels))};
}

static double flop_of(const struct bench_shape *s) {
    return 2.0 * s->kernel * s->kernel * s->in * s->out * s->height * s->width;
}

/* FLOP/s of the fastest of many short repetitions; rows are shared out as in denoise/kpn.c. */
static double measure_conv(const struct nn_kernels *kernels, const struct bench_shape *s,
                           int threads, double seconds) {
    struct nn_conv conv = {.kernel = s->kernel,
                           .in = round_up(s->in, NN_LANES),
                           .in_used = round_up(s->in, 4),
                           .out = round_up(s->out, NN_LANES),
                           .out_used = round_up(s->out, NN_LANES / 2)};
    size_t weights = (size_t)conv.out * (size_t)(s->kernel * s->kernel * conv.in);
    conv.weights = random_floats(weights * sizeof(float));
    conv.bias = random_floats((size_t)conv.out * sizeof(float));
    struct nn_tensor in = random_tensor(s, s->in), out = random_tensor(s, s->out);

    double best = 0.0, flop = flop_of(s);
    int calls = 1 + (int)(2e6 / flop);
    for (double end = bench_now() + seconds; bench_now() < end;) {
        double start = bench_now();
        for (int i = 0; i < calls; ++i)
            if (threads == 1)
                for (int y = 0; y < s->height; y += CHUNK)
                    kernels->conv(&conv, &in, &out, NN_LEAKY_RELU, y, y + CHUNK);
            else
#pragma omp parallel for schedule(dynamic) num_threads(threads)
                for (int y = 0; y < s->height; y += CHUNK)
                    kernels->conv(&conv, &in, &out, NN_LEAKY_RELU, y, y + CHUNK);
        double rate = calls * flop / (bench_now() - start);
        best = rate > best ? rate : best;
    }
    free(in.data);
    free(out.data);
    nn_conv_clear(&conv);
    return best;
}

static void measure_softmax(const struct nn_kernels *kernels, int n, double seconds) {
    enum { ROWS = 256 };
    float *values = random_floats(ROWS * 48 * sizeof(float)), weights[4 * 48];
    double best = 1e9;
    for (double end = bench_now() + seconds; bench_now() < end;) {
        double start = bench_now();
        for (int i = 0; i < ROWS; i += 4)
            kernels->softmax_to(values + i * n, 4, n, NULL, n, weights);
        double spent = (bench_now() - start) / ROWS;
        best = spent < best ? spent : best;
    }
    printf("softmax of %d: %.1f ns\n", n, best * 1e9);
    free(values);
}

/* --- table */

static int channels_of(const int *channels, int c) {
    return c < 0 ? channels[-c - 1] : c;
}

static double theirs_of(const struct bench_shape *s, enum nn_isa isa, int threads, double seconds) {
#ifdef HAVE_DNNL
    return bench_dnnl(s, isa, threads, seconds);
#else
    (void)s, (void)isa, (void)threads, (void)seconds;
    return 0.0;
#endif
}

static void print_row(const char *name, double gflop, double ours, double theirs, double peak) {
    printf("%-24s %7.2f %7.1f %4.0f %%", name, gflop, ours * 1e-9, 100.0 * ours / peak);
    if (theirs > 0.0)
        printf(" %7.1f %6.2f", theirs * 1e-9, ours / theirs);
    putchar('\n');
    fflush(stdout);
}

static void measure_network(int network, const struct nn_kernels *kernels, int threads,
                            double seconds, double peak) {
    double flop = 0.0, our_time = 0.0, their_time = 0.0;
    for (int i = 0; i < LAYERS; ++i) {
        const int *channels = networks[network].channels;
        int width = WIDTH >> layers[i].level, height = HEIGHT >> layers[i].level;
        struct bench_shape s = {SLICE_ROWS * threads, width, channels_of(channels, layers[i].in),
                                channels_of(channels, layers[i].out), layers[i].kernel};
        if (layers[i].out > 0) /* predictions are used before they leave the cache */
            s.width = SEGMENT;
        double ours = measure_conv(kernels, &s, threads, seconds);
        double theirs = theirs_of(&s, kernels->isa, threads, seconds);
        double whole =
            flop_of(&s) * layers[i].count * width * height / ((double)s.width * s.height);
        flop += whole;
        our_time += whole / ours;
        their_time += theirs > 0.0 ? whole / theirs : 0.0;
        char name[64];
        snprintf(name, sizeof name, "%d x %dx%d %3d -> %3d, %d", layers[i].count, s.kernel,
                 s.kernel, s.in, s.out, width);
        print_row(name, whole * 1e-9, ours, theirs, peak);
    }
    print_row(networks[network].name, flop * 1e-9, flop / our_time,
              their_time > 0.0 ? flop / their_time : 0.0, peak);
}

int main(int argc, char **argv) {
    enum nn_isa isa = NN_ISA_AUTO;
    int threads = argc > 2 ? atoi(argv[2]) : 1;
    double seconds = argc > 3 ? atof(argv[3]) : 0.1;
    if ((argc > 1 && !nn_isa_from_name(argv[1], &isa)) || threads < 1) {
        fputs("usage: fewray-bench-conv [plain|avx2|avx512 [threads [seconds]]]\n", stderr);
        return 2;
    }
    const struct nn_kernels *kernels = nn_kernels_get(isa);
    double peak = measure_peak(kernels->isa, seconds) * threads;
    printf("%s, %d threads, peak %.1f GFLOP/s\n", kernels->name, threads, peak * 1e-9);
    printf("%-24s   GFLOP  GFLOP/s  peak  oneDNN  ratio\n", "layers, width");
    for (int i = 0; i < (int)(sizeof networks / sizeof *networks); ++i)
        measure_network(i, kernels, threads, seconds, peak);
    measure_softmax(kernels, 34, seconds);
    measure_softmax(kernels, 4, seconds);
    return 0;
}
