/* SPDX-License-Identifier: Apache-2.0 */
/* Files for the fuzz targets, and what they check. */

#include "tests/fuzz/fuzz.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[64];

/* assimp loses a few hundred bytes where it gives a file up; its frames can't be told, but nobody
 * else calls this. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
    return "leak:operator new\n";
}

_Noreturn void fuzz_broken(const char *promise, const char *file, int line) {
    fprintf(stderr, "%s:%d: broken: %s\n", file, line, promise);
    abort();
}

static void remove_folder(void) {
    DIR *list = opendir(folder);
    struct dirent *entry;
    while (list && (entry = readdir(list)))
        if (entry->d_name[0] != '.')
            unlink(fuzz_path(entry->d_name));
    if (list)
        closedir(list);
    rmdir(folder);
}

static void make_folder(void) {
    if (folder[0])
        return;
    snprintf(folder, sizeof(folder), "%s/fewray-fuzz-XXXXXX",
             access("/dev/shm", W_OK) ? "/tmp" : "/dev/shm");
    FUZZ_CHECK(mkdtemp(folder));
    atexit(remove_folder);
}

const char *fuzz_path(const char *name) {
    static char paths[8][512];
    static int next;
    make_folder();
    char *path = paths[next++ % 8];
    snprintf(path, sizeof(paths[0]), "%s/%s", folder, name);
    return path;
}

const char *fuzz_file(const char *name, const void *data, size_t size) {
    const char *path = fuzz_path(name);
    FILE *file = fopen(path, "wb");
    FUZZ_CHECK(file);
    FUZZ_CHECK(fwrite(data, 1, size, file) == size);
    FUZZ_CHECK(fclose(file) == 0);
    return path;
}

/* The next line "@@ NAME\n" at or behind c, or the end; *name and *length are NAME's. */
static const char *find_mark(const char *c, const char *begin, const char *end, const char **name,
                             size_t *length) {
    for (; c + 3 < end; c++) {
        if (memcmp(c, "@@ ", 3) || (c > begin && c[-1] != '\n'))
            continue;
        const char *line_end = memchr(c, '\n', (size_t)(end - c));
        if (!line_end)
            return end;
        *name = c + 3;
        *length = (size_t)(line_end - *name);
        return c;
    }
    return end;
}

const char *fuzz_files(const uint8_t *data, size_t size, const char *first,
                       const char *const *names) {
    const char *begin = (const char *)data, *end = begin + size, *name = NULL, *next_name = NULL;
    size_t length = 0, next_length = 0;
    for (int i = 0; names[i]; i++)
        unlink(fuzz_path(names[i]));
    const char *c = find_mark(begin, begin, end, &name, &length);
    const char *path = fuzz_file(first, begin, (size_t)(c - begin));
    while (c < end) {
        const char *text = name + length + 1;
        const char *next = find_mark(text, begin, end, &next_name, &next_length);
        for (int i = 0; names[i]; i++)
            if (strlen(names[i]) == length && !memcmp(names[i], name, length))
                fuzz_file(names[i], text, (size_t)(next - text));
        c = next;
        name = next_name;
        length = next_length;
    }
    return path;
}

void fuzz_check_error(int status, const struct fewray_error *error) {
    FUZZ_CHECK(status <= 0);
    if (!status)
        return;
    FUZZ_CHECK(memchr(error->what, 0, sizeof(error->what)) && error->what[0]);
    FUZZ_CHECK(!strpbrk(error->what, "\r\n"));
    FUZZ_CHECK(memchr(error->file, 0, sizeof(error->file)));
    /* Without its module nothing would be tested. What files call their things comes with their
     * names. */
    FUZZ_CHECK(error->file[0] || strncmp(error->what, "the module fewray_", 18));
}

void fuzz_check_mesh(const struct mesh_data *mesh) {
    FUZZ_CHECK(mesh->triangle_count > 0);
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++)
        FUZZ_CHECK(mesh->indices[i] < mesh->vertex_count);
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++)
        FUZZ_CHECK(isfinite(mesh->positions[i]));
    float *normals = mesh_smooth_normals(mesh);
    free(normals);
}

static void check_scene_mesh(const struct fewray_scene *scene, const struct mesh *mesh) {
    FUZZ_CHECK(mesh->group >= -1 && mesh->group < scene->group_count);
    FUZZ_CHECK(mesh->bsdf >= 0 && mesh->bsdf < scene->bsdf_count);
    FUZZ_CHECK(mesh->emission >= -1 && mesh->emission < scene->texture_count);
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++)
        FUZZ_CHECK(mesh->indices[i] < mesh->vertex_count);
    for (size_t i = 0; mesh->positions && i < 3 * (size_t)mesh->vertex_count; i++)
        FUZZ_CHECK(isfinite(mesh->positions[i]));
    for (size_t i = 0; mesh->normals && i < 3 * (size_t)mesh->vertex_count; i++)
        FUZZ_CHECK(isfinite(mesh->normals[i]));
    for (size_t i = 0; mesh->uvs && i < 2 * (size_t)mesh->vertex_count; i++)
        FUZZ_CHECK(isfinite(mesh->uvs[i]));
}

static void check_scene(const struct fewray_scene *scene) {
    FUZZ_CHECK(scene->camera.width > 0 && scene->camera.height > 0);
    for (int i = 0; i < 12; i++)
        FUZZ_CHECK(isfinite(scene->camera.to_world[i]));
    for (int i = 0; i < scene->mesh_count; i++)
        check_scene_mesh(scene, &scene->meshes[i]);
    for (int i = 0; i < scene->instance_count; i++) {
        FUZZ_CHECK(scene->instances[i].group >= 0 &&
                   scene->instances[i].group < scene->group_count);
        for (int k = 0; k < 12; k++)
            FUZZ_CHECK(isfinite(scene->instances[i].to_world[k]));
    }
    for (int i = 0; i < scene->warning_count; i++)
        FUZZ_CHECK(!strpbrk(scene->warnings[i], "\r\n"));
}

int fuzz_load_scene(const char *path, const struct fewray_scene_options *options) {
    struct fewray_scene *scene = NULL;
    struct fewray_error error = {0};
    const int status = fewray_scene_load(path, options, &scene, &error);
    fuzz_check_error(status, &error);
    FUZZ_CHECK(!status == !!scene);
    if (scene)
        check_scene(scene);
    fewray_scene_destroy(&scene);
    return status;
}
