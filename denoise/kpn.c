/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the network's layers band by band. */

#include "denoise/kpn.h"

#include <string.h>

#include "denoise/kpn_bands.h"
#include "denoise/kpn_layers.h"
#include "denoise/kpn_network.h"
#include "features/cancel.h"

/* --- memory */

static size_t align64(size_t bytes) {
    return (bytes + 63) & ~(size_t)63;
}

/* Light has four channels a slot. */
static int image_channels(int b, int slots) {
    return b >= KEY0 ? NN_KEY : 4 * slots;
}

/* Where the rows of each buffer lie. */
struct plan {
    int band;  /* rows of the picture that go through all layers before the next ones */
    int slots; /* kpn_layers_slots() */
    int rows[BUFFER_COUNT];
    size_t pitch[BUFFER_COUNT]; /* floats of a row */
    size_t offsets[BUFFER_COUNT], bytes;
};

static struct plan make_plan(const struct kpn *kpn, int slots, int height, int width, int band) {
    struct plan plan = {.band = band, .slots = slots};
    kpn_bands_capacity(kpn->layers, KPN_LAYER_COUNT, kpn->levels, height, band, plan.rows);
    for (int b = 1; b < BUFFER_COUNT; b++) {
        size_t w = (size_t)(width >> kpn->levels[b]);
        plan.pitch[b] = b >= FIRST_IMAGE ? (w + 2 * KPN_BORDER) * (size_t)image_channels(b, slots)
                                         : (w + 2) * (size_t)kpn->channels[b];
        plan.offsets[b] = plan.bytes;
        plan.bytes += align64((size_t)plan.rows[b] * plan.pitch[b] * sizeof(float));
    }
    return plan;
}

static size_t bytes_of(const struct plan *plan, int width, int threads) {
    return plan->bytes + (size_t)threads * kpn_scratch_bytes(width, plan->slots);
}

/* The largest bands that fit: threads wait for each other less often, and coarse levels have rows
 * for all of them. */
static struct plan fit_plan(const struct kpn *kpn, int slots, int height, int width, int threads,
                            size_t max_bytes) {
    int band = KPN_BAND_ROWS < height ? KPN_BAND_ROWS : height;
    struct plan plan = make_plan(kpn, slots, height, width, band);
    while (band < height) {
        band = 2 * band < height ? 2 * band : height;
        struct plan larger = make_plan(kpn, slots, height, width, band);
        if (bytes_of(&larger, width, threads) > max_bytes)
            break;
        plan = larger;
    }
    return plan;
}

size_t kpn_memory(const struct kpn *kpn, int slots, int height, int width, int threads,
                  size_t max_bytes) {
    struct plan plan = fit_plan(kpn, slots, height, width, threads, max_bytes);
    return bytes_of(&plan, width, threads);
}

/* --- running */

static float *storage(const struct kpn_work *work, const struct plan *plan, int b) {
    return (float *)(void *)((char *)work->job->memory + plan->offsets[b]);
}

/* Row `first` of a buffer is the first one of its storage; rows before it aren't touched. */
static void place(const struct kpn *kpn, struct kpn_work *work, const struct plan *plan, int b,
                  int first) {
    const struct kpn_region *region = &work->job->region;
    int h = region->height >> kpn->levels[b], w = region->width >> kpn->levels[b];
    ptrdiff_t pitch = (ptrdiff_t)plan->pitch[b];
    float *data = storage(work, plan, b);
    if (b >= FIRST_IMAGE)
        work->images[b] = (struct kpn_image){h, w, image_channels(b, plan->slots),
                                             data - (first + KPN_BORDER) * pitch};
    else
        work->tensors[b] = (struct nn_tensor){h, w, kpn->channels[b], data - (first + 1) * pitch};
}

/* Places all buffers and makes the tensors' borders zero; the layers never write them. */
static void lay_out(const struct kpn *kpn, struct kpn_work *work, const struct plan *plan,
                    const struct kpn_bands *bands) {
    work->scratch = (char *)work->job->memory + plan->bytes;
    for (int b = 1; b < BUFFER_COUNT; b++) {
        place(kpn, work, plan, b, bands->first[b]);
        if (b >= FIRST_IMAGE)
            continue;
        float *data = storage(work, plan, b);
        size_t pitch = plan->pitch[b], pixel = (size_t)kpn->channels[b];
        memset(data, 0, pitch * sizeof(float));
        for (size_t y = 1; y < (size_t)plan->rows[b]; y++) {
            memset(data + y * pitch, 0, pixel * sizeof(float));
            memset(data + (y + 1) * pitch - pixel, 0, pixel * sizeof(float));
        }
    }
}

/* Drops the rows that nobody needs any more; the others move to the front. */
static void slide(const struct kpn *kpn, struct kpn_work *work, const struct plan *plan,
                  struct kpn_bands *bands) {
    int before[BUFFER_COUNT];
    memcpy(before, bands->first, sizeof before);
    kpn_bands_drop(bands);
#pragma omp parallel for schedule(dynamic) num_threads(work->job->threads)
    for (int b = 1; b < BUFFER_COUNT; b++) {
        int drop = bands->first[b] - before[b], keep = kpn_bands_end(bands, b) - bands->first[b];
        if (drop == 0)
            continue;
        float *data = storage(work, plan, b);
        memmove(data, data + (size_t)drop * plan->pitch[b],
                (size_t)keep * plan->pitch[b] * sizeof(float));
        place(kpn, work, plan, b, bands->first[b]);
    }
}

