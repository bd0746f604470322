/* SPDX-License-Identifier: Apache-2.0 */
/* The film, and the frame made of it. */

#include "guide/trace/film.h"

#include <limits.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "features/pages.h"
#include "guide/trace/team.h"

void fewray_render_settings_init(struct fewray_render_settings *settings) {
    *settings = (struct fewray_render_settings){
        .spp = 4,
        .initial = 1,
        .bsdf_fraction = -1,
        .look_weight = -1,
        .bounce_share = 1,
        .bounce_variance = INFINITY,
        .probes = true,
        .share_maps = true,
        .refine = true,
        .map_bins = SPHERE_ROWS,
        .camera_rays = 32,
    };
}

void fewray_render_settings_paper(struct fewray_render_settings *settings) {
    settings->bsdf_fraction = 0;
    settings->look_weight = 0;
    settings->paper_weights = true;
    settings->probes = settings->share_maps = settings->refine = false;
    settings->map_bins = SPHERE_ROWS;
}

int film_threads(const struct fewray_render_settings *settings) {
    return settings->threads > 0 ? settings->threads : omp_get_num_procs();
}

/* The picture's size where one or none of width and height is given. */
static void picture_size(const struct camera *camera, const struct fewray_render_settings *settings,
                         int *width, int *height) {
    double aspect = (double)camera->width / camera->height;
    *width = settings->width > 0    ? settings->width
             : settings->height > 0 ? (int)fmin(round(settings->height * aspect), INT_MAX)
                                    : camera->width;
    *height = settings->height > 0  ? settings->height
              : settings->width > 0 ? (int)fmin(round(settings->width / aspect), INT_MAX)
                                    : camera->height;
    *width = *width > 0 ? *width : 1;
    *height = *height > 0 ? *height : 1;
}

/* The sums, and a frame of all layers, or refuses the size. */
static int check_size(const struct fewray_film *film, const struct fewray_render_settings *settings,
                      struct fewray_error *error) {
    enum { FRAME_PLANES = 24 };
    char what[64];
    double pixel = sizeof(struct pixel_group) * (settings->initial > 0 ? 2 : 1) +
                   sizeof(struct pixel_edge) + FRAME_PLANES * sizeof(float);
    snprintf(what, sizeof(what), "a picture of %d x %d pixels", film->width, film->height);
    return fewray_memory_check(NULL, what, pixel * film->width * film->height, error);
}

int fewray_film_create(const struct fewray_world *world,
                       const struct fewray_render_settings *settings, struct fewray_film **out,
                       struct fewray_error *error) {
    *out = NULL;
    struct fewray_film *film = calloc(1, sizeof(*film));
    if (film) {
        picture_size(&world->scene->camera, settings, &film->width, &film->height);
        film->threads = film_threads(settings);
        film->look_weight = settings->look_weight;
        film->wants_direct = settings->direct;
        film->wants_indirect = settings->indirect;
        const size_t pixels = (size_t)film->width * (size_t)film->height;
        const int status = check_size(film, settings, error);
        if (status) {
            fewray_film_destroy(&film);
            return status;
        }
        for (int g = 0; g < GROUP_COUNT; g++)
            film->group[g] = pages_create(pixels * sizeof(*film->group[g]));
        film->edges = pages_create(pixels * sizeof(*film->edges));
    }
    const bool split = settings->direct || settings->indirect;
    if (film && split)
        film->indirect = calloc((size_t)film->width * (size_t)film->height * GROUP_COUNT,
                                sizeof(*film->indirect));
    if (!film || !film->group[GROUP_LOOK] || !film->group[GROUP_REST] || !film->edges ||
        (split && !film->indirect)) {
        fewray_film_destroy(&film);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                           "no memory for the picture; make it smaller with --width and --height");
    }
    *out = film;
    return FEWRAY_OK;
}

