/* SPDX-License-Identifier: Apache-2.0 */
/* The public denoiser: checks its input, loads the weights, and takes a picture through the
 * network, whole or in columns. */

#include "fewray/denoise.h"

#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "denoise/emitters.h"
#include "denoise/kpn.h"
#include "denoise/kpn_layers.h"
#include "denoise/run.h"
#include "denoise/weights_kpn.h"
#include "features/pages.h"

#define DEFAULT_MEMORY ((size_t)256 << 20)
#define BAND_MEMORY    ((size_t)48 << 20) /* larger bands of rows than fit into it bring no speed */
#define SETTLED_ERROR  0.001f
#define MAX_SIDE       (1 << 20)
#define MAX_PIXELS     ((size_t)1 << 31)
/* One thread has this done in 30 ms. Two would save 10 on an idle machine, but wait for each other
 * after each layer, on a busy one for ten times as long. */
#define THREAD_PIXELS 32768
#define MIN_CORE      64 /* narrower columns would be nearly all overlap */

struct fewray_denoiser {
    struct fewray_denoise_options options;
    struct kpn *kpn;
    int threads;
};

void fewray_denoise_options_init(struct fewray_denoise_options *options) {
    *options = (struct fewray_denoise_options){0};
}

struct fewray_channels fewray_interleaved(const float *rgb, int width) {
    if (!rgb)
        return (struct fewray_channels){0};
    return (struct fewray_channels){
        .channel = {rgb, rgb + 1, rgb + 2}, .pixel_stride = 3, .row_stride = (ptrdiff_t)width * 3};
}

struct fewray_channels fewray_planar(float *const planes[3], int width) {
    return (struct fewray_channels){
        .channel = {planes[0], planes[1], planes[2]}, .pixel_stride = 1, .row_stride = width};
}

static int load_weights(const struct fewray_denoise_options *options, struct nn_weights **weights,
                        struct fewray_error *error) {
    if (options->weights_path)
        return nn_weights_read(options->weights_path, weights, error);
    if (options->model == FEWRAY_DENOISE_DEFAULT)
        return nn_weights_parse(kpn_weights, kpn_weights_size(), "the built-in denoiser weights",
                                weights, error);
    if (options->model == FEWRAY_DENOISE_FAST)
        return nn_weights_parse(kpn_fast_weights, kpn_fast_weights_size(),
                                "the built-in fast denoiser weights", weights, error);
    return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0, "the denoiser has no model %d",
                       (int)options->model);
}

int fewray_denoiser_create(const struct fewray_denoise_options *options,
                           struct fewray_denoiser **out, struct fewray_error *error) {
    *out = NULL;
    struct nn_weights *weights = NULL;
    enum nn_isa isa = NN_ISA_AUTO;
    struct fewray_denoiser *denoiser = calloc(1, sizeof *denoiser);
    if (!denoiser)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the denoiser");
    denoiser->options = *options;
    denoiser->threads = options->threads > 0 ? options->threads : omp_get_num_procs();
    int status = FEWRAY_OK;
    if (options->isa && !nn_isa_from_name(options->isa, &isa))
        status = fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                             "unknown instruction set '%s': use auto, plain, avx2 or avx512",
                             options->isa);
    else
        status = load_weights(options, &weights, error);
    if (status == FEWRAY_OK)
        status = kpn_create(weights, nn_kernels_get(isa), &denoiser->kpn, error);
    nn_weights_destroy(&weights);
    if (status == FEWRAY_OK)
        *out = denoiser;
    else
        fewray_denoiser_destroy(&denoiser);
    return status;
}

void fewray_denoiser_destroy(struct fewray_denoiser **denoiser) {
    if (!*denoiser)
        return;
    kpn_destroy(&(*denoiser)->kpn);
    free(*denoiser);
    *denoiser = NULL;
}

/* --- columns and regions */

/* The picture is cut into columns alone: the network's memory hardly grows with the height. */
struct columns {
    int count, width; /* width: a multiple of KPN_ALIGN, without overlap */
    size_t bytes;
};

static int round_up(int v) {
    return (v + KPN_ALIGN - 1) / KPN_ALIGN * KPN_ALIGN;
}

static int region_side(int core, int count, int side) {
    int overlaps = count == 1 ? 0 : (count == 2 ? 1 : 2);
    int region = core + overlaps * KPN_OVERLAP;
    return region < round_up(side) ? region : round_up(side);
}

