/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_H
#define FEWRAY_GUIDE_SCENE_H

/* A scene as plain data: what the loaders fill and the tracer reads. Everything is in world space
 * but the meshes of groups, which instances place. Colours are linear RGB with sRGB's primaries. */

#include <stdbool.h>
#include <stdint.h>

#include "fewray/guide.h"
#include "guide/vec.h"

enum texture_kind { TEXTURE_CONSTANT, TEXTURE_BITMAP, TEXTURE_CHECKERBOARD };
enum texture_wrap { WRAP_REPEAT, WRAP_MIRROR, WRAP_CLAMP };

struct texture {
    enum texture_kind kind;
    struct vec3 color0, color1;       /* constant: color0; checkerboard: both (Mitsuba's order) */
    struct vec3 factor;               /* of a bitmap's values */
    float to_uv[6];                   /* u' = m0 u + m1 v + m2, v' = m3 u + m4 v + m5 */
    const struct fewray_image *image; /* bitmap; owned by the scene's images */
    enum texture_wrap wrap;
    int channel;  /* bitmap: -1 = RGB; 0..3: this channel alone, as grey */
    bool nearest; /* no bilinear filter */
    bool srgb;    /* 8-bit values carry the sRGB transfer function */
};

/* Plugins of Mitsuba 3, by their names. The last five change or join other BSDFs. */
enum bsdf_kind {
    BSDF_DIFFUSE,
    BSDF_PLASTIC,
    BSDF_ROUGH_PLASTIC,
    BSDF_CONDUCTOR,
    BSDF_ROUGH_CONDUCTOR,
    BSDF_DIELECTRIC,
    BSDF_THIN_DIELECTRIC,
    BSDF_ROUGH_DIELECTRIC,
    BSDF_PRINCIPLED,
    BSDF_NULL,
    BSDF_TWOSIDED,  /* nested[0] in front, nested[1] behind */
    BSDF_MASK,      /* nested[0] with the opacity `weight`, else nested[1], a BSDF_NULL */
    BSDF_BLEND,     /* nested[1] with the share `weight`, else nested[0] */
    BSDF_BUMP_MAP,  /* nested[0]; height in `weight`, times bump_scale */
    BSDF_NORMAL_MAP /* nested[0]; normal in `weight`, times 2 minus 1 */
};

/* Plain BSDFs that wrappers can join at a point; a scene with more is refused. */
#define SHADING_LOCALS 4

enum microfacet_kind { MICROFACET_BECKMANN, MICROFACET_GGX };

/* The grey parameters of `principled`, in Mitsuba's meaning (0..1, but eta). */
enum principled_parameter {
    PRINCIPLED_METALLIC,
    PRINCIPLED_ROUGHNESS,
    PRINCIPLED_ANISOTROPIC,
    PRINCIPLED_SPEC_TRANS,
    PRINCIPLED_SPEC_TINT,
    PRINCIPLED_SHEEN,
    PRINCIPLED_SHEEN_TINT,
    PRINCIPLED_CLEARCOAT,
    PRINCIPLED_CLEARCOAT_GLOSS,
    PRINCIPLED_FLATNESS,
    PRINCIPLED_COUNT
};

/* A material or a part of one. Textures and nested BSDFs are indices in the scene's arrays, -1
 * where the kind has none. */
struct bsdf {
    enum bsdf_kind kind;
    int nested[2];
    int weight;                 /* texture: opacity, share, height or normal */
    int reflectance;            /* texture: diffuse_reflectance, or principled's base_color */
    int specular_reflectance;   /* texture; -1 = white */
    int specular_transmittance; /* texture; -1 = white */
    int alpha_u, alpha_v;       /* textures: roughness of the microfacets along dp/du and dp/dv */
    int principled[PRINCIPLED_COUNT]; /* textures; -1 = off, so that its part can be skipped */
    enum microfacet_kind microfacets;
    bool nonlinear;                         /* plastic: colour shifts by internal scattering */
    float eta;                              /* interior over exterior index of refraction */
    struct vec3 conductor_eta, conductor_k; /* complex index of refraction over the exterior's;
                                               `material none`, a perfect mirror: 0 and 1 */
    float bump_scale;
    bool flip_invalid_normals; /* bump and normal maps: turn normals that look away from the viewer
                                */
    bool use_shadowing_function; /* likewise: soften the shadow's edge that they make */
    bool tangents; /* it needs dp/du and dp/dv: it or a nested one is anisotropic, bumpy ... */
};