void fewray_film_destroy(struct fewray_film **film) {
    if (!*film)
        return;
    const size_t pixels = (size_t)(*film)->width * (size_t)(*film)->height;
    for (int g = 0; g < GROUP_COUNT; g++)
        pages_destroy((*film)->group[g], pixels * sizeof(*(*film)->group[g]));
    pages_destroy((*film)->edges, pixels * sizeof(*(*film)->edges));
    free((*film)->indirect);
    free(*film);
    *film = NULL;
}

void fewray_film_size(const struct fewray_film *film, int *width, int *height) {
    *width = film->width;
    *height = film->height;
}

bool fewray_film_is_empty(const struct fewray_film *film) {
    const size_t pixels = (size_t)film->width * (size_t)film->height;
    for (int g = 0; g < GROUP_COUNT; g++)
        for (size_t i = 0; i < pixels; i++)
            if (film->group[g][i].count > 0)
                return false;
    return true;
}

int fewray_film_share(struct fewray_film *film, const struct fewray_team *team,
                      struct fewray_error *error) {
    int width = film->width, height = film->height;
    int status = FEWRAY_OK;
    for (int g = 0; g < GROUP_COUNT && !status; g++)
        status =
            team_share_pixels(team, film->group[g], sizeof(*film->group[g]), width, height, error);
    if (!status && film->indirect)
        status = team_share_pixels(team, film->indirect, GROUP_COUNT * sizeof(*film->indirect),
                                   width, height, error);
    if (!status)
        status = team_share_pixels(team, film->edges, sizeof(*film->edges), width, height, error);
    return status;
}

struct integrator film_integrator(const struct fewray_world *world, const struct fewray_film *film,
                                  const struct fewray_render_settings *settings) {
    return (struct integrator){.world = world,
                               .width = film->width,
                               .height = film->height,
                               .max_depth = settings->max_depth ? settings->max_depth
                                                                : world->scene->max_depth,
                               .rr_depth = world->scene->rr_depth};
}

static void accumulate(double sums[3], struct vec3 v) {
    sums[0] += v.x;
    sums[1] += v.y;
    sums[2] += v.z;
}

bool pixel_sums_add(struct pixel_sums *sums, const struct path_sample *p) {
    if (!is_finite(p->radiance) || !is_finite(p->emission) || !is_finite(p->albedo) ||
        !is_finite(p->normal) || !isfinite(p->depth)) {
        sums->dropped++;
        return false;
    }
    sums->count++;
    const float x[3] = {p->radiance.x, p->radiance.y, p->radiance.z};
    for (int c = 0; c < 3; c++) { /* Welford 1962 */
        double delta = x[c] - sums->radiance[c];
        sums->radiance[c] += delta / sums->count;
        sums->deviation[c] += delta * (x[c] - sums->radiance[c]);
    }
    accumulate(sums->emission, p->emission);
    accumulate(sums->albedo, p->albedo);
    accumulate(sums->normal, p->normal);
    accumulate(sums->indirect, p->indirect);
    sums->depth += p->depth;
    sums->alpha += p->alpha;
    return true;
}

/* Weighted mean of a stored mean and a new one. */
static float mix(float stored, double value, double share) {
    return (float)(stored + (value - stored) * share);
}

void film_add(struct fewray_film *film, int x, int y, int group, const struct pixel_sums *sums) {
    const size_t i = (size_t)y * (size_t)film->width + (size_t)x;
    struct pixel_group *g = &film->group[group][i];
    if (!sums->count)
        return;
    double before = g->count, each = 1.0 / sums->count;
    double share = sums->count / (before + sums->count);
    for (int c = 0; c < 3; c++) { /* Chan, Golub, LeVeque 1979 */
        double delta = sums->radiance[c] - g->radiance[c];
        g->deviation[c] += (float)(sums->deviation[c] + delta * delta * before * share);
        g->radiance[c] = mix(g->radiance[c], sums->radiance[c], share);
        g->emission[c] = mix(g->emission[c], sums->emission[c] * each, share);
        g->albedo[c] = mix(g->albedo[c], sums->albedo[c] * each, share);
        g->normal[c] = mix(g->normal[c], sums->normal[c] * each, share);
    }
    for (int c = 0; film->indirect && c < 3; c++) {
        float *mean = &film->indirect[i * GROUP_COUNT + (size_t)group][c];
        *mean = mix(*mean, sums->indirect[c] * each, share);
    }
    g->depth = mix(g->depth, sums->depth * each, share);
    g->alpha = mix(g->alpha, sums->alpha * each, share);
    g->count += sums->count;
}

