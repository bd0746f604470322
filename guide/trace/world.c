/* SPDX-License-Identifier: Apache-2.0 */
/* Builds and frees a world. */

#include "guide/trace/world.h"

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "guide/trace/spare_threads.h"
#include "guide/trace/sphere.h"

/* --- Embree's scenes. What fails leaves an error in the device, which is asked at the end. */

static void attach(RTCScene scene, RTCGeometry geometry, unsigned id) {
    if (!geometry)
        return;
    embree.rtcCommitGeometry(geometry);
    embree.rtcAttachGeometryByID(scene, geometry, id);
    embree.rtcReleaseGeometry(geometry);
}

static RTCGeometry triangle_geometry(RTCDevice device, const struct mesh *mesh) {
    RTCGeometry geometry = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry)
        return NULL;
    embree.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                      mesh->positions, 0, 3 * sizeof(float), mesh->vertex_count);
    embree.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                      mesh->indices, 0, 3 * sizeof(uint32_t), mesh->triangle_count);
    return geometry;
}

static void attach_mesh(RTCDevice device, RTCScene scene, const struct mesh *mesh, unsigned id) {
    if (mesh->kind == MESH_SPHERE)
        attach(scene, sphere_geometry(device, mesh), id);
    else if (mesh->triangle_count > 0)
        attach(scene, triangle_geometry(device, mesh), id);
}

static void attach_instance(const struct fewray_world *world, const struct instance *instance,
                            unsigned id) {
    RTCGeometry geometry = embree.rtcNewGeometry(world->device, RTC_GEOMETRY_TYPE_INSTANCE);
    if (!geometry)
        return;
    embree.rtcSetGeometryInstancedScene(geometry, world->groups[instance->group]);
    embree.rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, instance->to_world);
    attach(world->embree, geometry, id);
}

static RTCScene new_scene(RTCDevice device) {
    RTCScene scene = embree.rtcNewScene(device);
    if (scene) {
        embree.rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
        embree.rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    }
    return scene;
}

/* False where a scene couldn't be made. */
static bool build_scenes(struct fewray_world *world) {
    const struct fewray_scene *scene = world->scene;
    world->embree = new_scene(world->device);
    world->emitters = new_scene(world->device);
    bool made = world->embree && world->emitters;
    for (int g = 0; g < scene->group_count; g++) {
        world->groups[g] = new_scene(world->device);
        made = made && world->groups[g];
    }
    if (!made)
        return false;
    for (int m = 0; m < scene->mesh_count; m++) {
        const struct mesh *mesh = &scene->meshes[m];
        attach_mesh(world->device, mesh->group < 0 ? world->embree : world->groups[mesh->group],
                    mesh, (unsigned)m);
        if (mesh->emission >= 0)
            attach_mesh(world->device, world->emitters, mesh, (unsigned)m);
    }
    for (int g = 0; g < scene->group_count; g++)
        embree.rtcCommitScene(world->groups[g]);
    for (int i = 0; i < scene->instance_count; i++)
        attach_instance(world, &scene->instances[i], (unsigned)(scene->mesh_count + i));
    embree.rtcCommitScene(world->emitters);
    embree.rtcCommitScene(world->embree);
    return true;
}

static int build_embree(struct fewray_world *world, int threads, struct fewray_error *error) {
    char config[64];
    int status = embree_load(error);
    if (status)
        return status;
    /* Its scheduler ends the process where it doesn't get its threads; one it always takes. */
    const int all = threads > 0 ? threads : omp_get_num_procs();
    const int wanted = all > 1 ? all - 1 : 1;
    const int helpers = wanted < SPARE_THREADS_MAX ? wanted : SPARE_THREADS_MAX;
    const int spare = spare_threads(helpers);
    if (spare < 1)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, NULL, 0,
                           "the system starts no more threads, and Embree needs one; raise the "
                           "limit of processes");
    if (spare < helpers)
        threads = 1;
    snprintf(config, sizeof(config), "threads=%d", threads > 0 ? threads : 0);
    world->device = embree.rtcNewDevice(config);
    if (!world->device)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, NULL, 0,
                           "Embree can't start on this machine (error %d)",
                           embree.rtcGetDeviceError(NULL));
    world->groups = calloc((size_t)world->scene->group_count + 1, sizeof(RTCScene));
    if (!world->groups)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the world");
    bool built = build_scenes(world);
    enum RTCError failure = embree.rtcGetDeviceError(world->device);
    if (built && failure == RTC_ERROR_NONE)
        return FEWRAY_OK;
    return fewray_fail(
        error, failure == RTC_ERROR_OUT_OF_MEMORY ? FEWRAY_ERROR_MEMORY : FEWRAY_ERROR_FORMAT,
        world->scene->path, 0, "Embree can't build the scene (error %d)", (int)failure);
}

void world_bounds(const struct fewray_world *world, struct vec3 *low, struct vec3 *high) {
    struct RTCBounds box;
    embree.rtcGetSceneBounds(world->embree, &box);
    *low = vec(box.lower_x, box.lower_y, box.lower_z);
    *high = vec(box.upper_x, box.upper_y, box.upper_z);
}

static double world_radius(const struct fewray_world *world) {
    struct vec3 low, high;
    world_bounds(world, &low, &high);
    return low.x <= high.x ? 0.5 * length(sub(high, low)) : 1;
}

int fewray_world_create(const struct fewray_scene *scene, int threads, struct fewray_world **out,
                        struct fewray_error *error) {
    *out = NULL;
    struct fewray_world *world = calloc(1, sizeof(*world));
    if (!world)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the world");
    world->scene = scene;
    int status = build_embree(world, threads, error);
    if (!status)
        status = environment_table_create(&scene->environment, &world->environment, error);
    double radius = status ? 1 : world_radius(world);
    world->unit = (float)fmin(radius, 1);
    if (!status)
        status = lights_create(scene, &world->environment, radius, &world->lights, error);
    world->bsdf_tables = calloc((size_t)scene->bsdf_count + 1, sizeof(*world->bsdf_tables));
    if (!world->bsdf_tables && !status)
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the materials");
    if (!status) {
        int workers = threads > 0 ? threads : omp_get_max_threads();
#pragma omp parallel for schedule(dynamic) num_threads(workers)
        for (int b = 0; b < scene->bsdf_count; b++)
            bsdf_table_fill(scene, &scene->bsdfs[b], &world->bsdf_tables[b]);
    }
    if (status) {
        fewray_world_destroy(&world);
        return status;
    }
    *out = world;
    return FEWRAY_OK;
}

void fewray_world_destroy(struct fewray_world **world) {
    if (!*world)
        return;
    lights_clear(&(*world)->lights);
    environment_table_clear(&(*world)->environment);
    free((*world)->bsdf_tables);
    if ((*world)->embree)
        embree.rtcReleaseScene((*world)->embree);
    if ((*world)->emitters)
        embree.rtcReleaseScene((*world)->emitters);
    for (int g = 0; (*world)->groups && g < (*world)->scene->group_count; g++)
        if ((*world)->groups[g])
            embree.rtcReleaseScene((*world)->groups[g]);
    free((*world)->groups);
    if ((*world)->device)
        embree.rtcReleaseDevice((*world)->device);
    free(*world);
    *world = NULL;
}
