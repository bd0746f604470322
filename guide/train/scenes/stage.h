/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_STAGE_H
#define FEWRAY_TRAIN_STAGE_H

/* A generated scene while it is being built: shapes, materials, lights, sky and camera. Builders
 * work in metres (y up, the floor at y = 0); stage.root takes metres to the scene's own units. */

#include "guide/train/scenes/material.h"
#include "guide/train/scenes/mesh.h"
#include "guide/train/scenes/picture.h"
#include "guide/train/scenes/random.h"
#include "guide/train/scenes/sky.h"
#include "guide/vec.h"

/* Three rows of an affine map. */
struct xform {
    float m[12];
};

struct xform xform_identity(void);
struct xform xform_multiply(struct xform a, struct xform b); /* a after b */
struct xform xform_translate(float x, float y, float z);
struct xform xform_scale(float x, float y, float z);
struct xform xform_rotate(struct vec3 unit_axis, float radians);
struct xform xform_inverse(struct xform a);
struct vec3 xform_point(const struct xform *a, struct vec3 p);
struct vec3 xform_vector(const struct xform *a, struct vec3 v);
/* place moved by (x, y, z) of its own metres, then turned about its y axis. */
struct xform moved(struct xform place, float x, float y, float z, float yaw);
/* place moved and then turned about an arbitrary axis. */
struct xform tumbled(struct random *r, struct xform place, struct vec3 at);

/* Unit shapes as Mitsuba has them: [-1,1]^2 in xy facing +z, the unit disk, [-1,1]^3, the unit
 * sphere, the side of the cylinder of radius 1 around z = 0..1; and a mesh in its own metres. */
enum shape_kind {
    SHAPE_RECTANGLE,
    SHAPE_DISK,
    SHAPE_CUBE,
    SHAPE_SPHERE,
    SHAPE_CYLINDER,
    SHAPE_MESH
};

struct shape {
    enum shape_kind kind;
    struct xform to_world, to_local; /* rotation after scaling: no shear */
    struct vec3 center;              /* of a bounding sphere, world space */
    float radius;
    int material;
    int mesh;             /* of a SHAPE_MESH: which */
    struct vec3 radiance; /* zero: not a light */
};

/* A light without a surface. */
struct lamp {
    bool spot; /* else it shines everywhere */
    struct vec3 position, direction;
    struct vec3 intensity; /* W/sr, in the beam's middle */
    float cutoff, beam;    /* spot: half angles, degrees: dark beyond, full up to */
};

struct camera_pose {
    struct vec3 eye, target, up; /* world space */
    float fov;                   /* degrees, along the width */
};

#define STAGE_INTERESTS 48
#define STAGE_PICTURES  6
#define STAGE_MESHES    12
#define STAGE_LAMPS     8

struct stage {
    struct random random;
    float plan; /* 0..1: which kind of scene, kept over further tries */
    struct xform root;
    bool mixed; /* all kinds of materials, textures and lights; else diffuse surfaces alone */
    int shape_count, shape_capacity, material_count, material_capacity;
    struct shape *shapes;
    struct material *materials;
    int picture_count, mesh_count, lamp_count;
    struct picture pictures[STAGE_PICTURES];
    struct mesh *meshes[STAGE_MESHES];
    struct lamp lamps[STAGE_LAMPS];
    bool panes; /* light comes through glass: no sun, whose paths no one finds */
    struct sky sky;
    struct vec3 camera_low, camera_high;   /* root's metres: where a camera may stand */
    struct vec3 interest[STAGE_INTERESTS]; /* world space: what is worth looking at */
    int interest_count;
    float surface; /* world units^2: what the lights have to light, for their strengths */
    struct camera_pose camera;
    bool failed; /* out of memory: the scene is incomplete */
};

/* An empty stage of diffuse surfaces; the plan depends on seed and index, all other choices on the
 * attempt as well. */
void stage_init(struct stage *stage, uint64_t seed, uint64_t index, uint64_t attempt);
void stage_clear(struct stage *stage);
/* Remembers a point, in place's metres, that is worth looking at. */
void stage_look_here(struct stage *stage, struct xform place, struct vec3 at);

int stage_material(struct stage *stage, struct vec3 color);
int stage_checkerboard(struct stage *stage, struct vec3 color0, struct vec3 color1, float scale_u,
                       float scale_v);

/* Any material; its picture is an index of stage->pictures or -1. */
int stage_add_material(struct stage *stage, const struct material *material);

int stage_box(struct stage *stage, struct xform place, struct vec3 center, struct vec3 half,
              int material);
int stage_ball(struct stage *stage, struct xform place, struct vec3 center, float radius,
               int material);
/* A rectangle or disk of the given half sizes that faces along normal (both in place's metres). */
int stage_panel(struct stage *stage, enum shape_kind kind, struct xform place, struct vec3 center,
                struct vec3 normal, float half_u, float half_v, int material);
/* The side of a cylinder along y, of flat strips; from y = center.y to center.y + height. */
void stage_tube(struct stage *stage, struct xform place, struct vec3 center, float radius,
                float height, int sides, int material);

/* The round side of a cylinder between two points of place's metres, without lids. */
int stage_cylinder(struct stage *stage, struct xform place, struct vec3 from, struct vec3 to,
                   float radius, int material);
/* Places a mesh given in place's metres, which the stage takes over; NULL or one too many is
 * dropped. */
void stage_mesh(struct stage *stage, struct xform place, struct mesh *mesh, int material);

/* Makes a shape a light that brings `share` of mean irradiance to the stage's surface. */
void stage_light(struct stage *stage, int shape, struct vec3 tint, float share);
float shape_area(const struct shape *shape);

#endif
