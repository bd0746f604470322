/* SPDX-License-Identifier: Apache-2.0 */
/* Lambertian reflection on the side of the normal, and the surface that isn't there. */

#include "guide/bsdf/bsdf_local.h"

void diffuse_prepare(struct bsdf_local *b) {
    b->delta_chance = 0;
    b->breadth = 1;
    b->albedo = b->outgoing.z > 0 ? b->reflectance : vec(0, 0, 0);
}

struct vec3 diffuse_eval(const struct bsdf_local *b, struct vec3 incident) {
    return incident.z > 0 && b->outgoing.z > 0 ? scale(b->reflectance, incident.z / PI_F)
                                               : vec(0, 0, 0);
}

float diffuse_pdf(const struct bsdf_local *b, struct vec3 incident) {
    return incident.z > 0 && b->outgoing.z > 0 ? incident.z / PI_F : 0;
}

bool diffuse_sample(const struct bsdf_local *b, float choice, const float u[2],
                    struct bsdf_sample *out) {
    (void)choice;
    struct vec3 d = normalize(cosine_hemisphere(u));
    *out =
        (struct bsdf_sample){.direction = d, .weight = b->reflectance, .pdf = d.z / PI_F, .eta = 1};
    return out->pdf > 0 && b->outgoing.z > 0;
}

void null_prepare(struct bsdf_local *b) {
    b->delta_chance = 1;
    b->breadth = 0;
    b->albedo = vec(0, 0, 0);
}

bool null_sample(const struct bsdf_local *b, float choice, const float u[2],
                 struct bsdf_sample *out) {
    (void)choice;
    (void)u;
    *out = (struct bsdf_sample){.direction = negate(b->outgoing),
                                .weight = vec(1, 1, 1),
                                .pdf = 1,
                                .delta = true,
                                .eta = 1};
    return true;
}
