/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_WORLD_H
#define FEWRAY_GUIDE_WORLD_H

/* A scene made ready for tracing: Embree's acceleration structure, light tables, environment
 * tables. */

#include "guide/scene/scene.h"
#include "guide/trace/embree.h"
#include "guide/trace/environment.h"
#include "guide/trace/lights.h"

struct fewray_world {
    const struct fewray_scene *scene;
    RTCDevice device;
    RTCScene embree; /* geometry id = index of the mesh */
    struct lights lights;
    struct environment_table environment;
};

#endif
