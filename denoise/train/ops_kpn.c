/* SPDX-License-Identifier: Apache-2.0 */
/* What training takes from C, as a shared library for ctypes: the shipped feature code, and the
 * joint softmax and kernel application of one pyramid level with its gradients (several times
 * faster on CPUs than 34 shifted tensors). */

#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "denoise/features_kpn.h"
#include "denoise/kernel_apply.h"
#include "denoise/nn/nn.h"

enum {
    RAW_COLOR = 0,
    RAW_EMISSION = 3,
    RAW_VARIANCE = 6,
    RAW_ALBEDO = 9,
    RAW_NORMAL = 12,
    RAW_DEPTH = 15,
    RAW_IRRADIANCE = 16,
    RAW_CONFIDENCE = 19,
    RAW_SHADED_ALBEDO = 20
};
enum {
    HAS_EMISSION = 1,
    HAS_VARIANCE = 2,
    HAS_ALBEDO = 4,
    HAS_NORMAL = 8,
    HAS_DEPTH = 16,
    HAS_GUIDE = 32
};

static void layer(struct fewray_channels *to, float *raw, size_t plane, int first, int count,
                  int width) {
    for (int c = 0; c < count; c++)
        to->channel[c] = raw + (size_t)(first + c) * plane;
    to->pixel_stride = 1;
    to->row_stride = width;
}

static struct fewray_denoise_input raw_input(float *raw, int height, int width, int layers) {
    struct fewray_denoise_input in = {.width = width, .height = height};
    size_t plane = (size_t)height * (size_t)width;
    layer(&in.color, raw, plane, RAW_COLOR, 3, width);
    if (layers & HAS_EMISSION)
        layer(&in.emission, raw, plane, RAW_EMISSION, 3, width);
    if (layers & HAS_VARIANCE)
        layer(&in.variance, raw, plane, RAW_VARIANCE, 3, width);
    if (layers & HAS_ALBEDO)
        layer(&in.albedo, raw, plane, RAW_ALBEDO, 3, width);
    if (layers & HAS_ALBEDO)
        layer(&in.shaded_albedo, raw, plane, RAW_SHADED_ALBEDO, 3, width);
    if (layers & HAS_GUIDE)
        layer(&in.irradiance, raw, plane, RAW_IRRADIANCE, 3, width);
    if (layers & HAS_GUIDE)
        layer(&in.confidence, raw, plane, RAW_CONFIDENCE, 1, width);
    if (layers & HAS_NORMAL)
        layer(&in.normal, raw, plane, RAW_NORMAL, 3, width);
    if (layers & HAS_DEPTH)
        layer(&in.depth, raw, plane, RAW_DEPTH, 1, width);
    return in;
}

/* raw (23, height, width) -> features (height / 2, width / 2, 64) and irradiance (height, width,
 * 3). 0, or -1 without memory. */
FEWRAY_API int kpn_train_features(float *raw, int height, int width, int layers, float exposure,
                                  float log2_depth, float *features, float *irradiance) {
    struct fewray_denoise_input in = raw_input(raw, height, width, layers);
    struct kpn_scale scale = {exposure, log2_depth, (layers & HAS_VARIANCE) != 0};
    size_t w = (size_t)width;
    float *scratch = malloc((KPN_FEATURE_SCRATCH(w) + (3 + KPN_FEATURES) * w) * sizeof *scratch);
    if (!scratch)
        return -1;
    float *e = scratch + KPN_FEATURE_SCRATCH(w), *f = e + 3 * w;
    for (int y = 0; y < height; y++) {
        kpn_feature_row(&in, &scale, y, 0, width, scratch, e, f);
        for (size_t c = 0; c < KPN_FEATURES; c++)
            for (size_t x = 0; x < w; x++)
                features[((size_t)(y / 2) * (w / 2) + x / 2) * 4 * KPN_FEATURES + 4 * c +
                         (size_t)(y & 1) * 2 + (x & 1)] = f[c * w + x];
        for (size_t x = 0; x < w; x++)
            for (size_t c = 0; c < 3; c++)
                irradiance[((size_t)y * w + x) * 3 + c] = e[c * w + x];
    }
    free(scratch);
    return 0;
}

/* Exposure and depth scale of a whole picture. */
FEWRAY_API int kpn_train_measure(float *raw, int height, int width, int layers, float *exposure,
                                 float *log2_depth) {
    struct fewray_denoise_input in = raw_input(raw, height, width, layers);
    struct kpn_scale scale;
    int status = kpn_measure(&in, 1, &scale, NULL);
    if (status == FEWRAY_OK) {
        *exposure = scale.exposure;
        *log2_depth = scale.log2_depth;
    }
    return status;
}