/* The fewest columns whose buffers fit into max_memory. */
static int cut(const struct kpn *kpn, const struct fewray_denoise_input *in, int threads,
               size_t max_memory, struct columns *columns, struct fewray_error *error) {
    const int height = in->height, width = in->width, slots = kpn_layers_slots(in);
    for (columns->count = 1;; columns->count++) {
        columns->width = round_up((width + columns->count - 1) / columns->count);
        int region = region_side(columns->width, columns->count, width);
        columns->bytes = kpn_memory(kpn, slots, round_up(height), region, threads,
                                    max_memory < BAND_MEMORY ? max_memory : BAND_MEMORY);
        if (columns->bytes <= max_memory)
            break;
        if (columns->width <= MIN_CORE)
            return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                               "the denoiser can't work within %zu MiB: give it at least %zu MiB",
                               max_memory >> 20, (columns->bytes >> 20) + 1);
    }
    /* Rounding up the width may have made the last columns empty. */
    columns->count = (width + columns->width - 1) / columns->width;
    return FEWRAY_OK;
}

static void span(int core_begin, int core_size, int side, int *begin, int *size) {
    int end = core_begin + core_size + KPN_OVERLAP;
    *begin = core_begin > KPN_OVERLAP ? core_begin - KPN_OVERLAP : 0;
    *size = (end < round_up(side) ? end : round_up(side)) - *begin;
}

/* Grows *left and *right to the blocks that are filtered of a row of blocks, begin <= column < end;
 * false where none is. */
static bool widen(const struct kpn_blocks *blocks, int row, int begin, int end, int *left,
                  int *right) {
    bool any = false;
    for (int column = begin; column < end; column++)
        if (kpn_block_at(blocks, row, column) == KPN_BLOCK_FILTER) {
            *left = column < *left ? column : *left;
            *right = column + 1 > *right ? column + 1 : *right;
            any = true;
        }
    return any;
}

/* The next part of pixel columns begin <= x < end that has blocks to filter, from row *row of
 * blocks on; false where there is none. Gaps that two overlaps would fill don't part it. */
static bool next_core(const struct kpn_blocks *blocks, int begin, int end, int *row,
                      struct kpn_region *core) {
    int first = -1, last = -1, left = blocks->columns, right = 0;
    for (; *row < blocks->rows; ++*row) {
        if (first >= 0 && (*row - last - 1) * KPN_BLOCK > 2 * KPN_OVERLAP)
            break;
        if (widen(blocks, *row, begin / KPN_BLOCK, (end - 1) / KPN_BLOCK + 1, &left, &right)) {
            first = first < 0 ? *row : first;
            last = *row;
        }
    }
    if (first < 0)
        return false;
    left = left * KPN_BLOCK > begin ? left * KPN_BLOCK : begin;
    right = right * KPN_BLOCK < end ? right * KPN_BLOCK : end;
    *core =
        (struct kpn_region){left, first * KPN_BLOCK, right - left, (last + 1 - first) * KPN_BLOCK};
    return true;
}

/* Turns a region's progress into the picture's. */
struct progress {
    const struct fewray_denoise_options *options;
    double begin, share;
};

static void report(void *user, double fraction) {
    const struct progress *p = user;
    p->options->progress(p->options->progress_user, p->begin + p->share * fraction);
}

static int run_column(const struct fewray_denoiser *denoiser, int begin, int end,
                      struct kpn_job *job, struct progress *progress, int *regions,
                      struct fewray_error *error) {
    const struct fewray_denoise_input *in = job->in;
    const double start = progress->begin, share = (double)(end - begin) / in->width;
    int status = FEWRAY_OK;
    for (int row = 0; !status && next_core(job->blocks, begin, end, &row, &job->core); ++*regions) {
        span(job->core.x0, job->core.width, in->width, &job->region.x0, &job->region.width);
        span(job->core.y0, job->core.height, in->height, &job->region.y0, &job->region.height);
        progress->share = share * fmin((double)job->core.height / in->height, 1.0);
        progress->begin = start + share * job->core.y0 / in->height;
        status = kpn_run(denoiser->kpn, job, error);
    }
    progress->begin = start + share;
    return status;
}

static int run_columns(const struct fewray_denoiser *denoiser, const struct columns *columns,
                       struct kpn_job job, int *regions, struct fewray_error *error) {
    struct progress progress = {&denoiser->options, 0, 0};
    job.progress = denoiser->options.progress ? report : NULL;
    job.progress_user = &progress;
    int status = FEWRAY_OK;
    for (int i = 0; i < columns->count && !status; i++) {
        int begin = i * columns->width, end = begin + columns->width;
        status = run_column(denoiser, begin, end < job.in->width ? end : job.in->width, &job,
                            &progress, regions, error);
    }
    return status;
}

