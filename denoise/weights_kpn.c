/* SPDX-License-Identifier: Apache-2.0 */
/* Embeds the weights files of the folder that the build gives as KPN_WEIGHTS. */

#include "denoise/weights_kpn.h"

#include "denoise/nn/embed.h"

NN_EMBED(kpn_weights, KPN_WEIGHTS "/kpn.bin")
NN_EMBED(kpn_fast_weights, KPN_WEIGHTS "/kpn_fast.bin")
