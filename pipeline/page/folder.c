/* SPDX-License-Identifier: Apache-2.0 */
/* What of a folder belongs on its page. */

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "pipeline/page/page.h"

int page_join(const char *folder, const char *name, char path[PAGE_PATH_MAX],
              struct fewray_error *error) {
    if (snprintf(path, PAGE_PATH_MAX, "%s/%s", folder, name) < PAGE_PATH_MAX)
        return FEWRAY_OK;
    return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, folder, 0, "the folder's name is too long");
}

static bool is_file(const char *path, struct stat *info) {
    return !stat(path, info) && S_ISREG(info->st_mode);
}

int page_read_json(const char *path, json_t **out, struct fewray_error *error) {
    struct stat info;
    json_error_t fault;
    *out = NULL;
    if (!is_file(path, &info))
        return FEWRAY_OK;
    *out = json_load_file(path, 0, &fault);
    if (json_is_object(*out))
        return FEWRAY_OK;
    const bool read = *out;
    json_decref(*out);
    *out = NULL;
    return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, !read && fault.line > 0 ? fault.line : 0,
                       "isn't a JSON object: %s", read ? "it is another value" : fault.text);
}

/* Hidden files are none of the user's pictures. */
static bool is_exr_name(const char *name) {
    const size_t length = strlen(name);
    return name[0] != '.' && length > 4 && !strcasecmp(name + length - 4, ".exr");
}

static bool same_file(const char *path, const char *other) {
    struct stat a, b;
    return other[0] && !stat(path, &a) && !stat(other, &b) && a.st_dev == b.st_dev &&
           a.st_ino == b.st_ino;
}

static int compare_names(const void *a, const void *b) {
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static int add_name(struct page_folder *folder, const char *path, const char *name,
                    struct fewray_error *error) {
    if (folder->count == PAGE_FILES_MAX)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, path, 0,
                           "holds more than %d EXR files; a page compares that many at most",
                           PAGE_FILES_MAX);
    char *copy = strdup(name);
    if (!copy)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for a file name");
    folder->names[folder->count++] = copy;
    return FEWRAY_OK;
}

static int list_pictures(const char *path, struct page_folder *folder, struct fewray_error *error) {
    char file[PAGE_PATH_MAX];
    struct stat info;
    int status = FEWRAY_OK;
    DIR *list = opendir(path);
    if (!list)
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "the folder can't be read: %s",
                           strerror(errno));
    for (const struct dirent *entry; !status && (entry = readdir(list));)
        if (is_exr_name(entry->d_name) && !(status = page_join(path, entry->d_name, file, error)) &&
            is_file(file, &info) && !same_file(file, folder->reference))
            status = add_name(folder, path, entry->d_name, error);
    closedir(list);
    qsort(folder->names, (size_t)folder->count, sizeof *folder->names, compare_names);
    return status;
}

/* Joins the name of a file that may be missing: path is empty where it is. */
static int find(const char *folder, const char *name, char path[PAGE_PATH_MAX],
                struct fewray_error *error) {
    struct stat info;
    const int status = page_join(folder, name, path, error);
    if (!status && !is_file(path, &info))
        path[0] = 0;
    return status;
}

int page_folder_read(const struct page_options *options, struct page_folder *folder,
                     struct fewray_error *error) {
    const char *path = options->folder;
    *folder = (struct page_folder){0};
    int status = find(path, "bench.json", folder->bench, error);
    if (!status)
        status = find(path, "reference.exr", folder->reference, error);
    if (!status && options->reference &&
        snprintf(folder->reference, PAGE_PATH_MAX, "%s", options->reference) >= PAGE_PATH_MAX)
        status =
            fewray_fail(error, FEWRAY_ERROR_ARGUMENT, options->reference, 0, "too long a name");
    if (!status)
        status = list_pictures(path, folder, error);
    if (!status && folder->count == 0 && !folder->bench[0])
        status =
            fewray_fail(error, FEWRAY_ERROR_ARGUMENT, path, 0,
                        "holds nothing to compare: no EXR beside the reference, no bench.json");
    return status;
}

void page_folder_release(struct page_folder *folder) {
    for (int i = 0; i < folder->count; i++)
        free(folder->names[i]);
    folder->count = 0;
}