static double now(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int check(const struct fewray_denoise_input *in, struct fewray_error *error) {
    if (in->width < 1 || in->height < 1 || in->width > MAX_SIDE || in->height > MAX_SIDE ||
        (size_t)in->width * (size_t)in->height > MAX_PIXELS)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "can't denoise a picture of %d x %d pixels", in->width, in->height);
    const struct fewray_channels *layers[7] = {&in->color,         &in->variance, &in->albedo,
                                               &in->shaded_albedo, &in->normal,   &in->emission,
                                               &in->irradiance};
    for (int i = 0; i < 7; i++) {
        const float *const *channel = layers[i]->channel;
        const uint16_t *const *half = layers[i]->half;
        const int floats = !!channel[0] + !!channel[1] + !!channel[2],
                  halves = !!half[0] + !!half[1] + !!half[2];
        const bool all = floats == 3 || (i > 0 && floats == 0 && halves == 3),
                   none = floats + halves == 0;
        if (!all && (i == 0 || !none))
            return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                               "the denoiser needs all three channels of %s",
                               i == 0 ? "color" : "a layer");
    }
    return kpn_layers_check(in, error);
}

static int threads_for(const struct fewray_denoiser *denoiser,
                       const struct fewray_denoise_input *in) {
    const double useful = 1 + (double)in->width * in->height / THREAD_PIXELS;
    return denoiser->options.threads > 0 || useful >= denoiser->threads ? denoiser->threads
                                                                        : (int)useful;
}

int denoiser_run_to(struct fewray_denoiser *denoiser, const struct fewray_denoise_input *in,
                    const struct kpn_output *out, struct fewray_denoise_stats *stats,
                    struct fewray_error *error) {
    const struct fewray_denoise_options *options = &denoiser->options;
    double start = now();
    int threads = threads_for(denoiser, in), regions = 0;
    struct columns columns = {.bytes = 0};
    struct kpn_scale scale;
    struct kpn_blocks blocks = {0};
    void *memory = NULL;
    struct emitters emitters = {0};
    struct fewray_denoise_input split;
    int status = check(in, error);
    if (status == FEWRAY_OK)
        status = cut(denoiser->kpn, in, threads,
                     options->max_memory ? options->max_memory : DEFAULT_MEMORY, &columns, error);
    if (status == FEWRAY_OK)
        status = kpn_measure(in, threads, &scale, error);
    if (status != FEWRAY_OK)
        goto done;
    if (kpn_has(&in->albedo) && !kpn_has(&in->shaded_albedo) && !kpn_has(&in->emission)) {
        status = emitters_find(in, &scale, threads, &emitters, error);
        if (status != FEWRAY_OK)
            goto done;
        split = *in;
        split.emitters = &emitters;
        in = &split;
    }
    status = kpn_blocks_find(
        in, &scale, options->settled_error != 0.0f ? options->settled_error : SETTLED_ERROR,
        threads, &blocks, error);
    if (status != FEWRAY_OK)
        goto done;
    memory = pages_create(columns.bytes);
    if (!memory) {
        status =
            fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                        "no memory for the denoiser's %zu MiB of buffers", columns.bytes >> 20);
        goto done;
    }
    struct kpn_job job = {.in = in,
                          .scale = &scale,
                          .memory = memory,
                          .memory_bytes = columns.bytes,
                          .threads = threads,
                          .out = out,
                          .blocks = &blocks,
                          .cancel = options->cancel};
    status = run_columns(denoiser, &columns, job, &regions, error);
    if (status != FEWRAY_OK)
        goto done;
    kpn_blocks_write(in, &blocks, out, threads);
    if (stats)
        *stats = (struct fewray_denoise_stats){.tiles = blocks.columns * blocks.rows,
                                               .tiles_denoised = blocks.filtered,
                                               .regions = regions,
                                               .seconds = now() - start,
                                               .buffer_bytes = columns.bytes};
done:
    kpn_blocks_clear(&blocks);
    pages_destroy(memory, columns.bytes);
    emitters_clear(&emitters);
    return status;
}

int fewray_denoiser_run(struct fewray_denoiser *denoiser, const struct fewray_denoise_input *in,
                        float *out_rgb, struct fewray_denoise_stats *stats,
                        struct fewray_error *error) {
    const struct kpn_output out = {
        {out_rgb, out_rgb + 1, out_rgb + 2}, 3, (ptrdiff_t)in->width * 3};
    return denoiser_run_to(denoiser, in, &out, stats, error);
}
