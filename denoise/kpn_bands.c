/* SPDX-License-Identifier: Apache-2.0 */
/* Which rows each layer can make, and which rows are still needed. */

#include "denoise/kpn_bands.h"

#include <limits.h>
#include <string.h>

static int at_least_0(int v) {
    return v > 0 ? v : 0;
}

static int least(int a, int b) {
    return a < b ? a : b;
}

static int border(int buffer) {
    return buffer >= FIRST_IMAGE ? KPN_BORDER : 1;
}

/* kernel0 makes two rows of the picture for each of its predictions, at level 1. */
static bool makes_picture(const struct kpn_layer *layer) {
    return layer->output == NONE;
}

static bool makes_two_rows(const struct kpn_layer *layer) {
    return makes_picture(layer) || layer->op == OP_KEY;
}

/* Rows of a buffer that a layer has made after `made` of its own; -1: it makes no such buffer. */
static int rows_made(const struct kpn_layer *layer, int made, int buffer) {
    if (layer->op == OP_FEATURES && (int)layer->light == buffer)
        return 2 * made;
    if ((int)layer->output == buffer)
        return layer->op == OP_KEY ? 2 * made : made;
    return layer->op == OP_DOWN && kpn_keys_of(layer->output) == buffer ? made : -1;
}

void kpn_bands_start(struct kpn_bands *bands, const struct kpn_layer *layers, int layer_count,
                     const int *levels, int height) {
    *bands = (struct kpn_bands){layers, layer_count, levels, height, {0}, {0}};
    for (int b = 1; b < BUFFER_COUNT; b++)
        bands->first[b] = -border(b);
}

int kpn_bands_rows(const struct kpn_bands *bands, int layer) {
    const struct kpn_layer *l = &bands->layers[layer];
    return bands->height >> (makes_two_rows(l) ? 1 : bands->levels[l->output]);
}

/* Rows of a buffer as its last writer before `layer` has made them. */
static int ready(const struct kpn_bands *bands, int layer, int buffer) {
    for (int i = layer - 1; i >= 0; i--) {
        int made = rows_made(&bands->layers[i], bands->made[i], buffer);
        if (made >= 0)
            return made;
    }
    return 0;
}

/* Of `rows` in all, how many can be used as centres of windows of this radius: the last ones have
 * the border below them. */
static int centres(int ready_rows, int rows, int radius) {
    return ready_rows == rows ? rows : at_least_0(ready_rows - radius);
}

static int kernel_limit(const struct kpn_bands *bands, int layer) {
    const struct kpn_layer *l = &bands->layers[layer];
    int rows = kpn_bands_rows(bands, layer), scale = makes_picture(l) ? 2 : 1;
    int keys = kpn_keys_of(l->light);
    int fine = least(ready(bands, layer, (int)l->light), ready(bands, layer, keys));
    int limit = least(ready(bands, layer, (int)l->input), centres(fine, rows * scale, 2) / scale);
    if (l->coarse) {
        int coarse_rows = bands->height >> bands->levels[l->coarse];
        int coarse = least(ready(bands, layer, (int)l->coarse), ready(bands, layer, keys + 1));
        coarse = centres(coarse, coarse_rows, 1);
        limit = least(limit, makes_picture(l) ? coarse : 2 * coarse);
    }
    return limit;
}

int kpn_bands_limit(const struct kpn_bands *bands, int layer, int band_end) {
    const struct kpn_layer *l = &bands->layers[layer];
    int input = ready(bands, layer, (int)l->input);
    switch (l->op) {
    case OP_FEATURES:
        return band_end / 2;
    case OP_CONV:
        return l->kernel == 3 ? centres(input, kpn_bands_rows(bands, layer), 1) : input;
    case OP_RAW_KEY:
        return input;
    case OP_KEY:
        return least(input, ready(bands, layer, (int)l->light));
    case OP_POOL:
        return input / 2;
    case OP_UPSAMPLE_ADD:
        return least(2 * input, ready(bands, layer, (int)l->output));
    case OP_DOWN:
        input = l->out == 4 ? input : input / 2;
        input = least(input, ready(bands, layer, (int)l->light) / 2);
        return least(input, ready(bands, layer, kpn_keys_of(l->light)) / 2);
    case OP_KERNEL:
        return kernel_limit(bands, layer);
    }
    return 0;
}

/* The first row of a buffer that a layer will still read. */
static int first_needed(const struct kpn_bands *bands, int layer, int buffer) {
    const struct kpn_layer *l = &bands->layers[layer];
    int made = bands->made[layer], need = INT_MAX;
    if (made == kpn_bands_rows(bands, layer))
        return need;
    if ((int)l->input == buffer) {
        if (l->op == OP_CONV)
            need = l->kernel == 3 ? made - 1 : made;
        else if (l->op == OP_POOL)
            need = 2 * made;
        else if (l->op == OP_UPSAMPLE_ADD)
            need = made / 2;
        else if (l->op == OP_DOWN)
            need = l->out == 4 ? made : 2 * made;
        else
            need = made;
    }
    int written = rows_made(l, made, buffer);
    if (written >= 0)
        need = least(need, written);
    bool filters = l->op == OP_KERNEL, pools = l->op == OP_DOWN;
    int keys = filters || pools ? kpn_keys_of(l->light) : NONE;
    if (l->op == OP_KEY && (int)l->light == buffer)
        need = least(need, made);
    if (pools && ((int)l->light == buffer || keys == buffer))
        need = least(need, 2 * made);
    if (filters && ((int)l->light == buffer || keys == buffer))
        need = least(need, makes_picture(l) ? 2 * made - 2 : made - 2);
    if (l->coarse && ((int)l->coarse == buffer || keys + 1 == buffer))
        need = least(need, makes_picture(l) ? made - 1 : made / 2 - 1);
    return need;
}

void kpn_bands_drop(struct kpn_bands *bands) {
    for (int b = 1; b < BUFFER_COUNT; b++) {
        int need = INT_MAX;
        if (kpn_bands_end(bands, b) == 0)
            continue; /* the border above comes with the first row, all of it */
        for (int i = 0; i < bands->layer_count; i++)
            need = least(need, first_needed(bands, i, b));
        int end = kpn_bands_end(bands, b);
        need = least(need, end);
        bands->first[b] = need > bands->first[b] ? need : bands->first[b];
    }
}

int kpn_bands_end(const struct kpn_bands *bands, int buffer) {
    int rows = bands->height >> bands->levels[buffer], made = -1;
    for (int i = 0; i < bands->layer_count && made < 0; i++)
        made = rows_made(&bands->layers[i], bands->made[i], buffer);
    made = at_least_0(made);
    return made == rows ? rows + border(buffer) : made;
}

void kpn_bands_capacity(const struct kpn_layer *layers, int layer_count, const int *levels,
                        int height, int band_rows, int rows[BUFFER_COUNT]) {
    struct kpn_bands bands;
    kpn_bands_start(&bands, layers, layer_count, levels, height);
    memset(rows, 0, sizeof(int) * BUFFER_COUNT);
    for (int end = 0; end < height;) {
        end = least(end + band_rows, height);
        for (int i = 0; i < layer_count; i++)
            bands.made[i] = kpn_bands_limit(&bands, i, end);
        for (int b = 1; b < BUFFER_COUNT; b++) {
            int held = kpn_bands_end(&bands, b) - bands.first[b];
            rows[b] = held > rows[b] ? held : rows[b];
        }
        kpn_bands_drop(&bands);
    }
}
