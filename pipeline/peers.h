/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_PEERS_H
#define FEWRAY_PIPELINE_PEERS_H

/* Other renderers and denoisers, run by a Python that has them: Mitsuba 3 and Open Image Denoise.
 * The script pipeline/peers.py is part of the command. It stays open with its scene loaded and its
 * kernels compiled, and works only when it is asked, so that nothing disturbs what is timed. */

#include "fewray/features.h"

struct peers;

struct peers_settings {
    const char *python; /* program, looked for in PATH where it has no slash */
    const char *scene_path;
    const char *const *defines; /* "name=value" */
    int define_count;
    int width, height, max_depth; /* 0: the scene's own depth; -1: no limit */
    int threads;
    const volatile int *cancel; /* NULL */
};

/* What the peers told about themselves. */
struct peers_info {
    char names[256];          /* "Mitsuba 3.9.1 llvm_ad_rgb, OIDN 2.5.1" */
    bool oidn;                /* else there is Mitsuba alone */
    double load_s, compile_s; /* of the scene, of the kernels */
};

/* Starts Python and waits until the scene is loaded. On failure the error tells in one line what is
 * missing; FEWRAY_ERROR_CANCELLED where cancel was set. *out is owned by the caller. */
int peers_open(const struct peers_settings *settings, struct peers **out, struct peers_info *info,
               struct fewray_error *error);
/* Ends Python. */
void peers_close(struct peers **peers);

/* Mitsuba's picture (R, G, B; with features also albedo and normal, by its aov integrator) and the
 * seconds of its rendering. picture may be NULL: only seconds are wanted. *picture is owned by the
 * caller. */
int peers_render(struct peers *peers, int spp, int seed, bool features,
                 struct fewray_frame **picture, double *seconds, struct fewray_error *error);
/* The frame's R, G, B with its albedo and normal through Open Image Denoise (high quality), and the
 * seconds of its filter's execution. *picture is owned by the caller. */
int peers_denoise(struct peers *peers, const struct fewray_frame *frame,
                  struct fewray_frame **picture, double *seconds, struct fewray_error *error);

#endif