/* Share of the look in the pixel's value: fixed by the numbers of samples and by what the maps
 * around expect of both kinds of samples, never by the samples themselves, so that it can't bias.
 */
float film_look_share(const struct fewray_film *film, const struct fewray_maps *maps, int x, int y,
                      const struct pixel_group *look, const struct pixel_group *rest) {
    if (!look->count || !rest->count)
        return look->count > 0;
    float a = (float)look->count, b = (float)rest->count;
    if (film->look_weight >= 0 || !maps)
        return fmaxf(film->look_weight, 0) * a / (a + b);
    return a / (a + b * maps_look_noise(maps, x, y));
}

/* Keeps the variance of absurd radiances a number. */
#define VARIANCE_MAX 1e30f

/* Variance of the pixel's mean. The spread is pooled over both groups because a look of one sample
 * has none of its own. */
static float mean_variance(const struct pixel_group *a, const struct pixel_group *b, float share,
                           int c) {
    int n = a->count + b->count;
    if (n == 0)
        return 0;
    if (n == 1) /* nothing to estimate from: as uncertain as it is bright */
        return a->count ? a->radiance[c] * a->radiance[c] : b->radiance[c] * b->radiance[c];
    float between = a->radiance[c] - b->radiance[c];
    float spread = (a->deviation[c] + b->deviation[c] +
                    between * between * (float)a->count * (float)b->count / (float)n) /
                   (float)(n - 1);
    return spread * ((a->count ? share * share / (float)a->count : 0) +
                     (b->count ? (1 - share) * (1 - share) / (float)b->count : 0));
}

struct layer_planes {
    float *color[3], *variance[3], *albedo[3], *shaded_albedo[3], *normal[3], *emission[3],
        *depth[3], *irradiance[3], *confidence[3], *direct[3], *indirect[3], *alpha;
};

/* What more camera rays saw of pixel i instead of what its samples saw. */
static void replace_features(const struct pixel_edge *edge, size_t i,
                             const struct layer_planes *p) {
    for (int c = 0; c < 3; c++) {
        p->color[c][i] = fmaxf(0, p->color[c][i] - p->emission[c][i]) + edge->emission[c];
        p->emission[c][i] = edge->emission[c];
        p->albedo[c][i] = edge->albedo[c];
        p->normal[c][i] = edge->normal[c];
    }
    p->depth[0][i] = edge->depth;
}

/* The colour's parts, which add up to it but for rounding. share: the look's. */
static void fill_parts(const struct fewray_film *film, size_t i, float share,
                       const struct layer_planes *p) {
    const float *look = film->indirect[i * GROUP_COUNT + GROUP_LOOK];
    const float *rest = film->indirect[i * GROUP_COUNT + GROUP_REST];
    for (int c = 0; c < 3; c++) {
        float color = p->color[c][i];
        float indirect = fminf(share * look[c] + (1 - share) * rest[c], color);
        if (p->indirect[c])
            p->indirect[c][i] = indirect;
        if (p->direct[c])
            p->direct[c][i] = color - indirect;
    }
}

