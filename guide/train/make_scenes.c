/* SPDX-License-Identifier: Apache-2.0 */
/* fewray-make-scenes: random scenes to train on, the same from the same seed. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "guide/train/scenes/builders.h"
#include "guide/train/scenes/camera.h"
#include "guide/train/scenes/write_xml.h"

#define ATTEMPTS 40

struct options {
    unsigned long long seed;
    int first, count, width, height;
    const char *folder;
};

static const char usage[] =
    "usage: fewray-make-scenes -o DIR [--seed S] [--count N] [--first I] [--width W] [--height H]\n"
    "Writes DIR/0000.xml ... with a camera each; scene I depends on the seed and I alone.\n";

static bool parse(int argc, char **argv, struct options *options) {
    *options = (struct options){.seed = 1, .count = 1, .width = 256, .height = 160};
    for (int i = 1; i + 1 < argc; i += 2) {
        const char *name = argv[i], *value = argv[i + 1];
        char *end = NULL;
        long long number = strtoll(value, &end, 10);
        bool is_number = end != value && *end == 0 && number >= 0 && number < 1000000000;
        if (!strcmp(name, "-o"))
            options->folder = value;
        else if (!is_number)
            return false;
        else if (!strcmp(name, "--seed"))
            options->seed = (unsigned long long)number;
        else if (!strcmp(name, "--count"))
            options->count = (int)number;
        else if (!strcmp(name, "--first"))
            options->first = (int)number;
        else if (!strcmp(name, "--width"))
            options->width = (int)number;
        else if (!strcmp(name, "--height"))
            options->height = (int)number;
        else
            return false;
    }
    return argc % 2 == 1 && options->folder && options->width > 0 && options->height > 0;
}

/* A scene that a camera likes; false only where memory is short or luck is out. */
static bool build(struct stage *stage, const struct options *options, int index) {
    float aspect = (float)options->width / (float)options->height;
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        stage_init(stage, options->seed, (uint64_t)index, (uint64_t)attempt);
        if (stage->plan < ROOMS)
            build_room(stage);
        else if (stage->plan < 0.92f)
            build_outdoor(stage);
        else
            build_even_room(stage);
        if (!stage->failed && choose_camera(stage, aspect))
            return true;
        stage_clear(stage);
    }
    return false;
}

static int write_scene(const struct stage *stage, const struct options *options, int index,
                       struct fewray_error *error) {
    char path[4096], sky_path[4096], sky_name[32];
    snprintf(sky_name, sizeof sky_name, "%04d-sky.exr", index);
    int a = snprintf(path, sizeof path, "%s/%04d.xml", options->folder, index);
    int b = snprintf(sky_path, sizeof sky_path, "%s/%s", options->folder, sky_name);
    if (a >= (int)sizeof path || b >= (int)sizeof sky_path)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0, "the folder's name is too long");
    if (stage->sky.kind == SKY_MAP) {
        int status = sky_write(&stage->sky, sky_path, error);
        if (status < 0)
            return status;
    }
    return stage_write_xml(stage, options->width, options->height, path, sky_name, error);
}

int main(int argc, char **argv) {
    struct options options;
    if (!parse(argc, argv, &options)) {
        fputs(usage, stderr);
        return 2;
    }
    mkdir(options.folder, 0777);
    for (int i = options.first; i < options.first + options.count; i++) {
        struct stage stage;
        struct fewray_error error = {0};
        if (!build(&stage, &options, i)) {
            fprintf(stderr, "fewray-make-scenes: scene %d: no camera found, skipped\n", i);
            continue;
        }
        int status = write_scene(&stage, &options, i, &error);
        stage_clear(&stage);
        if (status < 0) {
            char text[1200];
            fprintf(stderr, "fewray-make-scenes: %s\n",
                    fewray_error_text(&error, text, sizeof text));
            return 1;
        }
    }
    return 0;
}
