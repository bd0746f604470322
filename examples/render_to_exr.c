/* SPDX-License-Identifier: Apache-2.0 */
/* From a scene to a finished picture: render_to_exr SCENE.xml OUT.exr [SPP] */

#include <stdio.h>
#include <stdlib.h>

#include "fewray/pipeline.h"

static void print_progress(void *user, const char *phase, double fraction) {
    (void)user;
    fprintf(stderr, "\r%-8s %3.0f %%", phase, 100 * fraction);
}

int main(int argc, char **argv) {
    if (argc < 3) {
        fprintf(stderr, "usage: render_to_exr SCENE.xml OUT.exr [SPP]\n");
        return 2;
    }
    struct fewray_job job;
    fewray_job_init(&job);
    job.scene_path = argv[1];
    job.outputs.exr = argv[2];
    job.settings.progress = print_progress;
    if (argc > 3)
        job.settings.spp = atoi(argv[3]);

    struct fewray_run_stats stats;
    struct fewray_error error;
    if (fewray_job_run(&job, NULL, &stats, &error)) {
        char text[1024];
        fprintf(stderr, "\n%s\n", fewray_error_text(&error, text, sizeof text));
        return 1;
    }
    printf("\r%s: %dx%d, %d spp, %.2f s\n", argv[2], stats.width, stats.height, stats.spp,
           stats.total_s);
    return 0;
}
