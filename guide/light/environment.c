/* SPDX-License-Identifier: Apache-2.0 */
/* Constant and latitude-longitude environments. */

#include "guide/light/environment.h"

#include <stdlib.h>

#include "guide/basis.h"
#include "guide/light/distribution.h"

/* Mitsuba's mapping: u = atan2(x, -z) / 2 pi (mod 1), v = acos(y) / pi. */
static struct environment_place to_place(struct vec3 local) {
    float a = atan2f(local.x, -local.z) * (0.5f / PI_F);
    a -= floorf(a);
    /* acos(y), without its loss of precision at the poles. */
    float v = atan2f(sqrtf(local.x * local.x + local.z * local.z), local.y) / PI_F;
    return (struct environment_place){a < 1 ? a : 0, v};
}

static float sin_theta_of(float v) {
    float sine, cosine;
    sin_cos_turns(0.5f * v, &sine, &cosine);
    return sine;
}

static struct vec3 from_place(const struct environment_place *place) {
    float sin_theta, cos_theta, sin_phi, cos_phi;
    sin_cos_turns(0.5f * place->v, &sin_theta, &cos_theta);
    sin_cos_turns(place->u, &sin_phi, &cos_phi);
    return vec(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta);
}

struct environment_place environment_find(const struct environment *e, struct vec3 direction) {
    return e->kind == ENVIRONMENT_MAP ? to_place(to_axes(e->to_local, direction))
                                      : (struct environment_place){0, 0};
}

static struct vec3 map_texel(const struct environment *e, int x, int y) {
    const float *p = e->image->floats +
                     ((size_t)y * (size_t)e->image->width + (size_t)x) * (size_t)e->image->channels;
    return vec(p[0], p[1], p[2]);
}

/* The four texels around a point: columns wrap and are sampled at their centres, while the first
 * and last row lie at the poles (Mitsuba's convention). */
struct map_cell {
    int x[2], y[2];
    float wx, wy;
};

static struct map_cell map_cell_at(const struct environment *e, float u, float v) {
    int w = e->image->width, h = e->image->height;
    float x = u * (float)w - 0.5f, y = v * (float)(h - 1);
    float fx = floorf(x), fy = fminf(floorf(y), (float)(h > 1 ? h - 2 : 0));
    int x0 = ((int)fx + w) % w, y0 = (int)fy;
    return (struct map_cell){
        {x0, (x0 + 1) % w}, {y0, h > 1 ? y0 + 1 : y0}, x - fx, h > 1 ? y - fy : 0};
}

/* Bilinear. */
static struct vec3 map_value(const struct environment *e, float u, float v) {
    struct map_cell c = map_cell_at(e, u, v);
    struct vec3 row[2];
    for (int k = 0; k < 2; k++)
        row[k] = add(scale(map_texel(e, c.x[0], c.y[k]), 1 - c.wx),
                     scale(map_texel(e, c.x[1], c.y[k]), c.wx));
    return scale(add(scale(row[0], 1 - c.wy), scale(row[1], c.wy)), e->scale);
}

struct vec3 environment_radiance_at(const struct environment *e,
                                    const struct environment_place *place) {
    if (e->kind == ENVIRONMENT_CONSTANT)
        return e->radiance;
    return e->kind == ENVIRONMENT_MAP ? map_value(e, place->u, place->v) : vec(0, 0, 0);
}

struct vec3 environment_radiance(const struct environment *e, struct vec3 direction) {
    struct environment_place place = environment_find(e, direction);
    return environment_radiance_at(e, &place);
}

void environment_prefetch(const struct environment *e, const struct environment_place *place) {
    struct map_cell c = map_cell_at(e, place->u, place->v);
    for (int k = 0; k < 2; k++)
        __builtin_prefetch(e->image->floats +
                           ((size_t)c.y[k] * (size_t)e->image->width + (size_t)c.x[0]) *
                               (size_t)e->image->channels);
}

/* Mean over a few points of the cell, so that bilinear slopes are followed and no lit cell has
 * density zero. */
static float cell_luminance(const struct environment *e, int x, int y, int w, int h) {
    float sum = 0;
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++) {
            float u = ((float)x + 0.5f * (float)i) / (float)w,
                  v = ((float)y + 0.5f * (float)j) / (float)h;
            float weight = (i == 1 ? 2.0f : 1.0f) * (j == 1 ? 2.0f : 1.0f) / 16;
            sum += weight * luminance(map_value(e, u - floorf(u), fminf(v, 1)));
        }
    return sum;
}

int environment_table_create(const struct environment *e, struct environment_table *t,
                             struct fewray_error *error) {
    *t = (struct environment_table){.environment = e};
    if (e->kind == ENVIRONMENT_CONSTANT)
        t->power_density = luminance(e->radiance);
    if (e->kind != ENVIRONMENT_MAP)
        return FEWRAY_OK;
    int w = t->width = e->image->width, h = t->height = e->image->height;
    size_t cells = (size_t)w * (size_t)h;
    t->row_cdf = malloc(((size_t)h + 1) * sizeof(float));
    t->row_cut = malloc((size_t)h * sizeof(*t->row_cut));
    t->column_cdf = malloc((cells + (size_t)h) * sizeof(float));
    t->cuts = w / 4 + 1;
    t->column_cut = malloc((size_t)h * (size_t)t->cuts * sizeof(*t->column_cut));
    float *luminances = malloc(cells * sizeof(float)), *rows = malloc((size_t)h * sizeof(float));
    if (!t->row_cdf || !t->row_cut || !t->column_cdf || !t->column_cut || !luminances || !rows) {
        free(luminances);
        free(rows);
        environment_table_clear(t);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                           "no memory for an environment map of %d x %d pixels", w, h);
    }
