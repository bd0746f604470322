/* SPDX-License-Identifier: Apache-2.0 */
/* How far layers are from adding up to the picture: sum_of_layers PICTURE.exr LAYER...
 *
 * Prints the largest difference between the sum of the layers and R, G, B, as a part of the latter,
 * before and after the denoiser. */

#include <math.h>
#include <stdio.h>

#include "fewray/features.h"

enum { LAYERS_MAX = 32 };

/* NULL: the frame lacks PREFIX[LAYER.]COMPONENT. */
static const float *find(const struct fewray_frame *frame, const char *prefix, const char *layer,
                         char component) {
    char name[2 * FEWRAY_NAME_MAX];
    snprintf(name, sizeof name, "%s%.64s%s%c", prefix, layer, *layer ? "." : "", component);
    return fewray_frame_plane(frame, name);
}

/* The largest relative difference; negative where a layer is missing. */
static double difference(const struct fewray_frame *frame, const char *prefix, char **layers,
                         int count) {
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    double largest = 0;
    for (const char *component = "RGB"; *component; component++) {
        const float *color = find(frame, prefix, "", *component);
        for (int k = 0; k < count; k++)
            if (!color || !find(frame, prefix, layers[k], *component))
                return -1;
        const float *planes[LAYERS_MAX];
        for (int k = 0; k < count; k++)
            planes[k] = find(frame, prefix, layers[k], *component);
        for (size_t i = 0; i < pixels; i++) {
            double sum = 0;
            for (int k = 0; k < count; k++)
                sum += planes[k][i];
            largest = fmax(largest, fabs(sum - color[i]) / fmax(color[i], 1e-6));
        }
    }
    return largest;
}

int main(int argc, char **argv) {
    if (argc < 3 || argc > 2 + LAYERS_MAX) {
        fprintf(stderr, "usage: sum_of_layers PICTURE.exr LAYER...\n");
        return 2;
    }
    struct fewray_frame *frame = NULL;
    struct fewray_error error;
    if (fewray_frame_read_exr(argv[1], &frame, &error)) {
        char text[1024];
        fprintf(stderr, "%s\n", fewray_error_text(&error, text, sizeof text));
        return 1;
    }
    const double noisy = difference(frame, "noisy.", argv + 2, argc - 2);
    const double denoised = difference(frame, "", argv + 2, argc - 2);
    fewray_frame_destroy(&frame);
    if (noisy < 0 || denoised < 0) {
        fprintf(stderr, "%s: a layer is missing, or its noisy.*\n", argv[1]);
        return 1;
    }
    printf(
        "largest difference between the layers' sum and the picture, as a part of it: %.2g noisy, "
        "%.2g denoised\n",
        noisy, denoised);
    return 0;
}