/* Rows y0 <= y < y1 of the layer's own resolution. */
static void run_rows(struct kpn_work *work, const struct kpn_layer *layer,
                     const struct nn_conv *conv, int y0, int y1) {
    const struct nn_tensor *input = &work->tensors[layer->input],
                           *output = &work->tensors[layer->output];
    if (layer->op == OP_CONV)
        work->kernels->conv(conv, input, output, NN_LEAKY_RELU, y0, y1);
    else if (layer->op == OP_RAW_KEY)
        work->kernels->conv(conv, input, output, NN_LINEAR, y0, y1);
    else if (layer->op == OP_POOL)
        work->kernels->average_pool(input, output, y0, y1);
    else if (layer->op == OP_UPSAMPLE_ADD)
        work->kernels->upsample_add(input, output, y0, y1);
    else
        for (int y = y0; y < y1; y++)
            if (layer->op == OP_FEATURES)
                kpn_features_row(work, y);
            else if (layer->op == OP_KEY)
                kpn_key_row(work, layer, conv, y);
            else if (layer->op == OP_DOWN)
                kpn_down_row(work, layer, conv, y);
            else if (layer->output)
                kpn_kernel_row(work, layer, conv, y);
            else
                kpn_picture_rows(work, layer, conv, y);
}

/* Rows begin <= y < end, shared by the threads, and the border beside them. */
static void run_layer(struct kpn_work *work, const struct kpn_layer *layer,
                      const struct nn_conv *conv, int begin, int end) {
    int share = (end - begin) / (4 * work->job->threads), chunk = share < 1 ? 1 : share;
    if (chunk > 4)
        chunk = 4;
#pragma omp parallel for schedule(dynamic) num_threads(work->job->threads)
    for (int y = begin; y < end; y += chunk)
        run_rows(work, layer, conv, y, y + chunk < end ? y + chunk : end);
    if (layer->op == OP_FEATURES)
        kpn_fill_border(&work->images[layer->light], 2 * begin, 2 * end);
    if (layer->op == OP_DOWN)
        kpn_fill_border(&work->images[kpn_keys_of(layer->output)], begin, end);
    if (layer->op == OP_KEY) {
        kpn_fill_border(&work->images[layer->output], 2 * begin, 2 * end);
    } else if (layer->output >= FIRST_IMAGE) {
        kpn_fill_border(&work->images[layer->output], begin, end);
    } else if (layer->output) {
        const struct nn_tensor *t = &work->tensors[layer->output];
        if (end == t->height)
            memset(nn_at(t, end, -1), 0,
                   (size_t)(t->width + 2) * (size_t)t->channels * sizeof(float));
    }
}

static void show(const struct kpn_work *work, const struct kpn_layer *layer) {
    const struct kpn_job *job = work->job;
    enum buffer b = layer->output;
    if (b == NONE || !job->trace)
        return;
    if (b >= FIRST_IMAGE) {
        const struct kpn_image *image = &work->images[b];
        job->trace(job->trace_user, layer->name, kpn_pixel(image, 0, 0), image->height,
                   image->width, b >= KEY0 ? image->channels : 3, kpn_row_floats(image),
                   (size_t)image->channels);
    } else {
        const struct nn_tensor *t = &work->tensors[b];
        size_t stride = (size_t)t->channels;
        job->trace(job->trace_user, layer->name, nn_at(t, 0, 0), t->height, t->width, t->channels,
                   (size_t)(t->width + 2) * stride, stride);
    }
}

int kpn_run(const struct kpn *kpn, const struct kpn_job *job, struct fewray_error *error) {
    struct kpn_work work = {.kernels = kpn->kernels,
                            .job = job,
                            .slots = kpn_layers_slots(job->in),
                            .parity = kpn->parity,
                            .scale = kpn->scale};
    const int height = job->region.height;
    const struct plan plan =
        fit_plan(kpn, work.slots, height, job->region.width, job->threads, job->memory_bytes);
    const int band = plan.band;
    struct kpn_bands bands;
    kpn_bands_start(&bands, kpn->layers, KPN_LAYER_COUNT, kpn->levels, height);
    lay_out(kpn, &work, &plan, &bands);
    for (int end = 0; end < height;) {
        end = end + band < height ? end + band : height;
        for (int i = 0; i < KPN_LAYER_COUNT; i++) {
            if (cancel_wanted(job->cancel))
                return fewray_fail(error, FEWRAY_ERROR_CANCELLED, NULL, 0, "cancelled");
            int limit = kpn_bands_limit(&bands, i, end);
            if (limit == bands.made[i])
                continue;
            run_layer(&work, &kpn->layers[i], &kpn->convs[i], bands.made[i], limit);
            bands.made[i] = limit;
            show(&work, &kpn->layers[i]);
            if (job->progress)
                job->progress(job->progress_user,
                              (end - band + band * (i + 1.0) / KPN_LAYER_COUNT) / height);
        }
        slide(kpn, &work, &plan, &bands);
    }
    return FEWRAY_OK;
}
