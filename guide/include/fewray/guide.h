/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_H
#define FEWRAY_GUIDE_H

/* The guided path tracer, in the order of use:
 *
 *     fewray_scene_load()      scene.xml, .gltf, .glb or .obj -> scene
 *     fewray_world_create()    scene -> world: acceleration structure and light tables
 *     fewray_film_create()     empty sums for each pixel
 *     fewray_trace_pilot()     world -> whether a guide can pay
 *     fewray_trace_look()      world -> film, look: the first samples and what they saw
 *     fewray_maps_create()     look -> maps: where the light comes from, by the ODIS network
 *     fewray_trace_rest()      world, maps -> film: the remaining samples; or fewray_rest_*()
 *     fewray_trace_edges()     world -> film: more camera rays at the edges of what shines
 *     fewray_film_frame()      film, maps -> frame: the picture and its feature layers
 *
 * Without a guide fewray_trace_rest() with maps = NULL does all samples.
 */

#include "fewray/features.h"

#ifdef __cplusplus
extern "C" {
#endif

struct fewray_scene;
struct fewray_world;
struct fewray_film;
struct fewray_look;
struct fewray_maps;
struct fewray_state;

/* "name=value" pairs for $name in the file, over the file's own <default>s. */
struct fewray_scene_options {
    const char *const *defines;
    int define_count;
    int threads;       /* for meshes and textures; 0 = all cores */
    const char *frame; /* value of $frame where the file has it, over its <default>; NULL: none */
    bool lenient; /* BSDFs that aren't supported are drawn as diffuse, such emitters and media are
                left out, each with a warning; else they are refused */
};

/* Loads a Mitsuba 3 XML scene, glTF 2.0 (.gltf, .glb) or OBJ + MTL, by the file's ending. The error
 * names file and line, and the mesh, plugin or reference at fault. options may be NULL. *out is
 * owned by the caller. */
FEWRAY_API int fewray_scene_load(const char *path, const struct fewray_scene_options *options,
                                 struct fewray_scene **out, struct fewray_error *error);
FEWRAY_API void fewray_scene_destroy(struct fewray_scene **scene);

/* What a scene holds, for `fewray info` and for defaults. */
struct fewray_scene_summary {
    int width, height; /* film, pixels */
    int max_depth;     /* -1: no limit */
    int sample_count;  /* the file's own spp */
    int meshes, materials, textures, emitters;
    int images;          /* files of textures and the environment, each read once */
    int camera_keys;     /* poses of a moving camera; 0: it rests */
    bool uses_frame;     /* the file has $frame, so that each frame is a scene of its own */
    int unused_textures; /* bitmaps that no visible material uses: not read */
    long long triangles;
    int warning_count;
    const char *const *warnings; /* one line each; owned by the scene */
};
FEWRAY_API struct fewray_scene_summary fewray_scene_summarize(const struct fewray_scene *scene);

/* The same number for the same scene, wherever its files lie: of everything that is loaded. */
FEWRAY_API uint64_t fewray_scene_fingerprint(const struct fewray_scene *scene);

/* Processes, on one machine or many, that make one picture: each traces its own tiles of 16 x 16
 * pixels and is given what the others found, so that all hold the same look, maps and film, to the
 * bit what one process alone makes. They must have the same scene and settings. */
struct fewray_team {
    int rank, size; /* this process, 0..size - 1 */
    /* Gives each process the `bytes` of all: mine (bytes), all (size, bytes). Waits for the others;
     * false where they can't be reached. Called by one thread. */
    bool (*gather)(void *user, const void *mine, void *all, size_t bytes);
    void *user;
    void *messages; /* room for short messages: (size, FEWRAY_TEAM_MESSAGE) bytes, aligned as by
                       malloc() */
};
#define FEWRAY_TEAM_MESSAGE 2048
/* Ends a step that may fail in one process alone: all return the status, and have the error, of the
 * first in which it failed. Those that end with fewray_trace_look(), _rest() and _edges() and
 * fewray_maps_create() agree already. team may be NULL: status is returned. */
FEWRAY_API int fewray_team_agree(const struct fewray_team *team, int status,
                                 struct fewray_error *error);

/* Moves the camera of a scene with keys to where it is at this time; a scene is loaded at second 0.
 * Worlds of the scene stay valid; none may be traced meanwhile. */
FEWRAY_API void fewray_scene_set_time(struct fewray_scene *scene, double seconds);

/* What a pinhole shows, for the motion between two frames. */
struct fewray_view {
    float to_world[12]; /* 3 rows of 4; looks along +z with +x to the LEFT of the picture */
    float fov_x;        /* radians, along the picture's width */
    float principal_x, principal_y; /* offset of the optical axis, shares of width and height */
};
/* That of the scene's camera now; of a thin lens that of its middle. */
FEWRAY_API struct fewray_view fewray_scene_view(const struct fewray_scene *scene);
/* Where the surfaces that a frame shows were in the one before, if they stand still: motion is that
 * place less the pixel's own, in pixels (x to the right, y down), previous_depth the way to there
 * from the camera before, as the depth layer counts it; 0 where nothing is seen or it was behind
 * that camera. Each (height, width). What a flat mirror shows moves just so, too. */
FEWRAY_API void fewray_view_motion(const struct fewray_view *now, const struct fewray_view *before,
                                   int width, int height, const float *depth, float *motion_x,
                                   float *motion_y, float *previous_depth);

struct fewray_render_settings {
    int width,
        height;    /* pixels; 0 = the scene's own (one given: the other keeps the scene's aspect) */
    int spp;       /* samples a pixel, the first look included */
    int initial;   /* samples a pixel of the first look (guided only), 1..spp */
    int max_depth; /* 0 = the scene's own; as Mitsuba counts; -1 = no limit */
    uint64_t seed;
    int part;    /* the samples are those after this many times spp (and initial) of the same seed's
                    sequences; not of practical path guiding */
    int threads; /* 0 = all cores */
    float bsdf_fraction; /* of guided samples that are drawn from the BSDF instead of the maps,
                            0..1; negative: the network decides for each map. 0 stays unbiased:
                            such maps reach a little beyond the horizon */
    float look_weight;   /* weight of the first look in a guided picture, in shares of its samples'
                            number, 0..1; negative: what the maps expect of its noise decides */
    float bounce_share;  /* what a pilot tells of the samples' noise: share that comes by the first
                            bounce, 0..1; unknown: 1 */
    float bounce_variance;    /* its variance over the squared radiance; unknown: INFINITY */
    const char *weights_path; /* the guide's network; NULL = built in */
    bool paper_weights;       /* which built-in network: that of fewray_render_settings_paper() */
    bool probes;     /* what the look's second vertices saw is pooled, guides the later bounces and
                        spares shadow rays in the dark */
    bool share_maps; /* four blocks of 8 x 8 pixels that show one even surface have one map */
    bool refine;     /* maps learn from the samples they draw, where there are many */
    int map_bins;    /* rows and columns of a map over the sphere: 32, 16 or 8 */
    bool direct,
        indirect;    /* layers of the frame: the two parts of the colour, which add up to it */
    int camera_rays; /* of a pixel at an edge of emission, where it has fewer samples; a
                        quarter at edges of albedo, normal or depth; 0 = none */
    void (*progress)(void *user, const char *phase,
                     double fraction); /* NULL; may be called from any thread, one at a time */
    void *progress_user;
    /* Both or none. The tracing functions ask pause_due between tiles, from every thread; once it
     * says yes, all threads stop, and paused is called by the caller's own thread, alone, so that
     * it may read the film: see fewray_film_frame(). It is also called without being due after the
     * last tile of each pass over the picture. It changes no bit of the picture. */
    bool (*pause_due)(void *user);
    void (*paused)(void *user, bool whole_pass);
    void *pause_user;
    struct fewray_state *state;     /* NULL; is kept where fewray_trace_look() and _rest() are, for
                                       fewray_state_write(); they begin where it was read. Not with a
                                       team or practical path guiding */
    const struct fewray_team *team; /* NULL: this process works alone */
    const volatile int *cancel;     /* NULL; non-zero, by an atomic store, ends the work
                                       early: functions return FEWRAY_ERROR_CANCELLED, the film
                                       holds what is done */
};
FEWRAY_API void fewray_render_settings_init(struct fewray_render_settings *settings);
/* Sets what makes the guide that of Bako, Meyer, DeRose, Sen 2019, "Offline Deep Importance
 * Sampling for Monte Carlo Path Tracing", and leaves the rest: maps of the mean radiance by the
 * paper's network (L1 and GAN) at every block, for the first bounce alone and without the BSDF; the
 * first look is discarded. */
FEWRAY_API void fewray_render_settings_paper(struct fewray_render_settings *settings);

/* Counts of the work done; the functions add to them. */
struct fewray_render_stats {
    long long paths, rays;           /* camera paths; rays of all kinds */
    long long dropped;               /* samples that were NaN or infinite: dropped and counted */
    long long grids, grids_inferred; /* grid points of the guide; maps that the network filled */
    long long grids_shared;  /* grid points that use another one's map: the surface is flat */
    long long edge_pixels;   /* pixels at edges, which got camera rays of their own */
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
/* In pixels. */
FEWRAY_API void fewray_film_size(const struct fewray_film *film, int *width, int *height);
/* Whether no pixel has a sample yet. */
FEWRAY_API bool fewray_film_is_empty(const struct fewray_film *film);

/* Gives each process of a team (may be NULL) the whole film, also where work on it was broken off.
 */
FEWRAY_API int fewray_film_share(struct fewray_film *film, const struct fewray_team *team,
                                 struct fewray_error *error);

/* What a few samples tell about the noise: variance of a sample over the squared radiance around
 * its pixel, mean over the picture. */
struct fewray_pilot {
    float variance;        /* without what is seen directly */
    float bounce_variance; /* of what comes by the first bounce, all that a guide can lower */
    bool dark;             /* no light was found: nothing is known */
    bool tiny;             /* the picture's look is too small to learn from */
    int width, height;     /* of the picture, pixels */
    int paths;             /* that were traced */
};

/* Traces a few paths that don't count for the picture. */
FEWRAY_API int fewray_trace_pilot(const struct fewray_world *world,
                                  const struct fewray_render_settings *settings,
                                  const struct fewray_film *film, struct fewray_pilot *pilot,
                                  struct fewray_render_stats *stats, struct fewray_error *error);
/* False where the bounce's noise is too small, or too small a part of all, for a guide to pay:
 * a guided sample takes 1.7 to 2.2 times as long as a plain one, and guided ones are spread less
 * evenly. */
FEWRAY_API bool fewray_pilot_wants_guide(const struct fewray_pilot *pilot);

/* Traces settings->initial samples a pixel with first directions spread uniformly over the
 * hemisphere, and keeps a record of each first bounce. *out is owned by the caller. */
FEWRAY_API int fewray_trace_look(const struct fewray_world *world,
                                 const struct fewray_render_settings *settings,
                                 struct fewray_film *film, struct fewray_look **out,
                                 struct fewray_render_stats *stats, struct fewray_error *error);
FEWRAY_API void fewray_look_destroy(struct fewray_look **look);

/* Whether fewray_maps_create() will be able to use a file of the guide's network: it is read and
 * dropped. */
FEWRAY_API int fewray_maps_check_weights(const char *path, struct fewray_error *error);
/* Pools the look's second vertices in probes (settings->probes), gathers its records around grid
 * points, fills them by the network and makes sampling maps of them. Adds averages to the look's
 * records. */
FEWRAY_API int fewray_maps_create(struct fewray_look *look,
                                  const struct fewray_render_settings *settings,
                                  struct fewray_maps **out, struct fewray_render_stats *stats,
                                  struct fewray_error *error);
FEWRAY_API void fewray_maps_destroy(struct fewray_maps **maps);

/* Traces the samples that the film still lacks. maps may be NULL: plain path tracing. Where more
 * than 4 samples a pixel are wanted and settings->refine, the maps learn from the first 4, 16, 64,
 * ... of them. */
FEWRAY_API int fewray_trace_rest(const struct fewray_world *world, struct fewray_maps *maps,
                                 const struct fewray_render_settings *settings,
                                 struct fewray_film *film, struct fewray_render_stats *stats,
                                 struct fewray_error *error);

/* The same in passes, for a caller who decides on the way which tiles need how many samples. A
 * tile is FEWRAY_TILE_SIZE pixels wide and high; tiles go in rows from the upper left corner. To
 * stay unbiased, the number of samples of a tile mustn't depend on the values of its own. Samples
 * of a pass are summed in double precision; each pass rounds the means to floats once, so many
 * samples should come in few passes. */
#define FEWRAY_TILE_SIZE 16

struct fewray_rest;

struct fewray_pass {
    const int *tile_samples; /* of each pixel of each tile, 0 or more */
    bool learn, refine;      /* maps learn from these samples, and are made anew of all that they
                                have learnt for later passes; only where settings->refine and
                                settings->spp > 4 */
    double progress_begin, progress_end; /* of the pass in all of the render, 0..1 */
};

/* The world, maps (may be NULL), settings and film must outlive it. *out is owned by the caller. */
FEWRAY_API int fewray_rest_create(const struct fewray_world *world, struct fewray_maps *maps,
                                  const struct fewray_render_settings *settings,
                                  struct fewray_film *film, struct fewray_rest **out,
                                  struct fewray_error *error);
FEWRAY_API int fewray_rest_pass(struct fewray_rest *rest, const struct fewray_pass *pass,
                                struct fewray_render_stats *stats, struct fewray_error *error);
FEWRAY_API void fewray_rest_destroy(struct fewray_rest **rest);

/* --- a render's state, to go on with in another process: to the bit what one process makes */

/* *out is owned by the caller. */
FEWRAY_API int fewray_state_create(struct fewray_state **out, struct fewray_error *error);
FEWRAY_API void fewray_state_destroy(struct fewray_state **state);

/* Hands all that the render has found to write(), piece by piece: film, maps (NULL: there are none
 * yet), records, places. counts: before the pass over the picture, as the caller has them. Not
 * while tiles are traced: in settings->paused, or between the steps. False where write() returned
 * it. */
FEWRAY_API bool fewray_state_write(const struct fewray_state *state,
                                   const struct fewray_render_settings *settings,
                                   const struct fewray_film *film, const struct fewray_maps *maps,
                                   const struct fewray_render_stats *counts,
                                   bool (*write)(void *user, const void *bytes, size_t size),
                                   void *user);
/* False before the first look or, without one, before the samples, and from when a state was read
 * until its samples go on. */
FEWRAY_API bool fewray_state_can_be_written(const struct fewray_state *state);

/* Takes the same bytes, `size` of them, for a new film of the same world and settings; of those spp
 * may be another as long as the samples that are done are its first ones, too. *maps is owned by
 * the caller; NULL: there were none. */
FEWRAY_API int fewray_state_read(struct fewray_state *state,
                                 const struct fewray_render_settings *settings,
                                 struct fewray_film *film, struct fewray_maps **maps,
                                 struct fewray_render_stats *counts,
                                 bool (*read)(void *user, void *bytes, size_t size), void *user,
                                 size_t size, struct fewray_error *error);
/* Whether it needs neither fewray_trace_look() nor fewray_maps_create() any more. */
FEWRAY_API bool fewray_state_is_behind_look(const struct fewray_state *state);
/* To be told when the maps are made, before the look is destroyed. */
FEWRAY_API void fewray_state_has_maps(struct fewray_state *state);
/* That are done of each pixel, mean over the picture. */
FEWRAY_API double fewray_state_samples(const struct fewray_state *state);

/* Traces all samples by practical path guiding (Mueller et al. 2017 and 2019), which learns while
 * it renders: no look, no maps. The passes' pictures are weighted by their own variance. */
FEWRAY_API int fewray_trace_ppg(const struct fewray_world *world,
                                const struct fewray_render_settings *settings,
                                struct fewray_film *film, struct fewray_render_stats *stats,
                                struct fewray_error *error);

/* With fewer samples a pixel than settings->camera_rays: traces that many camera rays where the
 * emission, albedo, normal or depth that the camera sees have edges. What they see replaces what
 * the samples saw there, also the emission in the picture, which stays unbiased. */
FEWRAY_API int fewray_trace_edges(const struct fewray_world *world,
                                  const struct fewray_render_settings *settings,
                                  struct fewray_film *film, struct fewray_render_stats *stats,
                                  struct fewray_error *error);

/* The picture: all layers of enum fewray_layer but the denoiser's, and alpha; irradiance only with
 * maps. Where settings ask for them, direct.R/G/B, what the camera sees shine and what
 * lights send to the first vertex, and indirect.R/G/B, light that came there by way of another
 * surface. */
FEWRAY_API int fewray_film_frame(const struct fewray_film *film, const struct fewray_maps *maps,
                                 struct fewray_frame **out, struct fewray_error *error);

/* Adds to the film's frame what merging it with other parts of the same picture needs. Of each
 * pixel: "part.count" n, the number of its samples; "part.mean.R/G/B", their radiance m as
 * weighted in the picture, before more camera rays replaced what the samples saw;
 * "part.deviation.R/G/B", the sum of squared deviations from their plain mean; and "part.factor",
 * by which the variance of a sample gives that of m (1 / n where all have the same weight). */
FEWRAY_API int fewray_film_add_moments(const struct fewray_film *film,
                                       const struct fewray_maps *maps, struct fewray_frame *frame,
                                       struct fewray_error *error);

#ifdef __cplusplus
}
#endif
#endif
