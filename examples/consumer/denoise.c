/* SPDX-License-Identifier: Apache-2.0 */
/* Denoises a buffer of one's own: grey noise, whose deviation is told before and after.
 *     cc denoise.c $(pkg-config --cflags --libs fewray) -lm */
#include <fewray/fewray.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIZE = 64, VALUES = 3 * SIZE * SIZE };

static double deviation(const float *rgb) {
    double sum = 0;
    for (int i = 0; i < VALUES; i++)
        sum += (rgb[i] - 0.5) * (rgb[i] - 0.5);
    return sqrt(sum / VALUES);
}

int main(void) {
    static float noisy[VALUES], clean[VALUES]; /* (height, width, 3), linear */
    for (int i = 0; i < VALUES; i++)
        noisy[i] = (float)rand() / (float)RAND_MAX;
    struct fewray_denoise_input in = {
        .width = SIZE, .height = SIZE, .color = fewray_interleaved(noisy, SIZE)};

    struct fewray_denoise_options options;
    fewray_denoise_options_init(&options);
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_error error;
    if (fewray_denoiser_create(&options, &denoiser, &error) ||
        fewray_denoiser_run(denoiser, &in, clean, NULL, &error)) {
        fprintf(stderr, "%s\n", error.what);
        return 1;
    }
    fewray_denoiser_destroy(&denoiser);
    printf("fewray %s: deviation %.3f before, %.3f after\n", fewray_version(), deviation(noisy),
           deviation(clean));
    return 0;
}
