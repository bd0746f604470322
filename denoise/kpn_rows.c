/* SPDX-License-Identifier: Apache-2.0 */
/* Features, downsampling and kernels of the network, row by row. Predictions are used as soon as
 * they are made. */

#include "denoise/kpn_rows.h"

#include <omp.h>
#include <string.h>

#include "denoise/kpn_layers.h"

/* Predictions are made and used at once for this many pixels of a row, so that they stay in the
 * cache. */
enum {
    SEGMENT = 64,
    HEAD_CHANNELS = (4 * KPN_TAPS + NN_LANES - 1) / NN_LANES * NN_LANES,
    /* room for a pixel's weights */
    WEIGHTS = (KPN_TAPS + NN_LANES - 1) / NN_LANES * NN_LANES
};

/* Floats for the rows of OP_FEATURES. */
static size_t feature_floats(int width) {
    return KPN_FEATURE_SCRATCH(width) + (size_t)(3 + 2 * KPN_FEATURES) * (size_t)width;
}

/* Floats of a filtered row of two segments, for each slot. */
#define SLOT_FLOATS ((size_t)2 * SEGMENT * 4)

size_t kpn_scratch_bytes(int width, int slots) {
    size_t rows = feature_floats(width) * sizeof(float);
    size_t head = nn_tensor_bytes(1, SEGMENT, HEAD_CHANNELS) +
                  2 * (size_t)slots * SLOT_FLOATS * sizeof(float);
    return ((rows > head ? rows : head) + 63) & ~(size_t)63;
}

static void *thread_scratch(const struct kpn_work *work) {
    return work->scratch +
           (size_t)omp_get_thread_num() * kpn_scratch_bytes(work->job->region.width, work->slots);
}

/* Two rows of the picture become one row of FEATURES: channel 4 c + 2 dy + dx is feature c of pixel
 * (dy, dx). */
void kpn_features_row(struct kpn_work *work, int y) {
    const struct kpn_job *job = work->job;
    int width = job->region.width;
    size_t w = (size_t)width;
    float *scratch = thread_scratch(work), *light = scratch + KPN_FEATURE_SCRATCH(w),
          *rows = light + 3 * w;
    for (int dy = 0; dy < 2; dy++) {
        kpn_feature_row(job->in, job->scale, job->region.y0 + 2 * y + dy, job->region.x0, width,
                        scratch, light, rows + (size_t)dy * KPN_FEATURES * w);
        float *to = kpn_pixel(&work->images[LIGHT0], 2 * y + dy, 0);
        const size_t step = 4 * (size_t)work->slots;
        for (size_t x = 0; x < w; x++) {
            float r = light[x], g = light[w + x], b = light[2 * w + x];
            to[step * x] = r;
            to[step * x + 1] = g;
            to[step * x + 2] = b;
            to[step * x + 3] = 0.0f;
        }
        if (job->in->layer_count > 0)
            kpn_layers_light_row(job->in, job->region.y0 + 2 * y + dy, job->region.x0, width,
                                 scratch, work->slots, to);
    }
    float *to = nn_at(&work->tensors[FEATURES], y, 0);
    for (size_t x = 0; x < w; x += 2, to += 4 * KPN_FEATURES)
        for (size_t c = 0; c < KPN_FEATURES; c++) {
            const float *upper = rows + c * w + x, *lower = upper + KPN_FEATURES * w;
            to[4 * c] = upper[0];
            to[4 * c + 1] = upper[1];
            to[4 * c + 2] = lower[0];
            to[4 * c + 3] = lower[1];
        }
}

/* Linear 1x1 convolution of pixels (y, x0 ...) into memory, (count, conv->out): views of one row
 * make it a tensor's. */
static float *predict(const struct kpn_work *work, const struct nn_conv *conv,
                      const struct nn_tensor *input, int y, int x0, int count, float *memory) {
    size_t before =
        (size_t)(count + 3); /* pixels of the view that lie before its first inner one */
    struct nn_tensor in = {1, count, input->channels,
                           nn_at(input, y, x0) - before * (size_t)input->channels};
    struct nn_tensor out = {1, count, conv->out, memory};
    work->kernels->conv(conv, &in, &out, NN_LINEAR, 0, 1);
    return nn_at(&out, 0, 0);
}

static const struct kpn_image *keys_of(const struct kpn_work *work, enum buffer light) {
    return &work->images[kpn_keys_of(light)];
}

