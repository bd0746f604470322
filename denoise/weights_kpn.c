/* SPDX-License-Identifier: Apache-2.0 */
/* Embeds the weights file whose path the build gives as KPN_WEIGHTS_FILE. */

#include "denoise/weights_kpn.h"

extern const unsigned char kpn_weights_end[];

__asm__(".section .rodata,\"a\"\n"
        ".balign 64\n"
        ".globl kpn_weights\n.hidden kpn_weights\nkpn_weights:\n"
        ".incbin \"" KPN_WEIGHTS_FILE "\"\n"
        ".globl kpn_weights_end\n.hidden kpn_weights_end\nkpn_weights_end:\n"
        ".byte 0\n"
        ".previous\n");

size_t kpn_weights_size(void) {
    return (size_t)(kpn_weights_end - kpn_weights);
}
