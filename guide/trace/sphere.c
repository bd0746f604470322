/* SPDX-License-Identifier: Apache-2.0 */
/* Analytic spheres: as a user geometry of Embree, and what a hit on one looks like. Embree's own
 * sphere points work in floats, which lets grazing rays hit the large sphere that they leave. */

#include "guide/trace/sphere.h"

#include <stddef.h>

static void find_bounds(const struct RTCBoundsFunctionArguments *arguments) {
    const struct mesh *mesh = arguments->geometryUserPtr;
    const float *s = mesh->sphere;
    struct RTCBounds *box = arguments->bounds_o;
    float low[3], high[3];
    for (int i = 0; i < 3; i++) {
        /* Rounded outwards. */
        low[i] = nextafterf((float)((double)s[i] - s[3]), -INFINITY);
        high[i] = nextafterf((float)((double)s[i] + s[3]), INFINITY);
    }
    *box = (struct RTCBounds){.lower_x = low[0],
                              .lower_y = low[1],
                              .lower_z = low[2],
                              .upper_x = high[0],
                              .upper_y = high[1],
                              .upper_z = high[2]};
}

/* The nearest hit in [tnear, tfar]; *outward leads from the centre to it. The discriminant is
 * r^2 - the squared distance of the centre from the ray: Haines et al., "Precision Improvements for
 * Ray/Sphere Intersection", Ray Tracing Gems, 2019. */
static bool hit(const struct mesh *mesh, const struct RTCRay *ray, double *t, double outward[3]) {
    const double o[3] = {(double)ray->org_x - mesh->sphere[0], (double)ray->org_y - mesh->sphere[1],
                         (double)ray->org_z - mesh->sphere[2]};
    const double d[3] = {ray->dir_x, ray->dir_y, ray->dir_z};
    double a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    double middle = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]) / a, r = mesh->sphere[3];
    double discriminant = r * r;
    for (int i = 0; i < 3; i++) {
        double closest = o[i] + middle * d[i];
        discriminant -= closest * closest;
    }
    if (!(discriminant >= 0 && a > 0))
        return false;
    double half = sqrt(discriminant / a);
    *t = middle - half >= ray->tnear ? middle - half : middle + half;
    if (!(*t >= ray->tnear && *t <= ray->tfar))
        return false;
    for (int i = 0; i < 3; i++)
        outward[i] = o[i] + *t * d[i];
    return true;
}

/* Member of ray i in a packet of n, whose arrays follow each other as the members of one ray do
 * (Embree's own accessors are C++). */
#define PACKET(type, packet, member)                                                               \
    (((type *)(packet))[offsetof(struct RTCRayHit, member) / sizeof(float) * n + i])

static struct RTCRay packet_ray(void *packet, unsigned n, unsigned i) {
    return (struct RTCRay){.org_x = PACKET(float, packet, ray.org_x),
                           .org_y = PACKET(float, packet, ray.org_y),
                           .org_z = PACKET(float, packet, ray.org_z),
                           .tnear = PACKET(float, packet, ray.tnear),
                           .dir_x = PACKET(float, packet, ray.dir_x),
                           .dir_y = PACKET(float, packet, ray.dir_y),
                           .dir_z = PACKET(float, packet, ray.dir_z),
                           .tfar = PACKET(float, packet, ray.tfar)};
}

static void intersect(const struct RTCIntersectFunctionNArguments *arguments) {
    const unsigned n = arguments->N;
    void *packet = arguments->rayhit;
    for (unsigned i = 0; i < n; i++) {
        struct RTCRay ray = packet_ray(packet, n, i);
        double t, outward[3];
        if (!arguments->valid[i] || !hit(arguments->geometryUserPtr, &ray, &t, outward))
            continue;
        PACKET(float, packet, ray.tfar) = (float)t;
        PACKET(float, packet, hit.Ng_x) = (float)outward[0];
        PACKET(float, packet, hit.Ng_y) = (float)outward[1];
        PACKET(float, packet, hit.Ng_z) = (float)outward[2];
        PACKET(float, packet, hit.u) = PACKET(float, packet, hit.v) = 0;
        PACKET(unsigned, packet, hit.primID) = arguments->primID;
        PACKET(unsigned, packet, hit.geomID) = arguments->geomID;
        PACKET(unsigned, packet, hit.instID[0]) = arguments->context->instID[0];
    }
}

static void occlude(const struct RTCOccludedFunctionNArguments *arguments) {
    const unsigned n = arguments->N;
    void *packet = arguments->ray;
    for (unsigned i = 0; i < n; i++) {
        struct RTCRay ray = packet_ray(packet, n, i);
        double t, outward[3];
        if (arguments->valid[i] && hit(arguments->geometryUserPtr, &ray, &t, outward))
            PACKET(float, packet, ray.tfar) = -INFINITY;
    }
}

RTCGeometry sphere_geometry(RTCDevice device, const struct mesh *mesh) {
    RTCGeometry geometry = embree.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    if (!geometry)
        return NULL;
    embree.rtcSetGeometryUserPrimitiveCount(geometry, 1);
    embree.rtcSetGeometryUserData(geometry, (void *)mesh); /* read-only */
    embree.rtcSetGeometryBoundsFunction(geometry, find_bounds, NULL);
    embree.rtcSetGeometryIntersectFunction(geometry, intersect);
    embree.rtcSetGeometryOccludedFunction(geometry, occlude);
    return geometry;
}

void sphere_uv(const struct mesh *mesh, struct vec3 outward, float *u, float *v) {
    struct vec3 local = to_axes(mesh->sphere_axes, outward);
    float azimuth = atan2f(local.y, local.x) * (0.5f / PI_F);
    *u = azimuth < 0 ? azimuth + 1 : azimuth;
    *v = atan2f(hypotf(local.x, local.y), local.z) * (1 / PI_F);
}

void sphere_fill(const struct mesh *mesh, struct vec3 outward, struct surface *out) {
    const float *s = mesh->sphere;
    struct vec3 n = normalize_short(outward);
    out->position = add(vec(s[0], s[1], s[2]), scale(n, s[3]));
    out->geometric_normal = out->normal = mesh->flip_normals ? negate(n) : n;
    sphere_uv(mesh, n, &out->u, &out->v);
    out->dp_du = out->dp_dv = vec(0, 0, 0);
}

void sphere_fill_tangents(const struct mesh *mesh, struct surface *out) {
    struct vec3 n = mesh->flip_normals ? negate(out->normal) : out->normal;
    struct vec3 p = to_axes(mesh->sphere_axes, n);
    float ring = hypotf(p.x, p.y), radius = mesh->sphere[3];
    float c = ring > 0 ? p.x / ring : 1, s = ring > 0 ? p.y / ring : 0;
    out->dp_du = scale(from_axes(mesh->sphere_axes, vec(-p.y, p.x, 0)), 2 * PI_F * radius);
    out->dp_dv = scale(from_axes(mesh->sphere_axes, vec(p.z * c, p.z * s, -ring)), PI_F * radius);
}
