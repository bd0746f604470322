/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_CHECKPOINT_H
#define FEWRAY_PIPELINE_CHECKPOINT_H

/* The file in which a long render keeps its state, replaced now and then, as a whole. Magic, format
 * version, CRC-32 of all that follows, its number of bytes; then struct checkpoint_info, and the
 * bytes of fewray_state_write(). Numbers are in the machine's own order. */

#include "pipeline/part.h"

/* What the state is of, and how it came about. */
struct checkpoint_info {
    struct part_label label; /* its spp is checked with the state */
    double seconds;          /* of wall time, of all runs so far */
    double samples;          /* a pixel, mean over the picture */
    int resumes;             /* runs that went on with it, so far */
    uint32_t layout;         /* of the state's structures in memory: checkpoint_layout() */
    char program[16];        /* version */
};

/* A checkpoint that is read. */
struct checkpoint_file {
    void *file; /* FILE, NULL: none */
    const char *path;
    size_t left; /* bytes of the state */
    struct checkpoint_info info;
};

/* Opens the file and checks it to the last byte: what is no checkpoint, of another version or
 * damaged is refused. Without a file there is none: FEWRAY_OK, unless it must exist. */
int checkpoint_open(const char *path, bool must_exist, struct checkpoint_file *out,
                    struct fewray_error *error);
void checkpoint_close(struct checkpoint_file *file);
/* Refuses a state of another scene, seed or setting than this one's by naming what differs. */
int checkpoint_check(const struct checkpoint_file *file, const struct part_label *label,
                     struct fewray_error *error);
/* For fewray_state_read(); user is the struct checkpoint_file. */
bool checkpoint_read(void *user, void *bytes, size_t size);

/* Fills program and layout. */
void checkpoint_info_init(struct checkpoint_info *info);

/* What writes itself by calls of write(). */
typedef bool (*checkpoint_body)(void *user,
                                bool (*write)(void *out, const void *bytes, size_t size),
                                void *out);
/* Replaces the file as a whole, safe against loss of power; on failure an older one stays. */
int checkpoint_write(const char *path, const struct checkpoint_info *info, checkpoint_body body,
                     void *user, struct fewray_error *error);

/* Makes a file that was renamed to path safe against loss of power, as far as the system can. */
void checkpoint_sync(const char *path);

#endif