static void fill_pixel(const struct fewray_film *film, const struct fewray_maps *maps, int x, int y,
                       const struct layer_planes *p) {
    size_t i = (size_t)y * (size_t)film->width + (size_t)x;
    const struct pixel_group *look = &film->group[GROUP_LOOK][i];
    const struct pixel_group *rest = &film->group[GROUP_REST][i];
    float s = film_look_share(film, maps, x, y, look, rest);
    for (int c = 0; c < 3; c++) {
        p->color[c][i] = s * look->radiance[c] + (1 - s) * rest->radiance[c];
        p->variance[c][i] = fminf(mean_variance(look, rest, s, c), VARIANCE_MAX);
        p->albedo[c][i] = s * look->albedo[c] + (1 - s) * rest->albedo[c];
        p->shaded_albedo[c][i] = p->albedo[c][i];
        p->normal[c][i] = s * look->normal[c] + (1 - s) * rest->normal[c];
        p->emission[c][i] = s * look->emission[c] + (1 - s) * rest->emission[c];
    }
    p->depth[0][i] = s * look->depth + (1 - s) * rest->depth;
    if (film->edges[i].rays > look->count + rest->count)
        replace_features(&film->edges[i], i, p);
    p->alpha[i] = s * look->alpha + (1 - s) * rest->alpha;
    if (film->indirect)
        fill_parts(film, i, s, p);
}

/* Irradiance / pi at a pixel from the maps around it, by the pixel's own mean normal. */
static void fill_irradiance(const struct fewray_maps *maps, int x, int y, size_t i,
                            const struct layer_planes *p) {
    struct vec3 e = maps_irradiance(
        maps, x, y, vec(p->normal[0][i], p->normal[1][i], p->normal[2][i]), &p->confidence[0][i]);
    p->irradiance[0][i] = e.x;
    p->irradiance[1][i] = e.y;
    p->irradiance[2][i] = e.z;
}

static bool add_parts(const struct fewray_film *film, struct fewray_frame *frame,
                      struct layer_planes *p) {
    static const char *const names[2][3] = {{"direct.R", "direct.G", "direct.B"},
                                            {"indirect.R", "indirect.G", "indirect.B"}};
    for (int c = 0; c < 3; c++)
        if ((film->wants_direct && !(p->direct[c] = fewray_frame_add(frame, names[0][c]))) ||
            (film->wants_indirect && !(p->indirect[c] = fewray_frame_add(frame, names[1][c]))))
            return false;
    return true;
}

int fewray_film_frame(const struct fewray_film *film, const struct fewray_maps *maps,
                      struct fewray_frame **out, struct fewray_error *error) {
    *out = NULL;
    struct fewray_frame *frame = NULL;
    int status = fewray_frame_create(film->width, film->height, &frame, error);
    if (status)
        return status;
    struct layer_planes p = {.alpha = NULL};
    bool complete =
        fewray_frame_add_layer(frame, FEWRAY_COLOR, p.color) &&
        (p.alpha = fewray_frame_add(frame, "A")) != NULL &&
        fewray_frame_add_layer(frame, FEWRAY_VARIANCE, p.variance) &&
        fewray_frame_add_layer(frame, FEWRAY_ALBEDO, p.albedo) &&
        fewray_frame_add_layer(frame, FEWRAY_SHADED_ALBEDO, p.shaded_albedo) &&
        fewray_frame_add_layer(frame, FEWRAY_NORMAL, p.normal) &&
        fewray_frame_add_layer(frame, FEWRAY_DEPTH, p.depth) &&
        fewray_frame_add_layer(frame, FEWRAY_EMISSION, p.emission) && add_parts(film, frame, &p) &&
        (!maps || (fewray_frame_add_layer(frame, FEWRAY_IRRADIANCE, p.irradiance) &&
                   fewray_frame_add_layer(frame, FEWRAY_IRRADIANCE_CONFIDENCE, p.confidence)));
    if (!complete) {
        fewray_frame_destroy(&frame);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                           "no memory for the picture's layers");
    }
#pragma omp parallel for schedule(dynamic, 4) num_threads(film->threads)
    for (int y = 0; y < film->height; y++)
        for (int x = 0; x < film->width; x++) {
            size_t i = (size_t)y * (size_t)film->width + (size_t)x;
            fill_pixel(film, maps, x, y, &p);
            if (maps)
                fill_irradiance(maps, x, y, i, &p);
        }
    *out = frame;
    return FEWRAY_OK;
}
