/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_DENOISE_NN_EMBED_H
#define FEWRAY_DENOISE_NN_EMBED_H

/* NN_EMBED(name, "FILE") puts a file's bytes into the library as name[], with name_size() bytes. */

#include <stddef.h>

#define NN_EMBED(name, file)                                                                       \
    extern const unsigned char name[], name##_end[];                                               \
    __asm__(".section .rodata,\"a\"\n.balign 64\n"                                                 \
            ".globl " #name "\n.hidden " #name "\n" #name ":\n.incbin \"" file "\"\n"              \
            ".globl " #name "_end\n.hidden " #name "_end\n" #name "_end:\n.byte 0\n.previous\n");  \
    size_t name##_size(void) {                                                                     \
        return (size_t)(name##_end - name);                                                        \
    }

#endif
