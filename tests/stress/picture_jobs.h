/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_PICTURE_JOBS_H
#define FEWRAY_TESTS_PICTURE_JOBS_H

/* Small pictures by every way to render, for tests that compare them. */

#include "tests/unit/check.h"

#include <stdio.h>

#include "fewray/pipeline.h"

struct picture {
    const char *name, *scene; /* in the examples' folder */
    int width, spp;
    void (*set)(struct fewray_job *job); /* NULL: guided and denoised */
};

static inline void picture_plain(struct fewray_job *job) {
    job->guided = job->denoised = false;
}
static inline void picture_parts(struct fewray_job *job) {
    job->settings.direct = job->settings.indirect = true;
}
static inline void picture_paper(struct fewray_job *job) {
    fewray_render_settings_paper(&job->settings);
}
static inline void picture_adaptive(struct fewray_job *job) {
    job->goal.adaptive = true;
}
static inline void picture_ppg(struct fewray_job *job) {
    job->ppg = true;
    job->denoised = false;
}
static inline void picture_fast(struct fewray_job *job) {
    job->denoise.model = FEWRAY_DENOISE_FAST;
}

/* Width without a multiple of a tile or a block; above 4 samples a pixel maps learn. None of
 * window-room, where the ceiling lies in the roof's lower face and the sill's top in the wall's:
 * which of two is hit is for each version of Embree to choose. From Embree 3 to 4 a block changes
 * by 0.04; by 0.000002 once both stand a millimetre apart. */
static const struct picture pictures[] = {
    {"plain, glossy", "glossy-still-life.xml", 44, 3, picture_plain},
    {"guided, denoised, learning, parts", "door-ajar.xml", 52, 6, picture_parts},
    {"guided, glossy, fast denoiser", "glossy-still-life.xml", 44, 4, picture_fast},
    {"paper's guide", "door-ajar.xml", 44, 3, picture_paper},
    {"adaptive", "cornell-box.xml", 36, 8, picture_adaptive},
    {"path guiding", "cornell-box.xml", 28, 12, picture_ppg},
};
enum { PICTURES = sizeof pictures / sizeof *pictures };

/* isa: the denoiser's; NULL: the best. The frame is the caller's. */
static inline struct fewray_frame *picture_render(const struct picture *p, int threads,
                                                  const char *isa) {
    char path[512];
    struct fewray_job job;
    struct fewray_frame *frame = NULL;
    struct fewray_error error = {.line = 0};
    snprintf(path, sizeof path, EXAMPLES "/%s", p->scene);
    fewray_job_init(&job);
    job.scene_path = path;
    job.pilot = false;
    job.settings.width = p->width;
    job.settings.spp = p->spp;
    job.settings.seed = 5;
    job.settings.threads = threads;
    job.denoise.isa = isa;
    if (p->set)
        p->set(&job);
    if (fewray_job_run(&job, &frame, NULL, &error))
        fail_msg("%s: %s:%d: %s", p->name, error.file, error.line, error.what);
    return frame;
}

#endif