/* --- kernels of one level */

/* Shapes: logits (batch, height / sub, width / sub, pitch), where a pixel's logits start at (its
 * place among sub x sub siblings) * taps; parity (4, 9) is added to the coarse logits, by the
 * pixel's place in its 2x2 block, or NULL; fine (batch, height, width, 3); coarse (batch, height /
 * 2, width / 2, 3) or NULL; out like fine. key_fine (batch, height, width, 8) and key_coarse
 * (batch, height / 2, width / 2, 8) are the pixels' keys, by which a tap's logit falls with the
 * squared distance as nn_affinity says, by scale (2, 8) of fine and coarse taps. */
struct level {
    int batch, height, width, sub, pitch, taps;
    const float *logits, *parity, *fine, *coarse, *key_fine, *key_coarse, *scale;
};

typedef float pixel4 __attribute__((vector_size(16)));
typedef float pixel8 __attribute__((vector_size(32)));

static pixel8 load8(const float *p) {
    pixel8 v;
    memcpy(&v, p, sizeof v);
    return v;
}

static void taps_distance_backward(pixel8 own, const struct kpn_image *keys,
                                   const struct kpn_image *gradient, pixel8 scale, int size, int y,
                                   int x, const float *grads, pixel8 *grad_own,
                                   pixel8 *grad_scale) {
    for (int dy = 0; dy < size; dy++)
        for (int dx = 0; dx < size; dx++) {
            float g = grads[dy * size + dx];
            pixel8 d = own - load8(kpn_pixel(keys, y + dy - size / 2, x + dx - size / 2));
            float *to = kpn_pixel(gradient, y + dy - size / 2, x + dx - size / 2);
            pixel8 step = d * scale * (2.0f * g), sum = load8(to) + step;
            sum[7] += g;
            memcpy(to, &sum, sizeof sum);
            *grad_own -= step;
            *grad_scale -= d * d * g;
        }
}

static size_t logit_offset(const struct level *l, int n, int y, int x) {
    int row = l->height / l->sub, column = l->width / l->sub;
    size_t place =
        (((size_t)n * (size_t)row + (size_t)(y / l->sub)) * (size_t)column + (size_t)(x / l->sub));
    int sibling = l->sub == 2 ? (y & 1) * 2 + (x & 1) : 0;
    return place * (size_t)l->pitch + (size_t)(sibling * l->taps);
}

/* A copy of (height, width, used) floats, or zeros; light has 3 of its 4 channels used. */
static bool image_new(struct kpn_image *image, int height, int width, int channels,
                      const float *from) {
    size_t used = channels == 4 ? 3 : (size_t)channels;
    *image = (struct kpn_image){height, width, channels,
                                calloc(1, kpn_image_bytes(height, width, channels))};
    if (!image->data || !from)
        return image->data != NULL;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++, from += used)
            memcpy(kpn_pixel(image, y, x), from, used * sizeof(float));
    kpn_fill_border(image, 0, height);
    return true;
}

/* The logits of row y, with what parity and keys add. */
static void row_logits(const struct level *l, const struct nn_kernels *kernels,
                       const struct kpn_image *kf, const struct kpn_image *kc, int n, int y,
                       float *logits) {
    size_t taps = (size_t)l->taps;
    for (int x = 0; x < l->width; x++) {
        float *to = logits + (size_t)x * taps;
        memcpy(to, l->logits + logit_offset(l, n, y, x), taps * sizeof *to);
        for (int i = 0; l->parity && i < KPN_TAPS_COARSE; i++)
            to[KPN_TAPS_FINE + i] += l->parity[((y & 1) * 2 + (x & 1)) * KPN_TAPS_COARSE + i];
    }
    struct nn_affinity affinity = {.count = l->width,
                                   .size = 5,
                                   .logits = logits,
                                   .pitch = taps,
                                   .own = kpn_pixel(kf, y, 0),
                                   .own_step = NN_KEY,
                                   .taps = kpn_pixel(kf, y - 2, -2),
                                   .taps_step = NN_KEY,
                                   .taps_row = kpn_row_floats(kf),
                                   .scale = l->scale};
    kernels->add_affinity(&affinity);
    for (int x = 0; l->coarse && x < 2; x++) {
        affinity = (struct nn_affinity){.count = l->width / 2,
                                        .size = 3,
                                        .logits = logits + (size_t)x * taps + KPN_TAPS_FINE,
                                        .pitch = 2 * taps,
                                        .own = kpn_pixel(kf, y, x),
                                        .own_step = 2 * NN_KEY,
                                        .taps = kpn_pixel(kc, y / 2 - 1, -1),
                                        .taps_step = NN_KEY,
                                        .taps_row = kpn_row_floats(kc),
                                        .scale = l->scale + NN_KEY};
        kernels->add_affinity(&affinity);
    }
}

