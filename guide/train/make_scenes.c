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
    bool mixed;
    const char *folder;
};

static const char usage[] =
    "usage: fewray-make-scenes -o DIR [--seed S] [--count N] [--first I] [--width W] [--height H]\n"
    "                          [--materials diffuse|mixed]\n"
    "Writes DIR/0000.xml ... with a camera each; scene I depends on the seed and I alone.\n";

static bool parse(int argc, char **argv, struct options *options) {
    *options = (struct options){.seed = 1, .count = 1, .width = 256, .height = 160, .mixed = true};
    for (int i = 1; i + 1 < argc; i += 2) {
        const char *name = argv[i], *value = argv[i + 1];
        char *end = NULL;
        long long number = strtoll(value, &end, 10);
        bool is_number = end != value && *end == 0 && number >= 0 && number < 1000000000;
        if (!strcmp(name, "-o"))
            options->folder = value;
        else if (!strcmp(name, "--materials") && !strcmp(value, "mixed"))
            options->mixed = true;
        else if (!strcmp(name, "--materials") && !strcmp(value, "diffuse"))
            options->mixed = false;
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
        stage->mixed = options->mixed;
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

/* DIR/FOLDER/PREFIX-K.SUFFIX, in a folder that is made for it. */
static void part_path(char path[4096], const struct options *options, const char *folder,
                      const char *prefix, int k, const char *suffix) {
    snprintf(path, 4096, "%s/%s", options->folder, folder);
    mkdir(path, 0777);
    snprintf(path, 4096, "%s/%s/%s-%d.%s", options->folder, folder, prefix, k, suffix);
}

static int write_parts(const struct stage *stage, const struct options *options, const char *prefix,
                       struct fewray_error *error) {
    char path[4096];
    int status = FEWRAY_OK;
    for (int i = 0; i < stage->picture_count && !status; i++) {
        part_path(path, options, "textures", prefix, i, "png");
        status = picture_write(&stage->pictures[i], path, error);
    }
    for (int i = 0; i < stage->mesh_count && !status; i++) {
        part_path(path, options, "meshes", prefix, i, "obj");
        status = mesh_write(stage->meshes[i], path, error);
    }
    return status;
}

static int write_scene(const struct stage *stage, const struct options *options, int index,
                       struct fewray_error *error) {
    char path[4096], prefix[24];
    if (strlen(options->folder) > sizeof path - 64)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0, "the folder's name is too long");
    snprintf(prefix, sizeof prefix, "%04d", index);
    int status = write_parts(stage, options, prefix, error);
    if (status == FEWRAY_OK && stage->sky.kind == SKY_MAP) {
        snprintf(path, sizeof path, "%s/%s-sky.exr", options->folder, prefix);
        status = sky_write(&stage->sky, path, error);
    }
    if (status < 0)
        return status;
    snprintf(path, sizeof path, "%s/%s.xml", options->folder, prefix);
    return stage_write_xml(stage, options->width, options->height, path, prefix, error);
}

/* The folder and those that it lies in; whoever writes into it tells where one couldn't be made. */
static void make_folders(const char *folder) {
    char path[4096];
    snprintf(path, sizeof path, "%s", folder);
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        mkdir(path, 0777);
        *slash = '/';
    }
    mkdir(folder, 0777);
}

int main(int argc, char **argv) {
    struct options options;
    if (!parse(argc, argv, &options)) {
        fputs(usage, stderr);
        return 2;
    }
    make_folders(options.folder);
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
