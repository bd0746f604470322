/* SPDX-License-Identifier: Apache-2.0 */
/* The public denoiser: checks its input, loads the weights, and takes a picture through the
 * network, whole or in tiles. */

#include "denoise/denoise.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "denoise/kpn.h"
#include "denoise/weights_kpn.h"

#define DEFAULT_MEMORY ((size_t)1 << 30)
#define MAX_SIDE       (1 << 20)
#define MAX_PIXELS     ((size_t)1 << 31)
#define MIN_CORE       64 /* narrower tiles would be nearly all overlap */

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
    return (struct fewray_channels){{rgb, rgb + 1, rgb + 2}, 3, (ptrdiff_t)width * 3};
}

struct fewray_channels fewray_planar(float *const planes[3], int width) {
    return (struct fewray_channels){{planes[0], planes[1], planes[2]}, 1, width};
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
    else if (options->weights_path)
        status = nn_weights_read(options->weights_path, &weights, error);
    else
        status = nn_weights_parse(kpn_weights, kpn_weights_size(), "the built-in denoiser weights",
                                  &weights, error);
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

/* --- tiles */

struct tiling {
    int columns, rows;      /* of tiles */
    int core_w, core_h;     /* multiples of KPN_ALIGN */
    int region_w, region_h; /* the largest region */
    size_t bytes;
};

static int round_up(int v) {
    return (v + KPN_ALIGN - 1) / KPN_ALIGN * KPN_ALIGN;
}

static int region_side(int core, int tiles, int side) {
    int overlaps = tiles == 1 ? 0 : (tiles == 2 ? 1 : 2);
    int region = core + overlaps * KPN_OVERLAP;
    return region < round_up(side) ? region : round_up(side);
}

/* The fewest tiles that fit into max_memory: the longer side of the core is cut until they do. */
static int tile(int height, int width, int threads, size_t max_memory, struct tiling *t,
                struct fewray_error *error) {
    t->columns = t->rows = 1;
    for (;;) {
        t->core_w = round_up((width + t->columns - 1) / t->columns);
        t->core_h = round_up((height + t->rows - 1) / t->rows);
        t->region_w = region_side(t->core_w, t->columns, width);
        t->region_h = region_side(t->core_h, t->rows, height);
        t->bytes = kpn_memory(t->region_h, t->region_w, threads);
        if (t->bytes <= max_memory)
            break;
        if (t->core_w <= MIN_CORE && t->core_h <= MIN_CORE)
            return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                               "the denoiser can't work within %zu MiB: give it at least %zu MiB",
                               max_memory >> 20, (t->bytes >> 20) + 1);
        if (t->core_w >= t->core_h)
            t->columns++;
        else
            t->rows++;
    }
    /* Rounding up the core may have made the last tiles empty. */
    t->columns = (width + t->core_w - 1) / t->core_w;
    t->rows = (height + t->core_h - 1) / t->core_h;
    return FEWRAY_OK;
}

static void span(int core_begin, int core_size, int side, int *begin, int *size) {
    int end = core_begin + core_size + KPN_OVERLAP;
    *begin = core_begin > KPN_OVERLAP ? core_begin - KPN_OVERLAP : 0;
    *size = (end < round_up(side) ? end : round_up(side)) - *begin;
}

/* Turns a tile's progress into the picture's. */
struct progress {
    const struct fewray_denoise_options *options;
    int tile, tiles;
};

static void report(void *user, double fraction) {
    const struct progress *p = user;
    p->options->progress(p->options->progress_user, (p->tile + fraction) / p->tiles);
}

static int run_tiles(const struct fewray_denoiser *denoiser, const struct tiling *t,
                     struct kpn_job job, struct fewray_denoise_stats *stats,
                     struct fewray_error *error) {
    struct progress progress = {&denoiser->options, 0, t->columns * t->rows};
    job.progress = denoiser->options.progress ? report : NULL;
    job.progress_user = &progress;
    for (int row = 0; row < t->rows; row++)
        for (int column = 0; column < t->columns; column++, progress.tile++) {
            struct kpn_region *core = &job.core, *region = &job.region;
            *core = (struct kpn_region){column * t->core_w, row * t->core_h, t->core_w, t->core_h};
            span(core->x0, core->width, job.in->width, &region->x0, &region->width);
            span(core->y0, core->height, job.in->height, &region->y0, &region->height);
            bool filtered;
            int status = kpn_run(denoiser->kpn, &job, &filtered, error);
            if (status != FEWRAY_OK)
                return status;
            stats->tiles++;
            stats->tiles_denoised += filtered;
        }
    return FEWRAY_OK;
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
        bool all = channel[0] && channel[1] && channel[2],
             none = !channel[0] && !channel[1] && !channel[2];
        if (!all && (i == 0 || !none))
            return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                               "the denoiser needs all three channels of %s",
                               i == 0 ? "color" : "a layer");
    }
    return FEWRAY_OK;
}

