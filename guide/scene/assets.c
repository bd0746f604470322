/* SPDX-License-Identifier: Apache-2.0 */
/* The files that a scene refers to. */

#include "guide/scene/assets.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "guide/scene/loader.h"
#include "guide/scene/memory.h"

/* FNV-1a. */
static uint32_t hash_text(const char *text) {
    uint32_t hash = 2166136261u;
    for (; *text; text++)
        hash = (hash ^ (unsigned char)*text) * 16777619u;
    return hash;
}

int assets_add(struct loader *loader, enum asset_kind kind, const char *filename,
               const struct xml_node *node, int *index) {
    return assets_add_part(loader, kind, filename, 0, node, index);
}

int assets_add_part(struct loader *loader, enum asset_kind kind, const char *filename, int part,
                    const struct xml_node *node, int *index) {
    struct assets *assets = &loader->assets;
    char *path = loader_find_file(loader, filename);
    if (!path || !array_reserve((void **)&assets->items, &assets->capacity, assets->count + 1,
                                sizeof(*assets->items))) {
        free(path);
        return loader_fail_memory(loader);
    }
    uint32_t hash = hash_text(path);
    for (size_t i = 0; i < assets->count; i++) {
        struct asset *item = &assets->items[i];
        if (item->path_hash == hash && item->kind == kind && item->part == part &&
            !strcmp(item->path, path)) {
            free(path);
            item->users++;
            *index = (int)i;
            return FEWRAY_OK;
        }
    }
    *index = (int)assets->count;
    assets->items[assets->count++] = (struct asset){
        .kind = kind, .part = part, .path = path, .path_hash = hash, .node = node, .users = 1};
    return FEWRAY_OK;
}

static int read_asset(struct asset *asset) {
    if (asset->kind == ASSET_OBJ)
        return mesh_read_obj(asset->path, &asset->mesh, &asset->error);
    if (asset->kind == ASSET_PLY)
        return mesh_read_ply(asset->path, &asset->mesh, &asset->error);
    if (asset->kind == ASSET_SERIALIZED)
        return mesh_read_serialized(asset->path, asset->part, &asset->mesh, &asset->error);
    if (access(asset->path, R_OK))
        return fewray_fail(&asset->error, FEWRAY_ERROR_IO, asset->path, 0,
                           "can't read the file: %s", strerror(errno));
    int status = fewray_image_read(asset->path, &asset->image, &asset->error);
    if (!status && !asset_convert_image(asset))
        status = fewray_fail(&asset->error, FEWRAY_ERROR_MEMORY, asset->path, 0, "out of memory");
    return status;
}

struct job {
    size_t index;
    long long size;
};

static int compare_jobs(const void *a, const void *b) {
    const struct job *x = a, *y = b;
    return (x->size < y->size) - (x->size > y->size);
}

/* The files with the largest first, so that no thread starts a long one when the others are done.
 */
static struct job *plan_jobs(const struct assets *assets) {
    struct job *jobs = malloc((assets->count + 1) * sizeof(*jobs));
    for (size_t i = 0; jobs && i < assets->count; i++) {
        struct stat info;
        bool image = assets->items[i].kind >= ASSET_COLOR_IMAGE;
        jobs[i].index = i;
        /* A compressed byte takes about ten times as long as a mesh's. */
        jobs[i].size = stat(assets->items[i].path, &info) ? 0 : info.st_size * (image ? 10LL : 1);
    }
    if (jobs)
        qsort(jobs, assets->count, sizeof(*jobs), compare_jobs);
    return jobs;
}

/* The asset's failure, with the place in the scene that names the file. */
static int report_failure(struct loader *loader, const struct asset *asset) {
    const struct fewray_error *error = &asset->error;
    const char *scene = asset->node->file ? asset->node->file : loader->path;
    const char *slash = strrchr(scene, '/');
    if (asset->status == FEWRAY_ERROR_IO)
        return loader_fail(loader, FEWRAY_ERROR_IO, asset->node, "%s: %.400s", asset->path,
                           error->what);
    return fewray_fail(loader->error, asset->status, error->file[0] ? error->file : asset->path,
                       error->line, "%.400s (named in %s:%d)", error->what,
                       slash ? slash + 1 : scene, asset->node->line);
}

int assets_read(struct loader *loader) {
    struct assets *assets = &loader->assets;
    struct job *jobs = plan_jobs(assets);
    if (!jobs)
        return loader_fail_memory(loader);
#pragma omp parallel for schedule(dynamic, 1) num_threads(loader->threads)
    for (size_t i = 0; i < assets->count; i++) {
        struct asset *asset = &assets->items[jobs[i].index];
        asset->status = read_asset(asset);
    }
    free(jobs);
    for (size_t i = 0; i < assets->count; i++) {
        const struct asset *asset = &assets->items[i];
        if (asset->status)
            return report_failure(loader, asset);
        int status = asset->mended
                         ? loader_warn(loader, asset->node,
                                       "%s: %zu values were NaN, infinite or negative: taken as 0",
                                       asset->path, asset->mended)
                         : FEWRAY_OK;
        if (status)
            return status;
    }
    return FEWRAY_OK;
}

void assets_free(struct assets *assets) {
    for (size_t i = 0; i < assets->count; i++) {
        free(assets->items[i].path);
        mesh_data_free(&assets->items[i].mesh);
        fewray_image_destroy(&assets->items[i].image);
    }
    free(assets->items);
    *assets = (struct assets){0};
}