#pragma omp parallel for schedule(static)
    for (int y = 0; y < h; y++) {
        float sin_theta = sinf(PI_F * ((float)y + 0.5f) / (float)h);
        float *row = luminances + (size_t)y * (size_t)w;
        for (int x = 0; x < w; x++)
            row[x] = cell_luminance(e, x, y, w, h) * sin_theta;
        float *cdf = t->column_cdf + (size_t)y * ((size_t)w + 1);
        rows[y] = (float)cdf_build(row, (size_t)w, cdf);
        cdf_cut(cdf, (size_t)w, t->column_cut + (size_t)y * (size_t)t->cuts, (size_t)t->cuts);
    }
    double total = cdf_build(rows, (size_t)h, t->row_cdf);
    cdf_cut(t->row_cdf, (size_t)h, t->row_cut, (size_t)h);
    free(rows);
    free(luminances);
    /* Mean over the sphere: the integral of f sin(theta) over (u, v) times 2 pi^2 / 4 pi. */
    t->power_density = total / (double)cells * (PI_F / 2);
    return FEWRAY_OK;
}

void environment_table_clear(struct environment_table *t) {
    free(t->row_cdf);
    free(t->row_cut);
    free(t->column_cdf);
    free(t->column_cut);
    *t = (struct environment_table){0};
}

/* Density (solid angle) of a cell from the very sums that draw it: no table of its own, so one
 * place of memory less to read. */
static float cell_pdf(const struct environment_table *t, size_t x, size_t y, float sin_theta) {
    const float *column = t->column_cdf + y * ((size_t)t->width + 1) + x;
    float chance = (t->row_cdf[y + 1] - t->row_cdf[y]) * (column[1] - column[0]);
    float cells = (float)t->width * (float)t->height;
    return sin_theta > 0 ? chance * cells / (2 * PI_F * PI_F * sin_theta) : 0;
}

void environment_draw_row(const struct environment_table *t, const float u[2],
                          struct environment_draw *draw) {
    float a = u[0];
    const size_t rows = (size_t)t->height;
    draw->row = (uint32_t)cdf_sample_from(t->row_cdf, rows, t->row_cut[cdf_cut_of(a, rows)], &a);
    draw->v = ((float)draw->row + a) / (float)t->height;
    draw->start = (uint32_t)cdf_cut_of(u[1], (size_t)t->cuts);
    __builtin_prefetch(t->column_cut + (size_t)draw->row * (size_t)t->cuts + draw->start);
}

void environment_draw_start(const struct environment_table *t, struct environment_draw *draw) {
    draw->start = t->column_cut[(size_t)draw->row * (size_t)t->cuts + draw->start];
    __builtin_prefetch(t->column_cdf + (size_t)draw->row * ((size_t)t->width + 1) + draw->start);
}

struct vec3 environment_draw_column(const struct environment_table *t, const float u[2],
                                    const struct environment_draw *draw,
                                    struct environment_place *place, float *pdf) {
    float b = u[1];
    size_t x = cdf_sample_from(t->column_cdf + (size_t)draw->row * ((size_t)t->width + 1),
                               (size_t)t->width, draw->start, &b);
    *place = (struct environment_place){((float)x + b) / (float)t->width, draw->v};
    *pdf = cell_pdf(t, x, draw->row, sin_theta_of(place->v));
    return from_axes(t->environment->to_local, from_place(place));
}

struct vec3 environment_sample(const struct environment_table *t, const float u[2], float *pdf) {
    if (t->environment->kind != ENVIRONMENT_MAP) {
        *pdf = 0.25f / PI_F;
        return uniform_sphere(u);
    }
    struct environment_draw draw;
    struct environment_place place;
    environment_draw_row(t, u, &draw);
    environment_draw_start(t, &draw);
    return environment_draw_column(t, u, &draw, &place, pdf);
}

float environment_pdf_at(const struct environment_table *t, const struct environment_place *place) {
    if (t->environment->kind == ENVIRONMENT_NONE)
        return 0;
    if (t->environment->kind == ENVIRONMENT_CONSTANT)
        return 0.25f / PI_F;
    int x = (int)(place->u * (float)t->width), y = (int)(place->v * (float)t->height);
    x = x < t->width ? x : t->width - 1;
    y = y < t->height ? y : t->height - 1;
    return cell_pdf(t, (size_t)x, (size_t)y, sin_theta_of(place->v));
}

float environment_pdf(const struct environment_table *t, struct vec3 direction) {
    struct environment_place place = environment_find(t->environment, direction);
    return environment_pdf_at(t, &place);
}
