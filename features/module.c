/* SPDX-License-Identifier: Apache-2.0 */
/* Finds and opens modules. Nothing is kept here: dlopen() itself knows what is open. */
#include "features/module.h"

#include <dlfcn.h>
#include <limits.h>
#include <link.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The folder, without the last slash, of the program or shared library that holds this code; false
 * where it isn't known by an absolute path. */
static bool find_own_folder(char folder[PATH_MAX]) {
    Dl_info info;
    struct link_map *map = NULL;
    folder[0] = '\0';
    if (!dladdr1((void *)fewray_module_symbol, &info, (void **)&map, RTLD_DL_LINKMAP) || !map)
        return false;
    if (map->l_name[0]) { /* a library; its links may stand elsewhere than it */
        if (map->l_name[0] != '/' || !realpath(map->l_name, folder))
            folder[0] = '\0';
    } else { /* the program, whose l_name is empty and whose dli_fname is how it was called */
        const ssize_t length = readlink("/proc/self/exe", folder, PATH_MAX - 1);
        folder[length > 0 ? length : 0] = '\0';
    }
    char *slash = strrchr(folder, '/');
    if (folder[0] != '/' || !slash)
        return false;
    *slash = '\0';
    return true;
}

/* Opens folder/below/fewray_MODULE.so. *handle stays NULL where there is none; false where there is
 * one that can't be opened. */
static bool open_in(const char *folder, const char *below, const char *module, void **handle,
                    struct fewray_error *error) {
    char path[PATH_MAX];
    const int length = snprintf(path, sizeof path, "%s/%sfewray_%s.so", folder, below, module);
    if (folder[0] != '/' || length >= (int)sizeof path || access(path, R_OK))
        return true;
    *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (*handle)
        return true;
    const char *reason = dlerror();
    fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0, "the module can't be opened: %s",
                reason ? reason : "unknown reason");
    return false;
}

static void *open_module(const char *module, struct fewray_error *error) {
    char own[PATH_MAX];
    void *handle = NULL;
    const bool has_own = find_own_folder(own);
    const char *wish = secure_getenv("FEWRAY_MODULE_PATH");
    const struct {
        const char *folder, *below;
    } places[] = {
        {has_own ? own : "", ""},
        {has_own ? own : "", "fewray/"},
        {has_own ? own : "", FEWRAY_MODULE_FROM_BIN "/"},
        {FEWRAY_MODULE_FOLDER, ""},
        {wish ? wish : "", ""},
    };
    for (size_t i = 0; i < sizeof places / sizeof *places && !handle; i++)
        if (!open_in(places[i].folder, places[i].below, module, &handle, error))
            return NULL;
    if (!handle)
        fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, NULL, 0,
                    "the module fewray_%s.so is missing: put it beside the program or into %s, or "
                    "set FEWRAY_MODULE_PATH to its folder",
                    module, FEWRAY_MODULE_FOLDER);
    return handle;
}

void *fewray_module_symbol(const char *module, const char *symbol, struct fewray_error *error) {
    void *handle = open_module(module, error);
    if (!handle)
        return NULL;
    const char *version = dlsym(handle, "fewray_module_version");
    void *address = dlsym(handle, symbol);
    if (!version || strcmp(version, FEWRAY_VERSION) || !address) {
        fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, NULL, 0,
                    "the module fewray_%s.so is of version %.40s, not " FEWRAY_VERSION
                    ": install both together",
                    module, version ? version : "unknown");
        return NULL;
    }
    return address;
}
