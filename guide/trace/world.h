/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_WORLD_H
#define FEWRAY_GUIDE_WORLD_H

/* A scene made ready for tracing: Embree's acceleration structure, light tables, environment
 * tables. */

#include "guide/bsdf/bsdf_local.h"
#include "guide/light/environment.h"
#include "guide/light/lights.h"
#include "guide/scene/scene.h"
#include "guide/trace/embree.h"

struct fewray_world {
    const struct fewray_scene *scene;
    RTCDevice device;
    RTCScene embree;   /* geometry id = index of the mesh, or mesh_count + index of the instance */
    RTCScene emitters; /* the meshes that shine, with the same geometry ids: for rays that can only
                          find light */
    RTCScene *groups;  /* (group_count): what instances place; geometry id = index of the mesh */
    struct lights lights;
    struct environment_table environment;
    struct bsdf_table *bsdf_tables; /* (bsdf_count) */
    float unit; /* the lesser of 1 and the radius around all surfaces, scene units: what rays leave
                   surfaces by is measured by it */
};

/* A box around all surfaces, those of instances included; low > high where there are none. */
void world_bounds(const struct fewray_world *world, struct vec3 *low, struct vec3 *high);

#endif
