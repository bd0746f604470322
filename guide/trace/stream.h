/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_STREAM_H
#define FEWRAY_GUIDE_STREAM_H

/* Bytes on their way out of memory or back into it. Nothing is allocated that the bytes which are
 * left couldn't fill. */

#include <stdbool.h>
#include <stddef.h>

struct fewray_look;

enum stream_fault { STREAM_SOUND, STREAM_CUT, STREAM_ODD, STREAM_NO_MEMORY };

struct stream {
    bool (*write)(void *user, const void *bytes, size_t size); /* NULL where it is read */
    bool (*read)(void *user, void *bytes, size_t size);        /* NULL where it is written */
    void *user;
    size_t left; /* bytes that can still be read */
    enum stream_fault fault;
};

/* Each returns false, and says why in stream->fault, where the bytes can't be moved. */
bool stream_move(struct stream *stream, void *bytes, size_t size);
/* An array of count times each bytes, allocated where it is read. */
bool stream_array(struct stream *stream, void **array, size_t count, size_t each);
/* A look's records; where it is read, *look is made: width x height pixels of so many samples. */
bool stream_look(struct stream *stream, struct fewray_look **look, int width, int height,
                 int samples, bool seconds);
/* Holds where it is written; what is read must fulfil it. */
bool stream_demand(struct stream *stream, bool condition);

#define STREAM_MOVE(stream, value) stream_move(stream, &(value), sizeof(value))

#endif