/* One of no textures and no nested BSDFs, with the defaults of Mitsuba's plugins. */
struct bsdf empty_bsdf(enum bsdf_kind kind);

enum mesh_kind { MESH_TRIANGLES, MESH_SPHERE };

struct mesh {
    char *id; /* the shape's id, or its file, for messages */
    enum mesh_kind kind;
    uint32_t vertex_count, triangle_count; /* a sphere: 0 */
    float *positions;  /* (vertex_count, 3), one vertex more is allocated (Embree reads 16 bytes) */
    float *normals;    /* (vertex_count, 3) unit shading normals, or NULL: use the face's */
    float *uvs;        /* (vertex_count, 2), or NULL */
    uint32_t *indices; /* (triangle_count, 3); the face normal is (p1-p0) x (p2-p0) */
    float sphere[4];   /* of a sphere: centre and radius */
    float sphere_axes[9]; /* rows: the sphere's own x, y, z in world space, unit; for its uv */
    bool flip_normals;    /* of a sphere: they point inwards */
    int group; /* -1: it stands in the scene itself; else in this group alone, and doesn't shine */
    int bsdf;
    int emission; /* texture: radiance on the side that the normal points to; -1 = none */
};

/* One placement of a group of meshes. */
struct instance {
    int group;
    float to_world[12]; /* 3 rows of 4 */
};

enum environment_kind { ENVIRONMENT_NONE, ENVIRONMENT_CONSTANT, ENVIRONMENT_MAP };

struct environment {
    enum environment_kind kind;
    struct vec3 radiance; /* constant */
    const struct fewray_image
        *image; /* map: float, 3 channels; latitude-longitude as Mitsuba's envmap */
    float scale;
    float
        to_local[9]; /* rows of the rotation that takes a world direction to the map's own space */
};

/* Lights without a surface. */
enum light_kind { LIGHT_POINT, LIGHT_SPOT, LIGHT_DIRECTIONAL, LIGHT_SUN };

struct light {
    enum light_kind kind;
    struct vec3 position; /* point, spot */
    struct vec3
        direction; /* spot, directional: unit, into which it shines; sun: unit, towards it */
    struct vec3 intensity; /* point, spot: W/sr; directional: irradiance across the direction, W/m2;
                              sun: radiance, W/(m2 sr) */
    float cutoff, beam_width; /* spot: half angles where it is dark, and until which it is whole,
                                 radians; sun: its half angle in cutoff */
};

struct camera {
    float
        to_world[12]; /* 3 rows of 4; looks along +z with +x to the LEFT of the image, as Mitsuba */
    float fov_x;      /* radians, along the image's width */
    float principal_x, principal_y; /* offset of the optical axis, shares of width and height */
    float aperture_radius;          /* thin lens, scene units; 0 = pinhole */
    float focus_distance;           /* along the axis, scene units */
    int width, height;              /* pixels */
};

/* Where the camera is at a time. */
struct camera_key {
    double time;        /* seconds */
    double position[3]; /* world space */
    double rotation[4]; /* unit quaternion x, y, z, w; of a mirrored camera that of (-x, y, z) */
    bool mirrored;      /* its axes are left-handed; all keys of a path alike */
};

struct fewray_scene {
    char *path;
    float origin[3]; /* of the loaded coordinates, in the file's: see recentre.h */
    struct camera camera;
    int camera_key_count;           /* 0: it rests */
    struct camera_key *camera_keys; /* in the order of their times */
    bool uses_frame;                /* the file has $frame */
    int max_depth; /* as Mitsuba counts: 1 = emission only, 2 = direct light; -1 = no limit */
    int rr_depth;
    int sample_count; /* the file's own spp */

    int texture_count, bsdf_count, mesh_count, image_count, light_count, instance_count,
        group_count, warning_count;
    int unused_textures; /* bitmaps in the scene's file that no material uses: never read */
    struct texture *textures;
    struct bsdf *bsdfs;
    struct mesh *meshes;
    struct fewray_image **images;
    struct light *lights;
    struct instance *instances;
    struct environment environment;
    char **warnings; /* one line each: what was approximated (printed by the command, not here) */
};

#endif
