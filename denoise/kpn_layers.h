/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_KPN_LAYERS_H
#define FEWRAY_DENOISE_KPN_LAYERS_H

/* Layers that go through the kernels beside the beauty.
 *
 * A pixel of light has slots of four channels. The beauty has the first three of slot 0, the n-th
 * layer of radiance those of slot n, and the n-th coverage the fourth channel of slot n - 1. */

#include "denoise/features_kpn.h"

/* Each layer needs all its channels and places for them. */
int kpn_layers_check(const struct fewray_denoise_input *in, struct fewray_error *error);

/* 1 without layers. */
int kpn_layers_slots(const struct fewray_denoise_input *in);

/* Fills in what isn't the beauty's of a row of light, (count, 4 * slots). Pixels beyond the
 * picture's edges take the nearest one. scratch: 6 * count floats. */
void kpn_layers_light_row(const struct fewray_denoise_input *in, int y, int x0, int count,
                          float *scratch, int slots, float *light);

/* Writes pixels of a row of all layers, inside the picture. filtered: (count, 4) for each slot,
 * slot_floats apart; NULL: what isn't filtered is kept as it is. */
void kpn_layers_put_row(const struct fewray_denoise_input *in, int y, int x0, int count,
                        const float *filtered, size_t slot_floats);

#endif
