/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDING_H
#define FEWRAY_GUIDING_H

/* The guide alone, for another renderer's own scenes, materials and integrator (Bako, Meyer,
 * DeRose, Sen 2019, "Offline Deep Importance Sampling for Monte Carlo Path Tracing", section 5.3:
 * the network isn't trained for a renderer or a scene):
 *
 *     trace a first look           one or a few samples a pixel, first bounce uniform over the
 *                                  hemisphere, into arrays of your own
 *     fewray_guide_create()        the arrays -> sampling maps and probes, 0.1 to 0.2 s a picture
 *     fewray_guide_first()         at the first vertex of each remaining path: what guides there
 *     fewray_guide_later()         at the vertices after it
 *     fewray_guide_sample(), _pdf()
 *     fewray_guide_look_weight()   the look's own share in each pixel's mean
 *
 * and, where samples are many, fewray_guide_learn() between them; or, for renderers that trace many
 * paths side by side, fewray_guide_sample_many() and _pdf_many().
 *
 * To stay unbiased, draw from the BSDF with the chance bsdf_fraction and else from the guide, and
 * divide by the density of both (solid angle; one-sample multiple importance sampling, Veach 1997,
 * section 9.2.4)
 *
 *     pdf = bsdf_fraction * bsdf_pdf + (1 - bsdf_fraction) * guide_pdf,
 *
 * by which light sampling is weighed, too. What a map can't guide is left to the BSDF: with the
 * share `breadth` (0..1) of a material that scatters widely, take 1 - (1 - bsdf_fraction) * breadth
 * for the fraction, so that mirrors, glass and narrow lobes (breadth 0) are never guided. The first
 * vertex is the first one that isn't perfectly specular.
 *
 * Pictures go in rows from the upper left corner; directions are unit vectors in world space, away
 * from the surface; radiance is linear RGB. Vectors are three floats side by side. */

#include "fewray/features.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Density (solid angle) of the look's first bounces, 1 / (2 pi): uniform over the hemisphere around
 * the normal, whatever the material is. */
#define FEWRAY_LOOK_PDF 0.15915494f

/* What the first look saw: N = height * width * samples records, those of a pixel side by side.
 * Nothing is kept of the arrays after fewray_guide_create(). */
struct fewray_guide_look {
    int width, height; /* picture, pixels */
    int samples;       /* records a pixel, 1 or more */

    /* The first vertex. */
    const float *position;  /* (N, 3) world space */
    const float *normal;    /* (N, 3) shading normal, unit, towards the viewer */
    const float *depth;     /* (N) way from the camera, scene units; 0 or infinite: no record (the
                               path missed the scene, or nothing there scatters widely) */
    const float *direction; /* (N, 3) of the first bounce, of density FEWRAY_LOOK_PDF, best by
                               fewray_guide_look_direction() */
    const float *direct;    /* (N, 3) or NULL: one estimate of the light that light sampling finds
                               here, irradiance / pi, weighed against FEWRAY_LOOK_PDF; for
                               fewray_guide_irradiance_many() alone */

    /* What came from there. */
    const float *emitted;   /* (N, 3) emission of what the bounce hit, or of the background; as it
                               is, not weighed */
    const float *light_pdf; /* (N) or NULL: density (solid angle) with which light sampling at the
                               first vertex draws that very direction; 0: it can't. By the power
                               heuristic of both the guide leaves to light sampling what light
                               sampling does well */
    const float *reflected; /* (N, 3) one estimate of the radiance that the second vertex reflects,
                               of light sampling and further bounces there */

    /* The second vertex. */
    const float *distance;      /* (N) from the first, scene units; 0 or infinite: the bounce hit
                                   nothing */
    const float *second_normal; /* (N, 3) unit, towards the first vertex; any where there is none */

