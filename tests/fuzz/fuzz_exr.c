/* SPDX-License-Identifier: Apache-2.0 */
/* An EXR picture as `fewray denoise` and `fewray merge` read it: header, pixels, other renderers'
 * layers, repair, and whether it is a part. */

#include <math.h>

#include "pipeline/layer_names.h"
#include "pipeline/part.h"
#include "tests/fuzz/fuzz.h"

static void check_repaired(struct fewray_frame *frame) {
    float *planes[3];
    adopt_layer_names(frame, NAMING_AUTO);
    fewray_frame_repair(frame);
    if (!fewray_frame_layer(frame, FEWRAY_COLOR, planes))
        return;
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < (size_t)frame->width * (size_t)frame->height; i++)
            FUZZ_CHECK(isfinite(planes[c][i]) && planes[c][i] >= 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *path = fuzz_file("picture.exr", data, size);
    struct fewray_frame *frame = NULL;
    struct fewray_error error = {0};
    int status = fewray_frame_read_exr_header(path, &frame, &error);
    fuzz_check_error(status, &error);
    fewray_frame_destroy(&frame);

    status = fewray_frame_read_exr(path, &frame, &error);
    fuzz_check_error(status, &error);
    FUZZ_CHECK(!status == !!frame);
    if (frame) {
        struct part_label label;
        part_label_read(frame, path, &label, &error);
        check_repaired(frame);
    }
    fewray_frame_destroy(&frame);
    return 0;
}
