/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_H
#define FEWRAY_GUIDE_H

/* The guided path tracer, in the order of use:
 *
 *     fewray_scene_load()      scene.xml -> scene
 *     fewray_world_create()    scene -> world: acceleration structure and light tables
 *     fewray_film_create()     empty sums for each pixel
 *     fewray_trace_look()      world -> film, look: the first samples of each pixel and what they
 * saw fewray_maps_create()     look -> maps: where the light comes from, by the ODIS network
 *     fewray_trace_rest()      world, maps -> film: the remaining samples
 *     fewray_trace_edges()     world -> film: more camera rays at the edges of what shines
 *     fewray_film_frame()      film, maps -> frame: the picture and its feature layers
 *
 * Without a guide fewray_trace_rest() with maps = NULL does all samples.
 */

#include "features/features.h"

#ifdef __cplusplus
extern "C" {
#endif

struct fewray_scene;
struct fewray_world;
struct fewray_film;
struct fewray_look;
struct fewray_maps;

/* "name=value" pairs for $name in the file, over the file's own <default>s. */
struct fewray_scene_options {
    const char *const *defines;
    int define_count;
    int threads; /* for meshes and textures; 0 = all cores */
};

/* Loads a Mitsuba 3 XML scene. The error names file and line, and the mesh, plugin or reference at
 * fault. options may be NULL. *out is owned by the caller. */
FEWRAY_API int fewray_scene_load(const char *path, const struct fewray_scene_options *options,
                                 struct fewray_scene **out, struct fewray_error *error);
FEWRAY_API void fewray_scene_destroy(struct fewray_scene **scene);

/* What a scene holds, for `fewray info` and for defaults. */
struct fewray_scene_summary {
    int width, height; /* film, pixels */
    int max_depth;     /* -1: no limit */
    int sample_count;  /* the file's own spp */
    int meshes, materials, textures, emitters;
    long long triangles;
    int warning_count;
    const char *const *warnings; /* one line each; owned by the scene */
};
FEWRAY_API struct fewray_scene_summary fewray_scene_summarize(const struct fewray_scene *scene);

struct fewray_render_settings {
    int width,
        height;    /* pixels; 0 = the scene's own (one given: the other keeps the scene's aspect) */
    int spp;       /* samples a pixel, the first look included */
    int initial;   /* samples a pixel of the first look (guided only), 1..spp */
    int max_depth; /* 0 = the scene's own; as Mitsuba counts; -1 = no limit */
    uint64_t seed;
    int threads;         /* 0 = all cores */
    float bsdf_fraction; /* of guided samples that are drawn from the BSDF instead of the maps, (0,
                            1] */
    float look_weight;   /* weight of the first look in a guided picture, in shares of its samples'
                            number, 0..1 */
    const char *weights_path; /* the guide's network; NULL = built in */
    void (*progress)(void *user, const char *phase,
                     double fraction); /* NULL; may be called from any thread, one at a time */
    void *progress_user;
    const volatile int *cancel; /* NULL; non-zero ends the work early: functions return
                                   FEWRAY_ERROR_CANCELLED, the film holds what is done */
};
FEWRAY_API void fewray_render_settings_init(struct fewray_render_settings *settings);

/* Counts of the work done; the functions add to them. */
struct fewray_render_stats {
    long long paths, rays;           /* camera paths; rays of all kinds */
    long long dropped;               /* samples that were NaN or infinite: dropped and counted */
    long long grids, grids_inferred; /* grid points of the guide; those that the network filled */
    long long edge_pixels;   /* pixels whose directly seen emission got camera rays of its own */
    long long pixels_guided; /* pixels where at least one map could be sampled */
};

/* Builds the acceleration structure and light tables. The scene must outlive the world. *out is
 * owned by the caller. */
FEWRAY_API int fewray_world_create(const struct fewray_scene *scene, int threads,
                                   struct fewray_world **out, struct fewray_error *error);
FEWRAY_API void fewray_world_destroy(struct fewray_world **world);

/* Sums for each pixel of the settings' picture. *out is owned by the caller. */
FEWRAY_API int fewray_film_create(const struct fewray_world *world,
                                  const struct fewray_render_settings *settings,
                                  struct fewray_film **out, struct fewray_error *error);
FEWRAY_API void fewray_film_destroy(struct fewray_film **film);

/* Traces settings->initial samples a pixel with first directions spread uniformly over the
 * hemisphere, and keeps a record of each first bounce. *out is owned by the caller. */
FEWRAY_API int fewray_trace_look(const struct fewray_world *world,
                                 const struct fewray_render_settings *settings,
                                 struct fewray_film *film, struct fewray_look **out,
                                 struct fewray_render_stats *stats, struct fewray_error *error);
FEWRAY_API void fewray_look_destroy(struct fewray_look **look);

/* Gathers the look's records around grid points, fills them by the network and makes sampling maps
 * of them. */
FEWRAY_API int fewray_maps_create(const struct fewray_look *look,
                                  const struct fewray_render_settings *settings,
                                  struct fewray_maps **out, struct fewray_render_stats *stats,
                                  struct fewray_error *error);
FEWRAY_API void fewray_maps_destroy(struct fewray_maps **maps);

/* Traces the samples that the film still lacks. maps may be NULL: plain path tracing. */
FEWRAY_API int fewray_trace_rest(const struct fewray_world *world, const struct fewray_maps *maps,
                                 const struct fewray_render_settings *settings,
                                 struct fewray_film *film, struct fewray_render_stats *stats,
                                 struct fewray_error *error);

/* With fewer than 32 samples a pixel: traces more camera rays where directly seen emission has
 * edges; what they see replaces the samples' own emission there, which stays unbiased. */
FEWRAY_API int fewray_trace_edges(const struct fewray_world *world,
                                  const struct fewray_render_settings *settings,
                                  struct fewray_film *film, struct fewray_render_stats *stats,
                                  struct fewray_error *error);

/* The picture: all layers of enum fewray_layer but the denoiser's, and alpha; irradiance only with
 * maps. */
FEWRAY_API int fewray_film_frame(const struct fewray_film *film, const struct fewray_maps *maps,
                                 struct fewray_frame **out, struct fewray_error *error);

#ifdef __cplusplus
}
#endif
#endif
