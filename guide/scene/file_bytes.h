/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_FILE_BYTES_H
#define FEWRAY_GUIDE_SCENE_FILE_BYTES_H

/* A whole file in memory, read-only. */

#include "fewray/features.h"

struct file_bytes {
    char *data;
    size_t size;
};

/* Reads the file, with a NUL behind its last byte. */
int file_read(const char *path, struct file_bytes *out, struct fewray_error *error);
/* Refuses folders, pipes and devices, which could be without end; FEWRAY_OK also where there is no
 * such file, which is for whoever opens it to tell. */
int file_check_regular(const char *path, struct fewray_error *error);
void file_free(struct file_bytes *file);

#endif
