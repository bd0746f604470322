/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_CHECKPOINT_JOB_H
#define FEWRAY_TESTS_CHECKPOINT_JOB_H

/* Small renders that can be stopped at any tile, for the tests of checkpoints. */

#include "scene_scratch.h"

#include "features/cancel.h"
#include "fewray/pipeline.h"

#define SCENE EXAMPLES "/cornell-box.xml"

/* 2 x 2 tiles (one whole, three cut), 20 samples a pixel: a look of 1, passes up to 4, 16 and 20
 * samples; where guided, maps and probes are made anew after 4 and 16. */
enum { WIDTH = 18, HEIGHT = 17, TILES = 4, SPP = 20, GUIDED_TILES = 4 * TILES };

/* Ends a run while it is in one of its phases. */
struct stopper {
    const char *phase; /* NULL: the tiles of the look and of the rest */
    int calls;         /* of that phase's progress until the end */
    volatile int cancel;
    int notes;
    char note[700]; /* the last one */
};

static inline void stop_at(void *user, const char *phase, double part) {
    struct stopper *stopper = user;
    const bool tile = part > 0 && (!strcmp(phase, "render") || !strcmp(phase, "first look"));
    if ((stopper->phase ? !strcmp(phase, stopper->phase) : tile) && --stopper->calls == 0)
        cancel_set(&stopper->cancel);
}

static inline void take_note(void *user, const char *text) {
    struct stopper *stopper = user;
    stopper->notes++;
    snprintf(stopper->note, sizeof stopper->note, "%s", text);
}

/* As scratch_path(), but valid for good: jobs hold it. */
static inline const char *scratch_name(const char *name) {
    static char names[16][256];
    int k = 0;
    while (k < 15 && names[k][0] && strcmp(strrchr(names[k], '/') + 1, name))
        k++;
    snprintf(names[k], sizeof *names, "%s/%s", scratch_folder, name);
    return names[k];
}

/* exr: what it leaves; its checkpoint is checkpoint, NULL: none. */
static inline struct fewray_job small_job(const char *exr, const char *checkpoint) {
    struct fewray_job job;
    fewray_job_init(&job);
    job.scene_path = SCENE;
    job.settings.width = WIDTH;
    job.settings.height = HEIGHT;
    job.settings.spp = SPP;
    job.settings.seed = 7;
    job.settings.threads = 3;
    job.pilot = false;
    job.denoised = false;
    job.outputs.exr = exr;
    job.outputs.float32 = true;
    job.checkpoint = checkpoint;
    return job;
}

/* Runs the job until the stopper ends it, or to its end. */
static inline int run_until(struct fewray_job job, struct stopper *stopper,
                            struct fewray_run_stats *stats, struct fewray_error *error) {
    job.settings.progress = stop_at;
    job.settings.progress_user = stopper;
    job.settings.cancel = &stopper->cancel;
    job.note = take_note;
    job.note_user = stopper;
    return fewray_job_run(&job, NULL, stats, error);
}

static inline bool exists(const char *path) {
    return access(path, F_OK) == 0;
}

static inline void copy_file(const char *from, const char *to) {
    char bytes[65536];
    FILE *in = fopen(from, "rb"), *out = fopen(to, "wb");
    assert_true(in && out);
    for (size_t got; (got = fread(bytes, 1, sizeof bytes, in)) > 0;)
        assert_int_equal(fwrite(bytes, 1, got, out), got);
    fclose(in);
    assert_int_equal(fclose(out), 0);
}

#endif
