/* SPDX-License-Identifier: Apache-2.0 */
/* Reads and writes expected.json. */

#include "regression_case.h"

#include <jansson.h>
#include <stdio.h>

const struct regression_mode REGRESSION_MODES[MODE_COUNT] = {{"pt", false, false},
                                                             {"guided", true, false},
                                                             {"denoised", false, true},
                                                             {"guided_denoised", true, true}};
const char *const REGRESSION_METRICS[METRIC_COUNT] = {"mrse", "mrse_trimmed"};

bool regression_case_read(const char *path, struct regression_case *out) {
    json_error_t fault;
    json_t *root = json_load_file(path, 0, &fault);
    const char *scene = NULL;
    *out = (struct regression_case){.tolerance = 0.1};
    const bool read =
        root && !json_unpack_ex(root, &fault, 0, "{s:s, s:i, s:i, s:i, s:i, s:i, s:F}", "scene",
                                &scene, "width", &out->width, "height", &out->height, "spp",
                                &out->spp, "seeds", &out->seeds, "reference_spp",
                                &out->reference_spp, "tolerance", &out->tolerance);
    if (!read) {
        fprintf(stderr, "%s:%d: %s\n", path, fault.line, fault.text);
        json_decref(root);
        return false;
    }
    snprintf(out->scene, sizeof out->scene, "%s", scene);
    const json_t *expected = json_object_get(root, "expected");
    for (int m = 0; m < MODE_COUNT; m++)
        for (int k = 0; k < METRIC_COUNT; k++)
            out->expected[m][k] = json_number_value(json_object_get(
                json_object_get(expected, REGRESSION_MODES[m].name), REGRESSION_METRICS[k]));
    json_decref(root);
    return true;
}

bool regression_case_write(const char *path, const struct regression_case *in) {
    json_t *expected = json_object();
    for (int m = 0; m < MODE_COUNT; m++) {
        json_t *mode = json_object();
        for (int k = 0; k < METRIC_COUNT; k++)
            json_object_set_new(mode, REGRESSION_METRICS[k], json_real(in->expected[m][k]));
        json_object_set_new(expected, REGRESSION_MODES[m].name, mode);
    }
    json_t *root = json_pack("{s:s, s:i, s:i, s:i, s:i, s:i, s:f, s:o}", "scene", in->scene,
                             "width", in->width, "height", in->height, "spp", in->spp, "seeds",
                             in->seeds, "reference_spp", in->reference_spp, "tolerance",
                             in->tolerance, "expected", expected);
    FILE *file = root ? fopen(path, "w") : NULL;
    bool written = file && !json_dumpf(root, file, JSON_INDENT(2) | JSON_REAL_PRECISION(5)) &&
                   fputc('\n', file) != EOF;
    if (file && fclose(file))
        written = false;
    json_decref(root);
    if (!written)
        fprintf(stderr, "%s: can't be written\n", path);
    return written;
}
