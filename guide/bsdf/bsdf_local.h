/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_BSDF_LOCAL_H
#define FEWRAY_GUIDE_BSDF_LOCAL_H

/* One plain BSDF, without wrappers, at a surface point. Directions are local and unit: z is the
 * shading normal, outgoing leads to the viewer, incident to where light comes from; z < 0 lies
 * inside. Evaluation, density and sampling follow Mitsuba 3's plugins of the same names. */

#include "guide/basis.h"
#include "guide/scene/scene.h"

#define BSDF_TRANSMITTANCE_SIZE 64

/* What a rough or smooth plastic needs beforehand; of other kinds 0. */
struct bsdf_table {
    float internal_reflectance;     /* diffuse, from inside */
    float specular_sampling_weight; /* of the coat against the base, by their mean reflectances */
    float mean_transmittance;       /* of even light from outside */
    float transmittance[BSDF_TRANSMITTANCE_SIZE]; /* through the rough coat, over cos(theta) */
    float coat_albedo[BSDF_TRANSMITTANCE_SIZE];   /* what it mirrors, likewise */
};

/* Textures looked up, and what the kind's ..._prepare() makes of them. */
struct bsdf_local {
    const struct bsdf *bsdf;
    const struct bsdf_table *table;
    float weight;                   /* of this BSDF in the point's sum, and chance to be picked */
    struct basis frame;             /* world to local, left-handed behind a two-sided BSDF; unset
                                       for an unperturbed BSDF_DIFFUSE but frame.n */
    bool perturbed;                 /* by a bump or normal map */
    struct vec3 unperturbed_normal; /* on the viewer's side: what is above the one must be above the
                                       other */
    float terminator_alpha2;        /* perturbed: of the shadowing function, 0 = none (perturb.h) */
    struct vec3 outgoing;
    struct vec3 reflectance, specular_reflectance, specular_transmittance;
    float alpha_u, alpha_v;
    float principled[PRINCIPLED_COUNT];

    /* Filled by ..._prepare(). */
    float delta_chance; /* of ..._sample() to draw a perfectly specular direction */
    float breadth;      /* see struct shading */
    struct vec3 albedo; /* likewise */
};

struct bsdf_sample {
    struct vec3 direction; /* incident */
    struct vec3 weight;    /* f |cos(theta)| / pdf; of a specular direction its value / chance */
    float pdf;             /* solid angle; of a specular direction its chance (discrete) */
    bool delta;            /* perfectly specular, or passed through */
    float eta; /* index of refraction of the incident side over the outgoing one's; 1: reflected */
};

/* For each kind:
 * prepare  fills the last three members of *b
 * eval     f |cos(theta)| without perfectly specular parts
 * pdf      density (solid angle) of sample(), integral 1 - delta_chance
 * sample   specular where choice < b->delta_chance; fills *out in local space; false: nothing */
void diffuse_prepare(struct bsdf_local *b);
struct vec3 diffuse_eval(const struct bsdf_local *b, struct vec3 incident);
float diffuse_pdf(const struct bsdf_local *b, struct vec3 incident);
bool diffuse_sample(const struct bsdf_local *b, float choice, const float u[2],
                    struct bsdf_sample *out);

/* BSDF_NULL: a surface that isn't there. */
void null_prepare(struct bsdf_local *b);
bool null_sample(const struct bsdf_local *b, float choice, const float u[2],
                 struct bsdf_sample *out);

/* BSDF_CONDUCTOR, BSDF_ROUGH_CONDUCTOR */
void conductor_prepare(struct bsdf_local *b);
struct vec3 conductor_eval(const struct bsdf_local *b, struct vec3 incident);
float conductor_pdf(const struct bsdf_local *b, struct vec3 incident);
bool conductor_sample(const struct bsdf_local *b, float choice, const float u[2],
                      struct bsdf_sample *out);

/* BSDF_DIELECTRIC, BSDF_THIN_DIELECTRIC, BSDF_ROUGH_DIELECTRIC */
void dielectric_prepare(struct bsdf_local *b);
struct vec3 dielectric_eval(const struct bsdf_local *b, struct vec3 incident);
float dielectric_pdf(const struct bsdf_local *b, struct vec3 incident);
bool dielectric_sample(const struct bsdf_local *b, float choice, const float u[2],
                       struct bsdf_sample *out);

/* BSDF_PLASTIC, BSDF_ROUGH_PLASTIC */
void plastic_prepare(struct bsdf_local *b);
struct vec3 plastic_eval(const struct bsdf_local *b, struct vec3 incident);
float plastic_pdf(const struct bsdf_local *b, struct vec3 incident);
bool plastic_sample(const struct bsdf_local *b, float choice, const float u[2],
                    struct bsdf_sample *out);

/* BSDF_PRINCIPLED */
void principled_prepare(struct bsdf_local *b);
struct vec3 principled_eval(const struct bsdf_local *b, struct vec3 incident);
float principled_pdf(const struct bsdf_local *b, struct vec3 incident);
bool principled_sample(const struct bsdf_local *b, float choice, const float u[2],
                       struct bsdf_sample *out);

/* The table of a scene's BSDF (bsdf_table.c). */
void bsdf_table_fill(const struct fewray_scene *scene, const struct bsdf *bsdf,
                     struct bsdf_table *out);

#endif
