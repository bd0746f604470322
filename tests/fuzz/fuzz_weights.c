/* SPDX-License-Identifier: Apache-2.0 */
/* The networks' weights. The checksum is made right, so that damage comes behind it. */

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "denoise/nn/nn.h"
#include "fewray/denoise.h"
#include "guide/odis/network.h"
#include "tests/fuzz/fuzz.h"

enum { WIDTH = 9, HEIGHT = 7 };

/* Weights that are taken must give a picture, whatever it shows. */
static void denoise(const char *path) {
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_error error = {0};
    fewray_denoise_options_init(&options);
    options.weights_path = path;
    options.threads = 1;
    options.isa = "plain";
    const int status = fewray_denoiser_create(&options, &denoiser, &error);
    fuzz_check_error(status, &error);
    if (!status) {
        static float rgb[HEIGHT * WIDTH * 3], out[HEIGHT * WIDTH * 3];
        for (int i = 0; i < HEIGHT * WIDTH * 3; i++)
            rgb[i] = (float)(i % 7);
        const struct fewray_denoise_input in = {
            .width = WIDTH, .height = HEIGHT, .color = fewray_interleaved(rgb, WIDTH)};
        fuzz_check_error(fewray_denoiser_run(denoiser, &in, out, NULL, &error), &error);
    }
    fewray_denoiser_destroy(&denoiser);
}

static void guide(const char *path) {
    struct odis_weights *weights = NULL;
    struct fewray_error error = {0};
    fuzz_check_error(odis_weights_load(path, &weights, &error), &error);
    odis_weights_destroy(&weights);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    uint8_t *file = malloc(size + 1);
    FUZZ_CHECK(file);
    memcpy(file, data, size);
    if (size > 16) {
        const uint32_t crc = (uint32_t)crc32(0, file + 16, (uInt)(size - 16));
        for (int i = 0; i < 4; i++)
            file[12 + i] = (uint8_t)(crc >> 8 * i);
    }
    const char *path = fuzz_file("weights.bin", file, size);
    free(file);
    denoise(path);
    guide(path);
    return 0;
}
