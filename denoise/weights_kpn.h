/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_WEIGHTS_KPN_H
#define FEWRAY_DENOISE_WEIGHTS_KPN_H

/* The weights file train/weights/kpn.bin, built into the library. */

#include <stddef.h>

extern const unsigned char kpn_weights[];
size_t kpn_weights_size(void);

#endif
