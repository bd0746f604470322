/* SPDX-License-Identifier: Apache-2.0 */
/* Channel names of the layers that fewray reads and writes. */
#include "fewray/features.h"

static const struct {
    const char *names[3];
    int count;
} layers[FEWRAY_LAYER_COUNT] = {
    [FEWRAY_COLOR] = {{"R", "G", "B"}, 3},
    [FEWRAY_NOISY] = {{"noisy.R", "noisy.G", "noisy.B"}, 3},
    [FEWRAY_VARIANCE] = {{"variance.R", "variance.G", "variance.B"}, 3},
    [FEWRAY_ALBEDO] = {{"albedo.R", "albedo.G", "albedo.B"}, 3},
    [FEWRAY_SHADED_ALBEDO] = {{"shaded_albedo.R", "shaded_albedo.G", "shaded_albedo.B"}, 3},
    [FEWRAY_NORMAL] = {{"normal.X", "normal.Y", "normal.Z"}, 3},
    [FEWRAY_DEPTH] = {{"depth.Z"}, 1},
    [FEWRAY_EMISSION] = {{"emission.R", "emission.G", "emission.B"}, 3},
    [FEWRAY_IRRADIANCE] = {{"irradiance.R", "irradiance.G", "irradiance.B"}, 3},
    [FEWRAY_IRRADIANCE_CONFIDENCE] = {{"irradiance.confidence"}, 1},
};

const char *const *fewray_layer_channels(enum fewray_layer layer, int *count) {
    *count = layers[layer].count;
    return layers[layer].names;
}