void kpn_key_row(struct kpn_work *work, const struct kpn_layer *layer, const struct nn_conv *conv,
                 int y) {
    const struct kpn_image *keys = &work->images[layer->output];
    int half_width = keys->width / 2;
    for (int x0 = 0; x0 < half_width; x0 += SEGMENT) {
        int count = half_width - x0 < SEGMENT ? half_width - x0 : SEGMENT;
        const float *predicted =
            predict(work, conv, &work->tensors[layer->input], y, x0, count, thread_scratch(work));
        const float *raw = nn_at(&work->tensors[RAW_KEY], y, x0);
        for (int i = 0; i < count; i++, predicted += conv->out, raw += conv->out)
            for (int dy = 0; dy < 2; dy++) {
                float *to = kpn_pixel(keys, 2 * y + dy, 2 * (x0 + i));
                for (int k = 0; k < 2 * NN_KEY; k++)
                    to[k] = predicted[dy * 2 * NN_KEY + k] + raw[dy * 2 * NN_KEY + k];
            }
    }
}

/* Row y of the coarser level. Level 0 is predicted from half resolution, where a pixel has the
 * weights of all four. */
void kpn_down_row(struct kpn_work *work, const struct kpn_layer *layer, const struct nn_conv *conv,
                  int y) {
    const struct kpn_image *out = &work->images[layer->output];
    float *memory = thread_scratch(work);
    int step = layer->out == 4 ? SEGMENT : SEGMENT / 2;
    for (int x0 = 0; x0 < out->width; x0 += step) {
        int count = out->width - x0 < step ? out->width - x0 : step;
        float weights[SEGMENT][4];
        if (layer->out == 4) {
            const float *logits =
                predict(work, conv, &work->tensors[layer->input], y, x0, count, memory);
            for (int i = 0; i < count; i++)
                memcpy(weights[i], logits + i * conv->out, sizeof weights[i]);
        } else {
            for (int dy = 0; dy < 2; dy++) {
                const float *logits = predict(work, conv, &work->tensors[layer->input], 2 * y + dy,
                                              2 * x0, 2 * count, memory);
                for (int i = 0; i < 2 * count; i++)
                    weights[i / 2][2 * dy + i % 2] = logits[i * conv->out];
            }
        }
        for (int i = 0; i < count; i++)
            work->kernels->softmax(weights[i], 4);
        kpn_downsample_row(weights[0], &work->images[layer->light], y, x0, count,
                           kpn_pixel(out, y, x0));
        kpn_downsample_row(weights[0], keys_of(work, layer->light), y, x0, count,
                           kpn_pixel(keys_of(work, layer->output), y, x0));
    }
}

/* Adds to the logits of count pixels of row y from x0 on, step pixels apart, what the keys say. */
static void add_keys(const struct kpn_work *work, const struct kpn_layer *layer, int y, int x0,
                     int step, int count, float *logits, int pitch) {
    int level = (int)layer->light - LIGHT0;
    const struct kpn_image *keys = keys_of(work, layer->light);
    struct nn_affinity affinity = {
        .count = count,
        .size = 5,
        .logits = logits,
        .pitch = (size_t)pitch,
        .own = kpn_pixel(keys, y, x0),
        .own_step = (size_t)(step * NN_KEY),
        .taps = kpn_pixel(keys, y - 2, x0 - 2),
        .taps_step = (size_t)(step * NN_KEY),
        .taps_row = kpn_row_floats(keys),
        .scale = work->scale[level][0],
    };
    work->kernels->add_affinity(&affinity);
    /* Pixels of one column of a 2x2 block: their parents are neighbours. */
    for (int first = 0; layer->coarse && first < 2 / step; first++) {
        const struct kpn_image *coarse = keys_of(work, layer->light + 1);
        int x = x0 + first;
        affinity.count = step == 2 ? count : (count + 1 - first) / 2;
        affinity.size = 3;
        affinity.logits = logits + first * pitch + KPN_TAPS_FINE;
        affinity.pitch = (size_t)(pitch * 2 / step);
        affinity.own = kpn_pixel(keys, y, x);
        affinity.own_step = 2 * NN_KEY;
        affinity.taps = kpn_pixel(coarse, y / 2 - 1, x / 2 - 1);
        affinity.taps_step = NN_KEY;
        affinity.taps_row = kpn_row_floats(coarse);
        affinity.scale = work->scale[level][1];
        work->kernels->add_affinity(&affinity);
    }
}

/* Slots of the result lie slot_floats apart. */
static void apply(const struct kpn_work *work, const float *weights, const struct kpn_image *light,
                  const struct kpn_image *coarse, int y, int x, float *out, size_t slot_floats) {
    if (work->slots == 1)
        kpn_apply(weights, light, coarse, y, x, out);
    else
        kpn_apply_slots(weights, light, coarse, y, x, out, slot_floats);
}

