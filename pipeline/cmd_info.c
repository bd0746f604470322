/* SPDX-License-Identifier: Apache-2.0 */
/* fewray info: what a scene or an EXR holds. */

#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "fewray/pipeline.h"
#include "pipeline/command.h"
#include "pipeline/info_exr.h"
#include "pipeline/options.h"

static bool is_exr(const char *path) {
    static const unsigned char magic[4] = {0x76, 0x2f, 0x31, 0x01};
    unsigned char start[4];
    const char *dot = strrchr(path, '.');
    if (dot && !strcasecmp(dot, ".exr"))
        return true;
    struct stat info;
    FILE *file = stat(path, &info) || S_ISREG(info.st_mode) ? fopen(path, "rb") : NULL;
    const bool same = file && fread(start, 1, 4, file) == 4 && !memcmp(start, magic, 4);
    if (file)
        fclose(file);
    return same;
}

static int info_scene(const char *path, const struct text_list *defines, bool lenient,
                      struct fewray_error *error) {
    const struct fewray_scene_options options = {
        .defines = defines->items, .define_count = defines->count, .lenient = lenient};
    struct fewray_scene *scene;
    const int status = fewray_scene_load(path, &options, &scene, error);
    if (status)
        return status;
    const struct fewray_scene_summary summary = fewray_scene_summarize(scene);
    printf("%s: scene\n", path);
    printf("  %-14s %dx%d pixels, %d spp\n", "film", summary.width, summary.height,
           summary.sample_count);
    if (summary.max_depth < 0)
        printf("  %-14s no limit\n", "max_depth");
    else
        printf("  %-14s %d\n", "max_depth", summary.max_depth);
    printf("  %-14s %d, %lld triangles\n", "meshes", summary.meshes, summary.triangles);
    printf("  %-14s %d\n", "materials", summary.materials);
    printf("  %-14s %d\n", "textures", summary.textures);
    printf("  %-14s %d\n", "emitters", summary.emitters);
    for (int i = 0; i < summary.warning_count; i++)
        printf("  %-14s %s\n", "warning", summary.warnings[i]);
    fewray_scene_destroy(&scene);
    return FEWRAY_OK;
}

int cmd_info(int argc, char **argv) {
    struct text_list defines = {.count = 0};
    bool lenient = false, as_json = false;
    const struct option_spec specs[] = {
        {"define", 'D', OPTION_DEFINE, &defines, "NAME=VALUE", "for $NAME in the scene", 0, 0,
         NULL},
        {"json", 0, OPTION_FLAG, &as_json, NULL, "of an EXR, as JSON", 0, 0, NULL},
        {"lenient", 0, OPTION_FLAG, &lenient, NULL, LENIENT_HELP, 0, 0, NULL},
        {0},
    };
    const struct command_line line = {"info",
                                      "SCENE|FILE.exr [options]",
                                      "Prints what a scene holds; of an EXR its size, channels and "
                                      "metadata, and what `fewray denoise` "
                                      "takes its layers from.",
                                      specs,
                                      1,
                                      1};
    int first_file;
    const enum parse_result parsed = parse_command_line(&line, argc, argv, &first_file);
    if (parsed != PARSE_OK)
        return parsed == PARSE_HELP ? EXIT_DONE : EXIT_WRONG_COMMAND_LINE;
    const char *path = argv[first_file];
    struct fewray_error error;
    const int status = is_exr(path) ? info_exr(path, as_json, &error)
                                    : info_scene(path, &defines, lenient, &error);
    return status ? report_failure(&error) : EXIT_DONE;
}