    /* All five or none (NULL): what the second vertex found by its own two samples, pooled in
     * probes that guide the later vertices and lower the noise of `reflected`. */
    const float *second_albedo; /* (N) mean of RGB of the reflectance; 0: there is no such vertex,
                                   or it is specular */
    const float *second_light;  /* (N, 3) direction of light sampling; any where it drew none */
    const float *second_light_value; /* (N) mean of RGB of the incident radiance from there, 0 where
                                        blocked, over the sum of the densities with which light
                                        sampling and the BSDF draw it; negative: none was drawn */
    const float *second_bounce;      /* (N, 3) direction that the BSDF drew; any where none */
    const float *second_bounce_value; /* (N) the same of that direction, of all that came from
                                         there: emission over the sum of both densities, reflection
                                         over the BSDF's; 0: nothing */
};

/* A direction for a record of pixel (x, y), `sample` of its samples: uniform over the hemisphere
 * around the unit normal, and spread among neighbouring pixels as those of fewray's own look are,
 * so that few bins of a map stay empty. */
FEWRAY_API void fewray_guide_look_direction(uint64_t seed, int x, int y, int sample,
                                            const float normal[3], float direction[3]);
/* The same for all N records; a normal of 0 0 0 gives that as direction. threads: 0 = all cores. */
FEWRAY_API void fewray_guide_look_directions(uint64_t seed, int width, int height, int samples,
                                             int threads, const float *normal, float *direction);

struct fewray_guide_options {
    int threads;         /* 0 = all cores */
    float bsdf_fraction; /* share of the directions that the BSDF draws at the first vertex, 0..1;
                            negative (the default): the network decides for each map */
    int map_bins;        /* rows and columns of a map over the sphere: 32 (the default), 16 or 8 */
    bool share_maps;     /* four blocks of 8 x 8 pixels that show one even surface have one map */
    const char *weights_path;   /* the network; NULL = built in */
    const volatile int *cancel; /* NULL; non-zero, by an atomic store, ends fewray_guide_create()
                                   with FEWRAY_ERROR_CANCELLED */
    bool learns;                /* fewray_guide_learn() will be called: 12 KB more a map */
    /* For fewray_guide_look_weight(), what is known of the unguided samples' noise. */
    float bounce_share;    /* of its variance, what comes by the first bounce, 0..1; unknown: 1 */
    float bounce_variance; /* that variance over the squared radiance; unknown: INFINITY */
};
/* As fewray's own renderer has them. */
FEWRAY_API void fewray_guide_options_init(struct fewray_guide_options *options);

struct fewray_guide_stats {
    long long records; /* of the look that were used */
    long long dropped; /* with NaN, infinite or negative radiance, or a direction or normal that
                          isn't unit, or a direction below the surface: left out */
    int maps, probes;
};

struct fewray_guide;

/* Makes maps, and probes if there are second vertices, of a look. options, stats may be NULL. A
 * look whose records were all dropped is an error that says why; one without records guides
 * nothing. *out is owned by the caller. The same bits on any number of threads. */
FEWRAY_API int fewray_guide_create(const struct fewray_guide_look *look,
                                   const struct fewray_guide_options *options,
                                   struct fewray_guide **out, struct fewray_guide_stats *stats,
                                   struct fewray_error *error);
FEWRAY_API void fewray_guide_destroy(struct fewray_guide **guide);

/* What guides at one vertex; valid as long as the guide. The functions below may be called from any
 * number of threads and allocate nothing. */
struct fewray_guide_at {
    float bsdf_fraction; /* share of the directions that the BSDF should draw, 0..1; 1: nothing
                            guides here, and the two functions below give 0 */
    float light_chance;  /* with which a shadow ray is worth tracing here, (0, 1]: below 1 the look
                            saw no light around; trace with this chance and divide by it, or don't
                            care */
    /* The rest is fewray's own. */
    int count;
    float share[4];
    const void *maps[4];
    const void *probe;
};

/* At the first vertex of a path through pixel (x, y); outside the picture its edge counts. normal:
 * unit, towards the viewer. */
FEWRAY_API struct fewray_guide_at fewray_guide_first(const struct fewray_guide *guide, int x, int y,
                                                     const float position[3],
                                                     const float normal[3]);
/* At a vertex after it. last: the bounce from here can only find lights, since the path ends then.
 */
