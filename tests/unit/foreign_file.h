/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FOREIGN_FILE_H
#define FOREIGN_FILE_H

#include <stdbool.h>
#include <stddef.h>

/* EXRs of any make, written and compared by OpenImageIO. */

#ifdef __cplusplus
extern "C" {
#endif

struct foreign_part {
    const char *name;     /* NULL: the part has none */
    const char *channels; /* "R:half,G:half,B:half,id:uint,Z:float" */
    int window[4];        /* x, y, width, height of the data window */
};
struct foreign_make {
    const char *what, *compression, *line_order;
    int tile; /* pixels a side; 0: scanlines */
    int display[4];
    struct foreign_part parts[4]; /* up to the first without channels */
};

/* Writes it with many attributes: texts (one of 3000 bytes), numbers, vectors, matrices, a time
 * code, chromaticities. False with a message on stderr. */
bool foreign_write(const char *path, const struct foreign_make *make);

/* A deep picture. */
bool foreign_write_deep(const char *path, int width, int height);

/* Whether b is a but for the pixels of some channels, "R,G,B", and channels that a lacks: the same
 * parts, windows, tiles, compression, attributes, channels, types and bits. why tells. */
bool foreign_is_kept(const char *a, const char *b, const char *changed, char *why, size_t size);

#ifdef __cplusplus
}
#endif
#endif
