/* SPDX-License-Identifier: Apache-2.0 */
/* Renders a scene, 32 pixels wide, into an EXR: render SCENE.xml OUT.exr
 *     c++ render.cpp $(pkg-config --cflags --libs fewray) */
#include <cstdio>
#include <fewray/fewray.h>

int main(int argc, char **argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: render SCENE.xml OUT.exr\n");
        return 2;
    }
    fewray_job job;
    fewray_job_init(&job);
    job.scene_path = argv[1];
    job.outputs.exr = argv[2];
    job.settings.width = 32;
    fewray_run_stats stats;
    fewray_error error;
    if (fewray_job_run(&job, nullptr, &stats, &error)) {
        std::fprintf(stderr, "%s\n", error.what);
        return 1;
    }
    std::printf("fewray %s: %s, %d x %d pixels\n", fewray_version(), argv[2], stats.width,
                stats.height);
    return 0;
}
