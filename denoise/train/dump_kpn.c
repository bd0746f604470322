/* SPDX-License-Identifier: Apache-2.0 */
/* fewray-kpn-data: turns a rendered EXR into a training record, a .npy of half floats that numpy
 * maps into memory.
 *
 *     fewray-kpn-data NOISY.exr -o NOISY.npy
 *         (height, width, 23): color - emission, emission, standard error, albedo, normal (3 each),
 * depth, irradiance (3) and its confidence, shaded albedo (3). color - emission is taken before
 * rounding, so that what a bright lamp lights isn't lost in the lamp's last digit. fewray-kpn-data
 * REFERENCE.exr -o REFERENCE.npy --reference (height, width, 3): the colour alone
 */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "features/features_private.h"

enum { NOISY_CHANNELS = 23, REFERENCE_CHANNELS = 3, NPY_HEADER = 128, LAYERS = 9 };

/* The planes of a layer, NULL where it is missing. A frame that was denoised keeps its render in
 * noisy.*. */
static void find(const struct fewray_frame *frame, enum fewray_layer layer, float *planes[3]) {
    planes[0] = planes[1] = planes[2] = NULL;
    if (layer == FEWRAY_COLOR && fewray_frame_layer(frame, FEWRAY_NOISY, planes))
        return;
    fewray_frame_layer(frame, layer, planes);
}

static void noisy_pixel(float *planes[LAYERS][3], size_t i, float *to) {
    float **color = planes[0], **emission = planes[1], **variance = planes[2];
    float **albedo = planes[3], **shaded = planes[8];
    for (int c = 0; c < 3; c++) {
        float emitted = emission[c] ? emission[c][i] : 0.0f;
        to[c] = fmaxf(color[c][i] - emitted, 0.0f);
        to[3 + c] = emitted;
        to[6 + c] = variance[c] ? sqrtf(variance[c][i]) : 0.0f;
        to[9 + c] = albedo[c] ? albedo[c][i] : 1.0f;
        to[12 + c] = planes[4][c] ? planes[4][c][i] : 0.0f;
        to[16 + c] = planes[6][c] ? planes[6][c][i] : 0.0f;
        to[20 + c] = shaded[c] ? shaded[c][i] : to[9 + c];
    }
    to[15] = planes[5][0] ? planes[5][0][i] : 0.0f;
    to[19] = planes[7][0] ? planes[7][0][i] : 0.0f;
}

static void npy_header(char header[NPY_HEADER], int height, int width, int channels) {
    memset(header, ' ', NPY_HEADER);
    memcpy(header, "\x93NUMPY\x01\x00", 8);
    header[8] = (char)(NPY_HEADER - 10);
    header[9] = 0;
    int n = snprintf(header + 10, NPY_HEADER - 10,
                     "{'descr': '<f2', 'fortran_order': False, 'shape': (%d, %d, %d), }", height,
                     width, channels);
    header[10 + n] = ' ';
    header[NPY_HEADER - 1] = '\n';
}

static int write_record(const struct fewray_frame *frame, bool reference, const char *path,
                        struct fewray_error *error) {
    static const enum fewray_layer layers[LAYERS] = {
        FEWRAY_COLOR,        FEWRAY_EMISSION, FEWRAY_VARIANCE,   FEWRAY_ALBEDO,
        FEWRAY_NORMAL,       FEWRAY_DEPTH,    FEWRAY_IRRADIANCE, FEWRAY_IRRADIANCE_CONFIDENCE,
        FEWRAY_SHADED_ALBEDO};
    float *planes[LAYERS][3];
    for (int i = 0; i < LAYERS; i++)
        find(frame, layers[i], planes[i]);
    if (!planes[0][0])
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, NULL, 0, "the EXR has no R, G, B");
    size_t channels = reference ? REFERENCE_CHANNELS : NOISY_CHANNELS;
    size_t pixels = (size_t)frame->width * (size_t)frame->height;
    size_t size = NPY_HEADER + pixels * channels * sizeof(uint16_t);
    char *bytes = malloc(size);
    if (!bytes)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the record");
    npy_header(bytes, frame->height, frame->width, (int)channels);
    uint16_t *halves = (uint16_t *)(void *)(bytes + NPY_HEADER);
    for (size_t i = 0; i < pixels; i++) {
        float values[NOISY_CHANNELS];
        if (reference)
            for (int c = 0; c < 3; c++)
                values[c] = planes[0][c][i];
        else
            noisy_pixel(planes, i, values);
        half_from_floats(values, halves + i * channels, channels);
    }
    int status = fewray_write_file(path, bytes, size, error);
    free(bytes);
    return status;
}

int main(int argc, char **argv) {
    const char *in = NULL, *out = NULL;
    bool reference = false, usage = false;
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--reference"))
            reference = true;
        else if (!strcmp(argv[i], "-o") && i + 1 < argc)
            out = argv[++i];
        else if (argv[i][0] != '-' && !in)
            in = argv[i];
        else
            usage = true;
    }
    if (usage || !in || !out) {
        fprintf(stderr, "usage: fewray-kpn-data IN.exr -o OUT.npy [--reference]\n");
        return 2;
    }
    struct fewray_error error = {0};
    struct fewray_frame *frame = NULL;
    int status = fewray_frame_read_exr(in, &frame, &error);
    if (status == FEWRAY_OK) {
        fewray_frame_repair(frame);
        status = write_record(frame, reference, out, &error);
    }
    fewray_frame_destroy(&frame);
    if (status != FEWRAY_OK) {
        char text[1100];
        fprintf(stderr, "fewray-kpn-data: %s\n", fewray_error_text(&error, text, sizeof text));
        return 1;
    }
    return 0;
}
