/* SPDX-License-Identifier: Apache-2.0 */
/* An EXR picture as `fewray denoise`, `fewray info` and `fewray merge` read it: header, pixels,
 * other renderers' layers, their sums, repair, whether it is a part, and a copy with new pixels. */

#include <math.h>
#include <stdlib.h>

#include "pipeline/layer_names.h"
#include "pipeline/part.h"
#include "pipeline/pass_sums.h"
#include "tests/fuzz/fuzz.h"

/* What can be read can be copied, and the copy read. */
static void check_copy(const char *path, const struct fewray_frame *frame) {
    struct fewray_exr_change change = {frame->planes[0].name, frame->planes[0].data};
    struct fewray_exr_header *header = NULL;
    struct fewray_frame *copy = NULL;
    struct fewray_error error = {0};
    fuzz_check_error(fewray_exr_header_read(path, &header, &error), &error);
    fewray_exr_header_destroy(&header);
    const int status = fewray_exr_rewrite(path, &change, 1, false, path, &error);
    fuzz_check_error(status, &error);
    if (!status)
        FUZZ_CHECK(!fewray_frame_read_exr(path, &copy, &error) &&
                   copy->plane_count == frame->plane_count);
    fewray_frame_destroy(&copy);
}

static void check_repaired(struct fewray_frame *frame) {
    float *planes[3];
    struct adoption adoption;
    struct pass_sums *sums = malloc(sizeof *sums);
    adopt_layers(frame, NAMING_AUTO, true, &adoption);
    if (sums)
        pass_sums_find(frame, &adoption, NAMING_AUTO, true, sums);
    free(sums);
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
        check_copy(path, frame);
        check_repaired(frame);
    }
    fewray_frame_destroy(&frame);
    return 0;
}