int fewray_denoiser_run(struct fewray_denoiser *denoiser, const struct fewray_denoise_input *in,
                        float *out_rgb, struct fewray_denoise_stats *stats,
                        struct fewray_error *error) {
    double start = now();
    struct fewray_denoise_stats local = {0};
    struct tiling tiling;
    struct kpn_scale scale;
    void *memory = NULL;
    size_t max_memory =
        denoiser->options.max_memory ? denoiser->options.max_memory : DEFAULT_MEMORY;
    int status = check(in, error);
    if (status == FEWRAY_OK)
        status = tile(in->height, in->width, denoiser->threads, max_memory, &tiling, error);
    if (status == FEWRAY_OK)
        status = kpn_measure(in, denoiser->threads, &scale, error);
    if (status != FEWRAY_OK)
        goto done;
    memory = aligned_alloc(64, tiling.bytes);
    if (!memory) {
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                             "no memory for the denoiser's %zu MiB of buffers", tiling.bytes >> 20);
        goto done;
    }
    struct kpn_job job = {.in = in,
                          .scale = &scale,
                          .memory = memory,
                          .threads = denoiser->threads,
                          .out_rgb = out_rgb,
                          .cancel = denoiser->options.cancel};
    status = run_tiles(denoiser, &tiling, job, &local, error);
    local.buffer_bytes = tiling.bytes;
    local.seconds = now() - start;
    if (stats && status == FEWRAY_OK)
        *stats = local;
done:
    free(memory);
    return status;
}

/* --- frames */

static struct fewray_channels frame_layer(const struct fewray_frame *frame,
                                          enum fewray_layer layer) {
    float *planes[3] = {NULL, NULL, NULL};
    if (!fewray_frame_layer(frame, layer, planes))
        return (struct fewray_channels){0};
    if (layer == FEWRAY_DEPTH)
        planes[1] = planes[2] = NULL;
    return fewray_planar(planes, frame->width);
}

int fewray_denoise_frame(struct fewray_denoiser *denoiser, struct fewray_frame *frame,
                         struct fewray_denoise_stats *stats, struct fewray_error *error) {
    struct fewray_denoise_input in = {
        .width = frame->width,
        .height = frame->height,
        .color = frame_layer(frame, FEWRAY_COLOR),
        .variance = frame_layer(frame, FEWRAY_VARIANCE),
        .albedo = frame_layer(frame, FEWRAY_ALBEDO),
        .shaded_albedo = frame_layer(frame, FEWRAY_SHADED_ALBEDO),
        .normal = frame_layer(frame, FEWRAY_NORMAL),
        .emission = frame_layer(frame, FEWRAY_EMISSION),
        .depth = frame_layer(frame, FEWRAY_DEPTH),
        .irradiance = frame_layer(frame, FEWRAY_IRRADIANCE),
        .confidence = frame_layer(frame, FEWRAY_IRRADIANCE_CONFIDENCE),
    };
    size_t pixels = (size_t)frame->width * (size_t)frame->height;
    if (!in.color.channel[0])
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, NULL, 0,
                           "the picture has no R, G, B to denoise");
    float *out = malloc(pixels * 3 * sizeof *out);
    float *color[3], *noisy[3];
    if (!out || !fewray_frame_add_layer(frame, FEWRAY_NOISY, noisy)) {
        free(out);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                           "no memory for the denoised picture");
    }
    int status = fewray_denoiser_run(denoiser, &in, out, stats, error);
    if (status == FEWRAY_OK && fewray_frame_layer(frame, FEWRAY_COLOR, color))
        for (int c = 0; c < 3; c++)
            for (size_t i = 0; i < pixels; i++) {
                noisy[c][i] = color[c][i];
                color[c][i] = out[3 * i + (size_t)c];
            }
    free(out);
    return status;
}
