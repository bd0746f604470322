/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_EMBREE_H
#define FEWRAY_GUIDE_EMBREE_H

/* Embree as the module "embree" (features/module.h), so that a run without a scene doesn't load it
 * and its libraries; and the few calls that differ between Embree 3 and 4. */

#include <math.h>
#include <stdbool.h>

#include "fewray/features.h"
#include "guide/vec.h"

#if FEWRAY_EMBREE >= 4
#include <embree4/rtcore.h>
#elif FEWRAY_EMBREE == 3
#include <embree3/rtcore.h>
#else
#error "FEWRAY_EMBREE, the version's first number, comes with the target fewray_guide"
#endif

/* All functions of Embree that are called; another one is added here alone. */
#define EMBREE_FUNCTIONS(FUNCTION)                                                                 \
    FUNCTION(rtcNewDevice)                                                                         \
    FUNCTION(rtcReleaseDevice)                                                                     \
    FUNCTION(rtcGetDeviceError)                                                                    \
    FUNCTION(rtcNewScene)                                                                          \
    FUNCTION(rtcReleaseScene)                                                                      \
    FUNCTION(rtcSetSceneBuildQuality)                                                              \
    FUNCTION(rtcSetSceneFlags)                                                                     \
    FUNCTION(rtcCommitScene)                                                                       \
    FUNCTION(rtcGetSceneBounds)                                                                    \
    FUNCTION(rtcNewGeometry)                                                                       \
    FUNCTION(rtcReleaseGeometry)                                                                   \
    FUNCTION(rtcCommitGeometry)                                                                    \
    FUNCTION(rtcAttachGeometryByID)                                                                \
    FUNCTION(rtcSetSharedGeometryBuffer)                                                           \
    FUNCTION(rtcSetGeometryInstancedScene)                                                         \
    FUNCTION(rtcSetGeometryTransform)                                                              \
    FUNCTION(rtcSetGeometryUserPrimitiveCount)                                                     \
    FUNCTION(rtcSetGeometryUserData)                                                               \
    FUNCTION(rtcSetGeometryBoundsFunction)                                                         \
    FUNCTION(rtcSetGeometryIntersectFunction)                                                      \
    FUNCTION(rtcSetGeometryOccludedFunction)                                                       \
    FUNCTION(rtcIntersect1)                                                                        \
    FUNCTION(rtcOccluded1)                                                                         \
    FUNCTION(rtcIntersect16)                                                                       \
    FUNCTION(rtcOccluded16)

#define EMBREE_POINTER(name) __typeof__(name) *name;
struct embree_functions {
    EMBREE_FUNCTIONS(EMBREE_POINTER)
};
#undef EMBREE_POINTER

/* Filled by embree_load(), never changed after: calls cost what the linker's own table costs. */
extern struct embree_functions embree;

/* Opens the module where it isn't yet. Thread-safe. */
int embree_load(struct fewray_error *error);

static inline struct RTCRay embree_ray(struct vec3 origin, struct vec3 direction, float t_max) {
    return (struct RTCRay){.org_x = origin.x,
                           .org_y = origin.y,
                           .org_z = origin.z,
                           .tnear = 0,
                           .dir_x = direction.x,
                           .dir_y = direction.y,
                           .dir_z = direction.z,
                           .tfar = t_max,
                           .mask = ~0u};
}

/* Embree's debug checks abort on coordinates beyond this, or NaN. */
#define EMBREE_COORDINATE_MAX 1.844e18f

/* False of a ray that is so far away that nothing can be on it. */
static inline bool embree_valid(const struct RTCRay *ray) {
    /* A sum keeps a NaN, which no comparison holds for. */
    float size = fabsf(ray->org_x) + fabsf(ray->org_y) + fabsf(ray->org_z) + fabsf(ray->dir_x) +
                 fabsf(ray->dir_y) + fabsf(ray->dir_z);
    return size <= EMBREE_COORDINATE_MAX;
}

static inline void embree_intersect(RTCScene scene, struct RTCRayHit *ray_hit, bool coherent) {
    ray_hit->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    ray_hit->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    if (!embree_valid(&ray_hit->ray))
        return;
#if FEWRAY_EMBREE >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    embree.rtcIntersect1(scene, ray_hit, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    embree.rtcIntersect1(scene, &context, ray_hit);
#endif
}

static inline bool embree_occluded(RTCScene scene, struct vec3 origin, struct vec3 direction,
                                   float t_max) {
    struct RTCRay ray = embree_ray(origin, direction, t_max);
    if (!embree_valid(&ray))
        return true;
#if FEWRAY_EMBREE >= 4
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    embree.rtcOccluded1(scene, &ray, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    embree.rtcOccluded1(scene, &context, &ray);
#endif
    return ray.tfar < 0;
}

/* --- packets of 16 rays; active: -1, or 0 where there is none. Those too far away are no hits, or
 * blocked. */

static inline void embree_leave_valid(const int active[16], const struct RTCRay16 *ray,
                                      int valid[16]) {
    for (int i = 0; i < 16; i++) {
        float size = fabsf(ray->org_x[i]) + fabsf(ray->org_y[i]) + fabsf(ray->org_z[i]) +
                     fabsf(ray->dir_x[i]) + fabsf(ray->dir_y[i]) + fabsf(ray->dir_z[i]);
        valid[i] = size <= EMBREE_COORDINATE_MAX ? active[i] : 0;
    }
}

static inline void embree_intersect16(RTCScene scene, const int active[16],
                                      struct RTCRayHit16 *rays, bool coherent) {
    int valid[16] __attribute__((aligned(64)));
    embree_leave_valid(active, &rays->ray, valid);
    for (int i = 0; i < 16; i++) {
        rays->hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        rays->hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
#if FEWRAY_EMBREE >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    embree.rtcIntersect16(valid, scene, rays, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    embree.rtcIntersect16(valid, scene, &context, rays);
#endif
}

/* Sets tfar of the blocked ones below 0. */
static inline void embree_occluded16(RTCScene scene, const int active[16], struct RTCRay16 *rays) {
    int valid[16] __attribute__((aligned(64)));
    embree_leave_valid(active, rays, valid);
#if FEWRAY_EMBREE >= 4
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    embree.rtcOccluded16(valid, scene, rays, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    embree.rtcOccluded16(valid, scene, &context, rays);
#endif
    for (int i = 0; i < 16; i++)
        rays->tfar[i] = active[i] && !valid[i] ? -INFINITY : rays->tfar[i];
}

#endif