void kpn_kernel_row(struct kpn_work *work, const struct kpn_layer *layer,
                    const struct nn_conv *conv, int y) {
    const struct kpn_image *light = &work->images[layer->light];
    const struct kpn_image *coarse = layer->coarse ? &work->images[layer->coarse] : NULL;
    int level = (int)layer->light - LIGHT0;
    float bias[2][WEIGHTS] = {{0}}; /* of even and odd pixels */
    for (int dx = 0; dx < 2 && coarse; dx++)
        memcpy(bias[dx] + KPN_TAPS_FINE, work->parity[level][(y & 1) * 2 + dx],
               sizeof work->parity[level][0]);
    for (int x0 = 0; x0 < light->width; x0 += SEGMENT) {
        int count = light->width - x0 < SEGMENT ? light->width - x0 : SEGMENT;
        float *logits =
            predict(work, conv, &work->tensors[layer->input], y, x0, count, thread_scratch(work));
        add_keys(work, layer, y, x0, 1, count, logits, conv->out);
        const int room = (layer->out + NN_LANES - 1) / NN_LANES * NN_LANES;
        float weights[SEGMENT * WEIGHTS];
        work->kernels->softmax_to(logits, count, conv->out, coarse ? bias[0] : NULL, layer->out,
                                  weights);
        for (int i = 0; i < count; i++)
            apply(work, weights + i * room, light, coarse, y, x0 + i,
                  kpn_pixel(&work->images[layer->output], y, x0 + i), 4);
    }
}

/* Writes `count` filtered pixels from (x, y) of the region on, as far as they
 * lie in the core, in the picture and in blocks that are filtered. filtered: (count, 4) for each
 * slot, slot_floats apart. */
static void put_row(const struct kpn_job *job, int y, int x, int count, const float *filtered,
                    size_t slot_floats) {
    y += job->region.y0;
    x += job->region.x0;
    const struct kpn_region *core = &job->core;
    int right = core->x0 + core->width < job->in->width ? core->x0 + core->width : job->in->width;
    int begin = x > core->x0 ? x : core->x0, end = x + count < right ? x + count : right;
    if (begin >= end || y < core->y0 || y >= core->y0 + core->height || y >= job->in->height)
        return;
    for (int next; begin < end; begin = next) {
        next = (begin / KPN_BLOCK + 1) * KPN_BLOCK;
        next = next < end ? next : end;
        if (!job->blocks ||
            kpn_block_at(job->blocks, y / KPN_BLOCK, begin / KPN_BLOCK) == KPN_BLOCK_FILTER) {
            const float *from = filtered + 4 * (begin - x);
            kpn_output_row(job->in, y, begin, next - begin, from, job->out);
            kpn_layers_put_row(job->in, y, begin, next - begin, from, slot_floats);
        }
    }
}

void kpn_picture_rows(struct kpn_work *work, const struct kpn_layer *layer,
                      const struct nn_conv *conv, int y) {
    const struct kpn_image *light = &work->images[layer->light],
                           *coarse = &work->images[layer->coarse];
    float *memory = thread_scratch(work);
    float *rows[2] = {memory + nn_tensor_bytes(1, SEGMENT, HEAD_CHANNELS) / sizeof(float), NULL};
    rows[1] = rows[0] + (size_t)work->slots * SLOT_FLOATS;
    int half_width = light->width / 2;
    for (int x0 = 0; x0 < half_width; x0 += SEGMENT) {
        int count = half_width - x0 < SEGMENT ? half_width - x0 : SEGMENT;
        float *logits = predict(work, conv, &work->tensors[layer->input], y, x0, count, memory);
        for (int place = 0; place < 4; place++) {
            int dy = place / 2, dx = place % 2;
            float weights[SEGMENT * WEIGHTS], *own = logits + place * KPN_TAPS;
            add_keys(work, layer, 2 * y + dy, 2 * x0 + dx, 2, count, own, conv->out);
            work->kernels->softmax_to(own, count, conv->out, NULL, KPN_TAPS, weights);
            for (int i = 0; i < count; i++)
                apply(work, weights + i * WEIGHTS, light, coarse, 2 * y + dy, 2 * (x0 + i) + dx,
                      rows[dy] + (2 * i + dx) * 4, SLOT_FLOATS);
        }
        for (int dy = 0; dy < 2; dy++)
            put_row(work->job, 2 * y + dy, 2 * x0, 2 * count, rows[dy], SLOT_FLOATS);
    }
}
