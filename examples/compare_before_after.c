/* SPDX-License-Identifier: Apache-2.0 */
/* What the guide and the denoiser bring: compare_before_after SCENE.xml OUT.png
 *
 * Renders the scene plain, guided and denoised, and as a reference with many samples; prints the
 * errors and draws the composite. */

#include <stdio.h>

#include "fewray/pipeline.h"

enum { WIDTH = 240, FEW = 4, MANY = 256 };

static int render(const char *scene, int spp, bool guided, bool denoised,
                  struct fewray_frame **picture, struct fewray_error *error) {
    struct fewray_job job;
    fewray_job_init(&job);
    job.scene_path = scene;
    job.settings.width = WIDTH;
    job.settings.spp = spp;
    job.settings.seed =
        (uint64_t)spp; /* the reference must not share its noise with the pictures */
    job.guided = guided;
    job.denoised = denoised;
    struct fewray_run_stats stats;
    const int status = fewray_job_run(&job, picture, &stats, error);
    if (!status)
        printf("%3d spp%s%s: %.2f s\n", spp, guided ? ", guided" : "", denoised ? ", denoised" : "",
               stats.total_s);
    return status;
}

static int compare(const char *scene, const char *png, struct fewray_error *error) {
    struct fewray_frame *before = NULL, *after = NULL, *reference = NULL;
    struct fewray_metrics plain, finished;
    int status;
    if (!(status = render(scene, FEW, false, false, &before, error)) &&
        !(status = render(scene, FEW, true, true, &after, error)) &&
        !(status = render(scene, MANY, true, false, &reference, error)) &&
        !(status = fewray_compare(before, reference, &plain, error)) &&
        !(status = fewray_compare(after, reference, &finished, error)) &&
        !(status = fewray_composite(before, after, reference, NULL, png, error)))
        printf("error (mrse) before %.4g, after %.4g: %.1f times less\n%s\n", plain.mrse,
               finished.mrse, plain.mrse / finished.mrse, png);
    fewray_frame_destroy(&before);
    fewray_frame_destroy(&after);
    fewray_frame_destroy(&reference);
    return status;
}

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: compare_before_after SCENE.xml OUT.png\n");
        return 2;
    }
    struct fewray_error error;
    if (compare(argv[1], argv[2], &error)) {
        char text[1024];
        fprintf(stderr, "%s\n", fewray_error_text(&error, text, sizeof text));
        return 1;
    }
    return 0;
}
