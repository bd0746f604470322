/* SPDX-License-Identifier: Apache-2.0 */
/* Constant and latitude-longitude environments. */

#include "guide/light/environment.h"

#include <stdlib.h>

#include "guide/basis.h"
#include "guide/light/distribution.h"

/* Mitsuba's mapping: u = atan2(x, -z) / 2 pi (mod 1), v = acos(y) / pi. */
static void to_uv(struct vec3 local, float *u, float *v) {
    float a = atan2f(local.x, -local.z) * (0.5f / PI_F);
    a -= floorf(a);
    *u = a < 1 ? a : 0;
    /* acos(y), without its loss of precision at the poles. */
    *v = atan2f(sqrtf(local.x * local.x + local.z * local.z), local.y) / PI_F;
}

static struct vec3 from_uv(float u, float v) {
    float theta = v * PI_F, phi = u * 2 * PI_F, sin_theta = sinf(theta);
    return vec(sinf(phi) * sin_theta, cosf(theta), -cosf(phi) * sin_theta);
}

static struct vec3 map_texel(const struct environment *e, int x, int y) {
    const float *p = e->image->floats +
                     ((size_t)y * (size_t)e->image->width + (size_t)x) * (size_t)e->image->channels;
    return vec(p[0], p[1], p[2]);
}

/* Bilinear; columns wrap and are sampled at their centres, while the first and last row lie at the
 * poles (Mitsuba's convention). */
static struct vec3 map_value(const struct environment *e, float u, float v) {
    int w = e->image->width, h = e->image->height;
    float x = u * (float)w - 0.5f, y = v * (float)(h - 1);
    float fx = floorf(x), fy = fminf(floorf(y), (float)(h > 1 ? h - 2 : 0));
    float wx = x - fx, wy = h > 1 ? y - fy : 0;
    int x0 = ((int)fx + w) % w, x1 = (x0 + 1) % w, y0 = (int)fy, y1 = h > 1 ? y0 + 1 : y0;
    struct vec3 top = add(scale(map_texel(e, x0, y0), 1 - wx), scale(map_texel(e, x1, y0), wx));
    struct vec3 bottom = add(scale(map_texel(e, x0, y1), 1 - wx), scale(map_texel(e, x1, y1), wx));
    return scale(add(scale(top, 1 - wy), scale(bottom, wy)), e->scale);
}

struct vec3 environment_radiance(const struct environment *e, struct vec3 direction) {
    if (e->kind == ENVIRONMENT_CONSTANT)
        return e->radiance;
    if (e->kind == ENVIRONMENT_NONE)
        return vec(0, 0, 0);
    float u, v;
    to_uv(to_axes(e->to_local, direction), &u, &v);
    return map_value(e, u, v);
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
    t->column_cdf = malloc((cells + (size_t)h) * sizeof(float));
    t->cuts = w / 4 + 1;
    t->column_cut = malloc((size_t)h * (size_t)t->cuts * sizeof(*t->column_cut));
    float *luminances = malloc(cells * sizeof(float)), *rows = malloc((size_t)h * sizeof(float));
    if (!t->row_cdf || !t->column_cdf || !t->column_cut || !luminances || !rows) {
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
    free(rows);
    free(luminances);
    /* Mean over the sphere: the integral of f sin(theta) over (u, v) times 2 pi^2 / 4 pi. */
    t->power_density = total / (double)cells * (PI_F / 2);
    return FEWRAY_OK;
}

void environment_table_clear(struct environment_table *t) {
    free(t->row_cdf);
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

struct vec3 environment_sample(const struct environment_table *t, const float u[2], float *pdf) {
    if (t->environment->kind != ENVIRONMENT_MAP) {
        *pdf = 0.25f / PI_F;
        return uniform_sphere(u);
    }
    float a = u[0], b = u[1];
    size_t y = cdf_sample(t->row_cdf, (size_t)t->height, &a);
    size_t x = cdf_sample_cut(t->column_cdf + y * ((size_t)t->width + 1), (size_t)t->width,
                              t->column_cut + y * (size_t)t->cuts, (size_t)t->cuts, &b);
    float v = ((float)y + a) / (float)t->height;
    *pdf = cell_pdf(t, x, y, sinf(v * PI_F));
    return from_axes(t->environment->to_local, from_uv(((float)x + b) / (float)t->width, v));
}

float environment_pdf(const struct environment_table *t, struct vec3 direction) {
    if (t->environment->kind == ENVIRONMENT_NONE)
        return 0;
    if (t->environment->kind == ENVIRONMENT_CONSTANT)
        return 0.25f / PI_F;
    float u, v;
    to_uv(to_axes(t->environment->to_local, direction), &u, &v);
    int x = (int)(u * (float)t->width), y = (int)(v * (float)t->height);
    x = x < t->width ? x : t->width - 1;
    y = y < t->height ? y : t->height - 1;
    return cell_pdf(t, (size_t)x, (size_t)y, sinf(v * PI_F));
}
