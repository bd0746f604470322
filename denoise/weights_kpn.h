/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_WEIGHTS_KPN_H
#define FEWRAY_DENOISE_WEIGHTS_KPN_H

/* The weights files train/weights/kpn.bin and kpn_fast.bin, built into the library. */

#include <stddef.h>

extern const unsigned char kpn_weights[];
size_t kpn_weights_size(void);
extern const unsigned char kpn_fast_weights[];
size_t kpn_fast_weights_size(void);

#endif
