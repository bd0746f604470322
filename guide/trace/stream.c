/* SPDX-License-Identifier: Apache-2.0 */
/* Bytes of a render's state, both ways. */

#include "guide/trace/stream.h"

#include <stdlib.h>
#include <string.h>

#include "guide/odis/look.h"
#include "guide/odis/sphere_grid.h"

static bool fail(struct stream *s, enum stream_fault fault) {
    s->fault = s->fault ? s->fault : fault;
    return false;
}

bool stream_demand(struct stream *s, bool condition) {
    return condition && !s->fault ? true : fail(s, STREAM_ODD);
}

bool stream_move(struct stream *s, void *bytes, size_t size) {
    if (s->fault)
        return false;
    if (s->write)
        return s->write(s->user, bytes, size) ? true : fail(s, STREAM_CUT);
    if (size > s->left || !s->read(s->user, bytes, size))
        return fail(s, STREAM_CUT);
    s->left -= size;
    return true;
}

bool stream_array(struct stream *s, void **array, size_t count, size_t each) {
    if (s->read) {
        if (s->fault || count > s->left / each)
            return fail(s, STREAM_CUT);
        *array = malloc(count * each + 1);
        if (!*array)
            return fail(s, STREAM_NO_MEMORY);
    }
    return stream_move(s, *array, count * each);
}

/* Bins that exist, and bools that are one. */
static bool is_sound(const struct fewray_look *look, size_t n) {
    for (size_t i = 0; i < n; i++) {
        unsigned char flag = 0;
        if (look->seconds)
            memcpy(&flag, &look->seconds[i].light_sent, 1);
        if (look->records[i].bin >= SPHERE_BINS || flag > 1)
            return false;
    }
    return true;
}

bool stream_look(struct stream *s, struct fewray_look **look, int width, int height, int samples,
                 bool seconds) {
    const size_t n = (size_t)width * (size_t)height * (size_t)samples;
    const size_t each = sizeof(struct look_record) + (seconds ? sizeof(struct look_second) : 0);
    if (s->read) {
        if (s->fault || n > s->left / each)
            return fail(s, STREAM_CUT);
        if (look_create(width, height, samples, seconds, look, NULL))
            return fail(s, STREAM_NO_MEMORY);
    }
    return stream_move(s, (*look)->records, n * sizeof(*(*look)->records)) &&
           (!seconds || stream_move(s, (*look)->seconds, n * sizeof(*(*look)->seconds))) &&
           stream_demand(s, is_sound(*look, n));
}