static size_t pixels(int height, int width) {
    return (size_t)height * (size_t)width;
}

FEWRAY_API int kpn_apply_forward(int batch, int height, int width, int sub, int pitch, int taps,
                                 const float *logits, const float *parity, const float *fine,
                                 const float *coarse, const float *key_fine,
                                 const float *key_coarse, const float *scale, float *all_weights,
                                 float *out, int threads) {
    const struct level l = {batch,  height, width,  sub,      pitch,      taps, logits,
                            parity, fine,   coarse, key_fine, key_coarse, scale};
    const struct nn_kernels *kernels = nn_kernels_get(NN_ISA_AUTO);
    int failed = 0;
#pragma omp parallel for num_threads(threads) reduction(| : failed)
    for (int n = 0; n < batch; n++) {
        struct kpn_image f = {0}, c = {0};
        struct kpn_image kf = {0}, kc = {0};
        size_t first = (size_t)n * pixels(height, width),
               first_coarse = (size_t)n * pixels(height / 2, width / 2);
        bool ok = image_new(&f, height, width, 4, fine + first * 3) &&
                  image_new(&kf, height, width, NN_KEY, key_fine + first * 8);
        if (coarse)
            ok = ok && image_new(&c, height / 2, width / 2, 4, coarse + first_coarse * 3) &&
                 image_new(&kc, height / 2, width / 2, NN_KEY, key_coarse + first_coarse * 8);
        for (int y = 0; ok && y < height; y++) {
            float *row = all_weights + (first + (size_t)y * (size_t)width) * (size_t)taps;
            row_logits(&l, kernels, &kf, &kc, n, y, row);
            kernels->softmax_rows(row, width, taps, taps);
            for (int x = 0; x < width; x++) {
                const float *weights = row + (size_t)x * (size_t)taps;
                float value[4];
                kpn_apply(weights, &f, coarse ? &c : NULL, y, x, value);
                memcpy(out + ((size_t)n * pixels(height, width) + pixels(y, width) + (size_t)x) * 3,
                       value, 3 * sizeof(float));
            }
        }
        failed |= !ok;
        free(f.data);
        free(c.data);
        free(kf.data);
        free(kc.data);
    }
    return failed ? -1 : 0;
}

static pixel4 load(const float *p) {
    pixel4 v;
    memcpy(&v, p, sizeof v);
    return v;
}

/* One rectangle of taps: products[i] = <grad, image tap>, and the image's own gradient. */
static void taps_backward(const struct kpn_image *image, const struct kpn_image *gradient, int size,
                          int y, int x, const float *weights, pixel4 grad, float *products) {
    for (int dy = 0; dy < size; dy++) {
        const float *from = kpn_pixel(image, y + dy - size / 2, x - size / 2);
        float *to = kpn_pixel(gradient, y + dy - size / 2, x - size / 2);
        for (int dx = 0; dx < size; dx++) {
            pixel4 product = grad * load(from + 4 * dx);
            products[dy * size + dx] = product[0] + product[1] + product[2];
            pixel4 sum = load(to + 4 * dx) + weights[dy * size + dx] * grad;
            memcpy(to + 4 * dx, &sum, sizeof sum);
        }
    }
}

/* Adds what the border gathered to the pixels that it repeats, and drops the spare channel. */
static void image_gradient(const struct kpn_image *image, float *to) {
    int used = image->channels == 4 ? 3 : image->channels;
    for (int y = -KPN_BORDER; y < image->height + KPN_BORDER; y++)
        for (int x = -KPN_BORDER; x < image->width + KPN_BORDER; x++) {
            int cy = y < 0 ? 0 : (y < image->height ? y : image->height - 1);
            int cx = x < 0 ? 0 : (x < image->width ? x : image->width - 1);
            float *sum = to + (pixels(cy, image->width) + (size_t)cx) * (size_t)used;
            for (int c = 0; c < used; c++)
                sum[c] += kpn_pixel(image, y, x)[c];
        }
}

/* Gradients; grad_fine and grad_coarse must be zeroed, grad_parity is (batch, 4, 9), zeroed. NULL
 * where not wanted, but grad_coarse where coarse is given. */