FEWRAY_API struct fewray_guide_at fewray_guide_later(const struct fewray_guide *guide,
                                                     const float position[3], const float normal[3],
                                                     bool last);
/* Draws a direction (unit), maybe one below the surface, whose contribution is 0. u: two numbers in
 * [0, 1); 1 counts as the number below. */
FEWRAY_API void fewray_guide_sample(const struct fewray_guide_at *at, const float u[2],
                                    float direction[3]);
/* Density (solid angle) of fewray_guide_sample(); integrates to 1 over the sphere. */
FEWRAY_API float fewray_guide_pdf(const struct fewray_guide_at *at, const float direction[3]);

/* Many vertices at once, on the guide's threads. */
struct fewray_guide_points {
    size_t count;
    const int32_t *pixel;  /* (count, 2) x, y: first vertices; NULL: later ones */
    const float *position; /* (count, 3) */
    const float *normal;   /* (count, 3) */
    bool last;             /* of later ones, as in fewray_guide_later() */
};
/* Where nothing guides: fraction 1, pdf and direction 0. u: (count, 2); direction: (count, 3);
 * pdf, fraction: (count), of the guide alone and of fewray_guide_at.bsdf_fraction. fraction may be
 * NULL. */
FEWRAY_API void fewray_guide_sample_many(const struct fewray_guide *guide,
                                         const struct fewray_guide_points *points, const float *u,
                                         float *direction, float *pdf, float *fraction);
FEWRAY_API void fewray_guide_pdf_many(const struct fewray_guide *guide,
                                      const struct fewray_guide_points *points,
                                      const float *direction, float *pdf, float *fraction);

/* A nearly noise-free estimate of the light on each point of points->pixel, for a denoiser (the
 * `irradiance` of fewray/denoise.h). irradiance: (count, 3), irradiance / pi; confidence: (count),
 * 0..1; 0 where no map fits. points->position isn't read. */
FEWRAY_API void fewray_guide_irradiance_many(const struct fewray_guide *guide,
                                             const struct fewray_guide_points *points,
                                             float *irradiance, float *confidence);

/* Share of the look in the mean of pixel (x, y): share * (mean of the look's samples) + (1 - share)
 * * (mean of the `guided` others). It is by what maps expect of both kinds of samples, of which
 * none has seen the pixel's own look: a weight that depended on its samples would bias. */
FEWRAY_API float fewray_guide_look_weight(const struct fewray_guide *guide, int x, int y,
                                          int guided);
/* For all pixels: share is (height, width) of the look's picture. */
FEWRAY_API void fewray_guide_look_weights(const struct fewray_guide *guide, int guided,
                                          float *share);

/* --- Where samples are many, maps learn from those that they have drawn: trace a pass over the
 * picture, learn from it, refine, trace the next. That doesn't bias: each sample is drawn by maps
 * that haven't seen it, and counts by its own density. */

/* What samples saw at their first vertex and by their bounce from there, however it was drawn; as
 * in struct fewray_guide_look. Bad ones are ignored. */
struct fewray_guide_lesson {
    size_t count;
    const int32_t *pixel;   /* (count, 2) x, y */
    const float *normal;    /* (count, 3) */
    const float *direction; /* (count, 3) */
    const float *emitted;   /* (count, 3) */
    const float *light_pdf; /* (count) or NULL */
    const float *reflected; /* (count, 3) */
};
/* Notes them; nothing changes before fewray_guide_refine(). Needs options.learns. Not while another
 * thread uses the guide. */
FEWRAY_API int fewray_guide_learn(struct fewray_guide *guide,
                                  const struct fewray_guide_lesson *lesson,
                                  struct fewray_error *error);
/* Makes the maps anew of the look and all that was noted; fewray does so after 4, 16, 64, ...
 * samples a pixel. What fewray_guide_first() and _later() returned before is void. */
FEWRAY_API int fewray_guide_refine(struct fewray_guide *guide, struct fewray_error *error);

#ifdef __cplusplus
}
#endif
#endif
