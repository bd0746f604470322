/* SPDX-License-Identifier: Apache-2.0 */
/* Builds and frees a world. */

#include "guide/trace/world.h"

#include <stdio.h>
#include <stdlib.h>

static void attach_mesh(RTCDevice device, RTCScene scene, const struct mesh *mesh, unsigned id) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh->positions, 0, 3 * sizeof(float), mesh->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->indices,
                               0, 3 * sizeof(uint32_t), mesh->triangle_count);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
}

int fewray_world_create(const struct fewray_scene *scene, int threads, struct fewray_world **out,
                        struct fewray_error *error) {
    *out = NULL;
    struct fewray_world *world = calloc(1, sizeof(*world));
    if (!world)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the world");
    world->scene = scene;
    char config[64];
    snprintf(config, sizeof(config), "threads=%d", threads > 0 ? threads : 0);
    world->device = rtcNewDevice(config);
    if (!world->device) {
        fewray_world_destroy(&world);
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, NULL, 0,
                           "Embree can't start on this machine (error %d)",
                           rtcGetDeviceError(NULL));
    }
    world->embree = rtcNewScene(world->device);
    rtcSetSceneBuildQuality(world->embree, RTC_BUILD_QUALITY_MEDIUM);
    rtcSetSceneFlags(world->embree, RTC_SCENE_FLAG_ROBUST);
    for (int m = 0; m < scene->mesh_count; m++)
        if (scene->meshes[m].triangle_count > 0)
            attach_mesh(world->device, world->embree, &scene->meshes[m], (unsigned)m);
    rtcCommitScene(world->embree);
    enum RTCError failure = rtcGetDeviceError(world->device);
    int status = FEWRAY_OK;
    if (failure != RTC_ERROR_NONE)
        status = fewray_fail(
            error, failure == RTC_ERROR_OUT_OF_MEMORY ? FEWRAY_ERROR_MEMORY : FEWRAY_ERROR_FORMAT,
            scene->path, 0, "Embree can't build the scene (error %d)", (int)failure);
    if (!status)
        status = environment_table_create(&scene->environment, &world->environment, error);
    if (!status)
        status = lights_create(scene, &world->environment, &world->lights, error);
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
    if ((*world)->embree)
        rtcReleaseScene((*world)->embree);
    if ((*world)->device)
        rtcReleaseDevice((*world)->device);
    free(*world);
    *world = NULL;
}