FEWRAY_API int kpn_apply_backward(int batch, int height, int width, int sub, int pitch, int taps,
                                  const float *logits, const float *parity, const float *fine,
                                  const float *coarse, const float *key_fine,
                                  const float *key_coarse, const float *scale,
                                  const float *all_weights, const float *grad_out,
                                  float *grad_logits, float *grad_parity, float *grad_fine,
                                  float *grad_coarse, float *grad_key_fine, float *grad_key_coarse,
                                  float *grad_scale, int threads) {
    const struct level l = {batch,  height, width,  sub,      pitch,      taps, logits,
                            parity, fine,   coarse, key_fine, key_coarse, scale};
    int failed = 0;
#pragma omp parallel for num_threads(threads) reduction(| : failed)
    for (int n = 0; n < batch; n++) {
        struct kpn_image f = {0}, c = {0}, gf = {0}, gc = {0};
        struct kpn_image kf = {0}, kc = {0}, gkf = {0}, gkc = {0};
        pixel8 grad_scales[2] = {{0}};
        size_t first_key = (size_t)n * pixels(height, width) * 8;
        size_t first_key_coarse = (size_t)n * pixels(height / 2, width / 2) * 8;
        size_t first = (size_t)n * pixels(height, width) * 3;
        size_t first_coarse = (size_t)n * pixels(height / 2, width / 2) * 3;
        bool ok = image_new(&f, height, width, 4, fine + first) &&
                  image_new(&gf, height, width, 4, NULL) &&
                  image_new(&kf, height, width, NN_KEY, key_fine + first_key) &&
                  image_new(&gkf, height, width, NN_KEY, NULL);
        if (coarse)
            ok = ok && image_new(&c, height / 2, width / 2, 4, coarse + first_coarse) &&
                 image_new(&gc, height / 2, width / 2, 4, NULL) &&
                 image_new(&kc, height / 2, width / 2, NN_KEY, key_coarse + first_key_coarse) &&
                 image_new(&gkc, height / 2, width / 2, NN_KEY, NULL);
        for (int y = 0; ok && y < height; y++)
            for (int x = 0; x < width; x++) {
                const float *weights = all_weights + ((size_t)n * pixels(height, width) +
                                                      (size_t)y * (size_t)width + (size_t)x) *
                                                         (size_t)taps;
                float products[KPN_TAPS], mean = 0;
                const float *g = grad_out + first + (pixels(y, width) + (size_t)x) * 3;
                pixel4 grad = {g[0], g[1], g[2], 0};
                taps_backward(&f, &gf, 5, y, x, weights, grad, products);
                if (coarse)
                    taps_backward(&c, &gc, 3, y / 2, x / 2, weights + KPN_TAPS_FINE, grad,
                                  products + KPN_TAPS_FINE);
                for (int i = 0; i < taps; i++)
                    mean += weights[i] * products[i];
                float *to = grad_logits + logit_offset(&l, n, y, x);
                for (int i = 0; i < taps; i++)
                    to[i] = weights[i] * (products[i] - mean);
                pixel8 own = load8(kpn_pixel(&kf, y, x)), grad_own = {0};
                taps_distance_backward(own, &kf, &gkf, load8(scale), 5, y, x, to, &grad_own,
                                       &grad_scales[0]);
                if (coarse)
                    taps_distance_backward(own, &kc, &gkc, load8(scale + 8), 3, y / 2, x / 2,
                                           to + KPN_TAPS_FINE, &grad_own, &grad_scales[1]);
                pixel8 sum = load8(kpn_pixel(&gkf, y, x)) + grad_own;
                memcpy(kpn_pixel(&gkf, y, x), &sum, sizeof sum);
                if (grad_parity)
                    for (int i = 0; i < KPN_TAPS_COARSE; i++)
                        grad_parity[(n * 4 + (y & 1) * 2 + (x & 1)) * KPN_TAPS_COARSE + i] +=
                            to[KPN_TAPS_FINE + i];
            }
        if (ok && grad_fine)
            image_gradient(&gf, grad_fine + first);
        if (ok && coarse)
            image_gradient(&gc, grad_coarse + first_coarse);
        if (ok) {
            image_gradient(&gkf, grad_key_fine + first_key);
            memcpy(grad_scale + 16 * n, grad_scales, sizeof grad_scales);
        }
        if (ok && coarse)
            image_gradient(&gkc, grad_key_coarse + first_key_coarse);
        free(gkf.data);
        free(gkc.data);
        failed |= !ok;
        free(f.data);
        free(c.data);
        free(kf.data);
        free(kc.data);
        free(gf.data);
        free(gc.data);
    }
    return failed ? -1 : 0;
}
