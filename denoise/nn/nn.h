/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_NN_H
#define FEWRAY_DENOISE_NN_H

/* The convolution engine under both networks: weights, tensors, kernels chosen for the CPU at run
 * time.
 *
 * A tensor is (height + 2, width + 2, channels) floats, channels fastest and a multiple of
 * NN_LANES, with a border of one pixel that the convolutions read; at(0, 0) is the first inner
 * pixel. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fewray/features.h"

#define NN_LANES 16

enum nn_isa { NN_ISA_AUTO, NN_ISA_PLAIN, NN_ISA_AVX2, NN_ISA_AVX512 };
enum nn_activation { NN_LINEAR, NN_LEAKY_RELU /* slope 0.2 below zero */ };
enum nn_border {
    NN_BORDER_ZERO,
    NN_BORDER_WRAP_X /* columns wrap around, rows above and below are zero */
};

/* --- weights: one small file a network */

struct nn_weight {
    char name[48];
    int shape[4]; /* PyTorch's order: (out, in, kh, kw), or (out, 1, 1, 1) for a bias */
    const float *data;
};

struct nn_weights {
    int count;
    struct nn_weight *tensors;
    char *info; /* JSON text that the training script left: network's name and settings */
    float *storage;
    char *name; /* of the file, for messages; may be NULL */
};

/* Parses a weights file: "FEWRAYNN", uint32 version 1, uint32 CRC-32 (zlib) of all that follows,
 * uint32 info length, info bytes, uint32 count, then for each tensor 48 bytes of name (zero
 * padded), int32 shape[4], and product(shape) IEEE half floats; all little endian, no padding.
 * Everything is checked, name appears in errors. *out is owned by the caller. */
int nn_weights_parse(const void *bytes, size_t size, const char *name, struct nn_weights **out,
                     struct fewray_error *error);
int nn_weights_read(const char *path, struct nn_weights **out, struct fewray_error *error);
void nn_weights_destroy(struct nn_weights **weights);
/* The tensor of this name and shape, or NULL with *error filled. */
const struct nn_weight *nn_weights_find(const struct nn_weights *weights, const char *name,
                                        const int shape[4], struct fewray_error *error);

/* --- kernels */

/* A convolution of kernel 1 or 3, stride 1, packed for the lanes: in and out are rounded up to
 * NN_LANES with zeros. */
struct nn_conv {
    int kernel, in, out; /* in, out: rounded up */
    int in_used;  /* true input channels rounded up to 4; the rest have zero weights, are skipped */
    int out_used; /* true output channels rounded up to NN_LANES / 2; the rest are set to zero */
    float *weights; /* (out / NN_LANES, kernel, kernel, in, NN_LANES) */
    float *bias;    /* (out) */
};

/* Packs "<layer>.weight" and "<layer>.bias" of the given true channel counts. Owned by the caller:
 * nn_conv_clear(). */
int nn_conv_pack(struct nn_conv *conv, const struct nn_weights *weights, const char *layer,
                 int kernel, int in, int out, struct fewray_error *error);
void nn_conv_clear(struct nn_conv *conv);

struct nn_tensor {
    int height, width, channels;
    float *data; /* (height + 2, width + 2, channels), 64-byte aligned; owned by whoever gave it */
};

/* Bytes of a tensor's data, rounded up to 64. */
size_t nn_tensor_bytes(int height, int width, int channels);
/* The first channel of an inner pixel; y and x may be -1 and height or width. */
static inline float *nn_at(const struct nn_tensor *t, int y, int x) {
    return t->data +
           ((size_t)(y + 1) * (size_t)(t->width + 2) + (size_t)(x + 1)) * (size_t)t->channels;
}
void nn_fill_border(const struct nn_tensor *t, enum nn_border border);

#define NN_KEY 8 /* floats of a key */

/* count pixels of a row and the size x size taps of each (size 3 or 5): logits[i * pitch + t] +=
 * tap[7] - sum over c < 7 of scale[c] (own[c] - tap[c])^2, own and tap being keys of NN_KEY floats.
 * After Isik et al. 2021 (interactive Monte Carlo denoising using affinity of neural features),
 * equations 2 and 3: there the distance is all, here it is added to predicted logits. */
struct nn_affinity {
    int count, size;
    float *logits;
    size_t pitch;
    const float *own; /* of the first pixel, the next one's own_step floats farther */
    size_t own_step;
    const float *taps; /* the first pixel's upper left tap; pixels taps_step apart, rows taps_row */
    size_t taps_step, taps_row;
    const float *scale; /* NN_KEY floats, the last one 0 */
};

/* One table of kernels an instruction set; every function works on rows y0 <= y < y1 of its output,
 * so that threads can share a layer. Borders of inputs must be filled; borders of outputs aren't
 * touched. */
struct nn_kernels {
    enum nn_isa isa;
    const char *name;
    /* out(y, x) = activation(bias + sum weights * in): 3x3 with the border as padding, or 1x1. out
     * may not be in. The tensors may have more channels than the convolution: it reads and writes
     * their first ones. */
    void (*conv)(const struct nn_conv *conv, const struct nn_tensor *in,
                 const struct nn_tensor *out, enum nn_activation activation, int y0, int y1);
    /* out(y, x) = mean of the 2x2 pixels of in; in has twice out's size. */
    void (*average_pool)(const struct nn_tensor *in, const struct nn_tensor *out, int y0, int y1);
    /* out(y, x) += in(y / 2, x / 2): nearest upsampling added to a skip connection; out has twice
     * in's size. */
    void (*upsample_add)(const struct nn_tensor *in, const struct nn_tensor *out, int y0, int y1);
    /* In-place softmax over n floats (any n, not padded), subtracting the maximum; -> non-negative,
     * sum 1. */
    void (*softmax)(float *values, int n);
    /* The same for rows softmaxes of n floats, stride floats apart (stride >= n). */
    void (*softmax_rows)(float *values, int rows, int stride, int n);
    /* Adds the affinity of pixels to their taps to the logits of a kernel. */
    void (*add_affinity)(const struct nn_affinity *affinity);
    /* weights (rows, n rounded up to NN_LANES) = softmax of n logits a row, `stride` floats apart,
     * plus bias (2, n rounded up; zero beyond n) of even and odd rows, NULL: none. Weights beyond n
     * get anything. */
    void (*softmax_to)(const float *logits, int rows, int stride, const float *bias, int n,
                       float *weights);
};

/* The best table the CPU has, or a lower one where isa or the environment variable FEWRAY_ISA
 * (plain, avx2, avx512) says so. */
const struct nn_kernels *nn_kernels_get(enum nn_isa isa);
/* "auto", "plain", "avx2", "avx512" -> *isa; false for other names. */
bool nn_isa_from_name(const char *name, enum nn_isa *isa);

#endif
