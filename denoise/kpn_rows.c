/* SPDX-License-Identifier: Apache-2.0 */
/* Features, downsampling and kernels of the network, row by row. Predictions are used as soon as
 * they are made. */

#include "denoise/kpn_rows.h"

#include <omp.h>
#include <string.h>

/* Predictions are made and used at once for this many pixels of a row, so that they stay in the
 * cache. */
enum { SEGMENT = 64, HEAD_CHANNELS = (4 * KPN_TAPS + NN_LANES - 1) / NN_LANES * NN_LANES };

/* Floats for the rows of OP_FEATURES. */
static size_t feature_floats(int width) {
    return KPN_FEATURE_SCRATCH(width) + (size_t)(3 + 2 * KPN_FEATURES) * (size_t)width;
}

size_t kpn_scratch_bytes(int width) {
    size_t rows = feature_floats(width) * sizeof(float);
    size_t head = nn_tensor_bytes(1, SEGMENT, HEAD_CHANNELS) + 2 * 2 * SEGMENT * 4 * sizeof(float);
    return ((rows > head ? rows : head) + 63) & ~(size_t)63;
}

static void *thread_scratch(const struct kpn_work *work) {
    return work->scratch +
           (size_t)omp_get_thread_num() * kpn_scratch_bytes(work->job->region.width);
}

/* Two rows of the picture become one row of FEATURES: channel 4 c + 2 dy + dx is feature c of pixel
 * (dy, dx). */
bool kpn_features_row(struct kpn_work *work, int y) {
    const struct kpn_job *job = work->job;
    int width = job->region.width;
    size_t w = (size_t)width;
    float *scratch = thread_scratch(work), *light = scratch + KPN_FEATURE_SCRATCH(w),
          *rows = light + 3 * w;
    bool lit = false;
    for (int dy = 0; dy < 2; dy++) {
        kpn_feature_row(job->in, job->scale, job->region.y0 + 2 * y + dy, job->region.x0, width,
                        scratch, light, rows + (size_t)dy * KPN_FEATURES * w);
        float *to = kpn_pixel(&work->images[LIGHT0], 2 * y + dy, 0);
        for (size_t x = 0; x < w; x++) {
            float r = light[x], g = light[w + x], b = light[2 * w + x];
            to[4 * x] = r;
            to[4 * x + 1] = g;
            to[4 * x + 2] = b;
            to[4 * x + 3] = 0.0f;
            lit |= r + g + b > 0.0f;
        }
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
    return lit;
}

/* Linear 1x1 convolution of pixels (y, x0 ...) into memory, (count, conv->out): views of one row
 * make it a tensor's. */
static const float *predict(const struct kpn_work *work, const struct nn_conv *conv,
                            const struct nn_tensor *input, int y, int x0, int count,
                            float *memory) {
    size_t before =
        (size_t)(count + 3); /* pixels of the view that lie before its first inner one */
    struct nn_tensor in = {1, count, input->channels,
                           nn_at(input, y, x0) - before * (size_t)input->channels};
    struct nn_tensor out = {1, count, conv->out, memory};
    work->kernels->conv(conv, &in, &out, NN_LINEAR, 0, 1);
    return nn_at(&out, 0, 0);
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
    }
}

void kpn_kernel_row(struct kpn_work *work, const struct kpn_layer *layer,
                    const struct nn_conv *conv, int y) {
    const struct kpn_image *light = &work->images[layer->light];
    const struct kpn_image *coarse = layer->coarse ? &work->images[layer->coarse] : NULL;
    int level = (int)layer->light - LIGHT0;
    for (int x0 = 0; x0 < light->width; x0 += SEGMENT) {
        int count = light->width - x0 < SEGMENT ? light->width - x0 : SEGMENT;
        const float *logits =
            predict(work, conv, &work->tensors[layer->input], y, x0, count, thread_scratch(work));
        for (int i = 0; i < count; i++) {
            float weights[KPN_TAPS];
            memcpy(weights, logits + i * conv->out, (size_t)layer->out * sizeof *weights);
            if (coarse) {
                const float *parity = work->parity[level][(y & 1) * 2 + ((x0 + i) & 1)];
                for (int k = 0; k < KPN_TAPS_COARSE; k++)
                    weights[KPN_TAPS_FINE + k] += parity[k];
            }
            work->kernels->softmax(weights, layer->out);
            kpn_apply(weights, light, coarse, y, x0 + i,
                      kpn_pixel(&work->images[layer->output], y, x0 + i));
        }
    }
}

void kpn_put_row(const struct kpn_job *job, int y, int x, int count, const float *filtered) {
    y += job->region.y0;
    x += job->region.x0;
    const struct kpn_region *core = &job->core;
    int right = core->x0 + core->width < job->in->width ? core->x0 + core->width : job->in->width;
    int begin = x > core->x0 ? x : core->x0, end = x + count < right ? x + count : right;
    if (begin >= end || y < core->y0 || y >= core->y0 + core->height || y >= job->in->height)
        return;
    kpn_remodulate_row(job->in, y, begin, end - begin, filtered ? filtered + 4 * (begin - x) : NULL,
                       job->out_rgb + ((size_t)y * (size_t)job->in->width + (size_t)begin) * 3);
}

void kpn_picture_rows(struct kpn_work *work, const struct kpn_layer *layer,
                      const struct nn_conv *conv, int y) {
    const struct kpn_image *light = &work->images[layer->light],
                           *coarse = &work->images[layer->coarse];
    float *memory = thread_scratch(work);
    float *rows[2] = {memory + nn_tensor_bytes(1, SEGMENT, HEAD_CHANNELS) / sizeof(float), NULL};
    rows[1] = rows[0] + 2 * SEGMENT * 4;
    int half_width = light->width / 2;
    for (int x0 = 0; x0 < half_width; x0 += SEGMENT) {
        int count = half_width - x0 < SEGMENT ? half_width - x0 : SEGMENT;
        const float *logits =
            predict(work, conv, &work->tensors[layer->input], y, x0, count, memory);
        for (int i = 0; i < count; i++)
            for (int place = 0; place < 4; place++) {
                int dy = place / 2, dx = place % 2;
                float weights[KPN_TAPS];
                memcpy(weights, logits + i * conv->out + place * KPN_TAPS, sizeof weights);
                work->kernels->softmax(weights, KPN_TAPS);
                kpn_apply(weights, light, coarse, 2 * y + dy, 2 * (x0 + i) + dx,
                          rows[dy] + (2 * i + dx) * 4);
            }
        for (int dy = 0; dy < 2; dy++)
            kpn_put_row(work->job, 2 * y + dy, 2 * x0, 2 * count, rows[dy]);
    }
}
