/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_FUZZ_H
#define FEWRAY_TESTS_FUZZ_H

/* What the fuzz targets share. A target is one file with one function, LLVMFuzzerTestOneInput(),
 * which gives an input to a reader and checks what comes out: with libFuzzer it becomes a fuzzer,
 * with replay.c a program that gives it stored files (tests of the ordinary suite).
 *
 * A reader may say anything of an input, but: it doesn't crash, doesn't take memory or time out of
 * proportion, leaves *out NULL where it fails and tells why in one line. What it accepts is what
 * its header promises. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "guide/scene/mesh_data.h"
#include "guide/scene/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Ends the program with a message where a promise is broken. */
#define FUZZ_CHECK(promise)                                                                        \
    do {                                                                                           \
        if (!(promise))                                                                            \
            fuzz_broken(#promise, __FILE__, __LINE__);                                             \
    } while (0)
_Noreturn void fuzz_broken(const char *promise, const char *file, int line);

/* Writes a file of the process's own folder, which lies in memory where there is /dev/shm, and
 * returns its path: valid until the next call but seven. The folder goes when the process does. */
const char *fuzz_file(const char *name, const void *data, size_t size);
const char *fuzz_path(const char *name);

/* Several files in one input: what stands before the first line "@@ NAME" goes to `first`, what
 * follows such a line to NAME, where that is among `names` (NULL-terminated), else nowhere. Files
 * of an earlier input that this one lacks are removed. Returns the path of the first. */
const char *fuzz_files(const uint8_t *data, size_t size, const char *first,
                       const char *const *names);

/* Ends the program where a status and an error don't fit: a failure has a line of text. */
void fuzz_check_error(int status, const struct fewray_error *error);
/* ... where an index of a mesh lies beyond its vertices or a position isn't finite. */
void fuzz_check_mesh(const struct mesh_data *mesh);
/* Loads a scene; ... where it refers to what it doesn't have, or has a mesh that can't be. Returns
 * the loader's status. */
int fuzz_load_scene(const char *path, const struct fewray_scene_options *options);

#endif
