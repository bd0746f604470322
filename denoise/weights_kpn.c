/* SPDX-License-Identifier: Apache-2.0 */
/* Embeds the weights file whose path the build gives as KPN_WEIGHTS_FILE. */

#include "denoise/weights_kpn.h"

#include "denoise/nn/embed.h"

NN_EMBED(kpn_weights, KPN_WEIGHTS_FILE)
