/* SPDX-License-Identifier: Apache-2.0 */
/* Text and pictures as HTML takes them. */

#include "pipeline/page/page.h"

void html_text(FILE *file, const char *text) {
    for (const char *c = text; *c; c++)
        switch (*c) {
        case '&':
            fputs("&amp;", file);
            break;
        case '<':
            fputs("&lt;", file);
            break;
        case '>':
            fputs("&gt;", file);
            break;
        case '"':
            fputs("&quot;", file);
            break;
        case '\'':
            fputs("&#39;", file);
            break;
        default:
            fputc((unsigned char)*c < ' ' || *c == 127 ? ' ' : *c, file);
        }
}

/* Base64 (RFC 4648, section 4) of three bytes, of which count are there. */
static void put_group(FILE *file, const uint8_t *bytes, size_t count) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned group = (unsigned)bytes[0] << 16 | (count > 1 ? (unsigned)bytes[1] << 8 : 0) |
                           (count > 2 ? bytes[2] : 0);
    const char text[4] = {digits[group >> 18], digits[group >> 12 & 63],
                          count > 1 ? digits[group >> 6 & 63] : '=',
                          count > 2 ? digits[group & 63] : '='};
    fwrite(text, 1, sizeof text, file);
}

void html_png(FILE *file, const void *png, size_t bytes) {
    const uint8_t *data = png;
    fputs("data:image/png;base64,", file);
    for (size_t i = 0; i < bytes; i += 3)
        put_group(file, data + i, bytes - i < 3 ? bytes - i : 3);
}
