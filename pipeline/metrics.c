/* SPDX-License-Identifier: Apache-2.0 */
/* Frames to metrics: finds the planes and hands them to OpenCV. */

#include "pipeline/opencv.h"

int fewray_compare(const struct fewray_frame *test, const struct fewray_frame *reference,
                   struct fewray_metrics *metrics, struct fewray_error *error) {
    static const char *const noise_names[3] = {"stderr.R", "stderr.G", "stderr.B"};
    float *x[3], *r[3], *noise[3];
    if (!fewray_frame_layer(test, FEWRAY_COLOR, x) ||
        !fewray_frame_layer(reference, FEWRAY_COLOR, r))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "a picture without R, G, B can't be compared");
    if (test->width != reference->width || test->height != reference->height)
        return fewray_fail(
            error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
            "has %dx%d pixels, the reference has %dx%d; render it in the reference's size",
            test->width, test->height, reference->width, reference->height);
    const struct opencv *cv = opencv_open(error);
    if (!cv)
        return FEWRAY_ERROR_UNSUPPORTED;
    bool has_noise = true;
    for (int c = 0; c < 3; c++)
        has_noise = (noise[c] = fewray_frame_plane(reference, noise_names[c])) && has_noise;
    return cv->metrics(x, r, has_noise ? noise : NULL, test->width, test->height, metrics, error);
}
