/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_KPN_BANDS_H
#define FEWRAY_DENOISE_KPN_BANDS_H

/* The order in which the network's layers make their rows: band after band of the picture, each
 * layer as far as the rows that it reads reach. A row is made once and dropped after its last
 * reader, so that a tall region needs the memory of a few hundred rows. */

#include "denoise/kpn_rows.h"

#define KPN_LAYERS_MAX 64

struct kpn_bands {
    const struct kpn_layer *layers;
    int layer_count;
    const int *levels;        /* of each buffer */
    int height;               /* of the region at level 0 */
    int made[KPN_LAYERS_MAX]; /* rows that a layer has made, at its output's level */
    int first[BUFFER_COUNT];  /* first row that is kept, the border's included */
};

void kpn_bands_start(struct kpn_bands *bands, const struct kpn_layer *layers, int layer_count,
                     const int *levels, int height);
/* Rows of a layer in all. */
int kpn_bands_rows(const struct kpn_bands *bands, int layer);
/* The row up to which a layer can work while the picture is read up to band_end, which is even. */
int kpn_bands_limit(const struct kpn_bands *bands, int layer, int band_end);
/* Raises first[] to the first row that any layer will still read. */
void kpn_bands_drop(struct kpn_bands *bands);
/* Row after the last one that a buffer holds, the border's included. */
int kpn_bands_end(const struct kpn_bands *bands, int buffer);

/* Runs the order without the network: the most rows of each buffer that are held at a time where
 * bands have band_rows rows. */
void kpn_bands_capacity(const struct kpn_layer *layers, int layer_count, const int *levels,
                        int height, int band_rows, int rows[BUFFER_COUNT]);

#endif
