/* SPDX-License-Identifier: Apache-2.0 */
/* The Hosek-Wilkie sky as an environment map, and its sun. */

#include "guide/scene/sunsky.h"

#include <stdlib.h>

#include "guide/scene/sunsky_table.h"

/* Rows of the map; even, so that the horizon lies midway between two and the dark ground below
 * takes nothing from the sky. */
#define ROWS 512

/* From the data's radiance to that of Mitsuba's pictures: 1 / the integral of CIE's y curve. */
#define RADIANCE_SCALE (1 / 106.7502594f)

/* The sun's half angle for which the data were made. */
#define DATA_HALF_ANGLE (0.5f * 0.5358f * PI_F / 180)

enum { CHANNELS = 3, PARAMETERS = 9, ELEVATIONS = 30 };

/* One channel's sky for a given turbidity, albedo and sun. */
struct channel {
    float p[PARAMETERS];
    float radiance;
};

/* A quintic Bezier curve at t; points lie `stride` apart. */
static float bezier(const float *points, int stride, float t) {
    static const float binomials[6] = {1, 5, 10, 10, 5, 1};
    float sum = 0;
    for (int k = 0; k < 6; k++)
        sum += binomials[k] * powf(1 - t, (float)(5 - k)) * powf(t, (float)k) * points[k * stride];
    return sum;
}

/* A turbidity's two neighbours in the tables. */
static int turbidity_cell(float turbidity, float *share) {
    float t = fminf(fmaxf(turbidity, 1), 10) - 1;
    int i = t < 8 ? (int)t : 8;
    *share = t - (float)i;
    return i;
}

/* Hosek and Wilkie 2012, section 5: linear in turbidity and albedo, quintic in the cube root of the
 * sun's elevation. */
static float look_up(const float *table, int values, int value, int channel, float turbidity,
                     float albedo, float t) {
    int stride = CHANNELS * values, per_albedo = 6 * stride;
    float share;
    int cell = turbidity_cell(turbidity, &share);
    float sum = 0;
    for (int i = 0; i < 2; i++)
        for (int a = 0; a < 2; a++) {
            const float *points =
                table + (2 * (cell + i) + a) * per_albedo + channel * values + value;
            sum += (i ? share : 1 - share) * (a ? albedo : 1 - albedo) * bezier(points, stride, t);
        }
    return sum;
}

static struct channel make_channel(const struct sunsky *s, int channel, float elevation) {
    float albedos[3] = {s->albedo.x, s->albedo.y, s->albedo.z};
    float albedo = fminf(fmaxf(albedos[channel], 0), 1);
    float t = cbrtf(elevation * (2 / PI_F));
    struct channel out;
    for (int i = 0; i < PARAMETERS; i++)
        out.p[i] = look_up(sunsky_parameters, PARAMETERS, i, channel, s->turbidity, albedo, t);
    out.radiance = look_up(sunsky_radiance, 1, 0, channel, s->turbidity, albedo, t);
    return out;
}

/* Eq. 8; gamma: angle to the sun, radians. */
static float sky_radiance(const struct channel *c, float cos_theta, float gamma) {
    const float *p = c->p;
    float cos_gamma = cosf(gamma), cos2 = cos_gamma * cos_gamma;
    float chi = (1 + cos2) / powf(fmaxf(1 + p[8] * p[8] - 2 * p[8] * cos_gamma, 1e-6f), 1.5f);
    float gradient = 1 + p[0] * expf(p[1] / (cos_theta + 0.01f));
    float glow =
        p[2] + p[3] * expf(p[4] * gamma) + p[5] * cos2 + p[6] * chi + p[7] * sqrtf(cos_theta);
    return fmaxf(0, gradient * glow * c->radiance);
}

/* The sun's mean radiance (Hosek and Wilkie 2013), linear between the table's elevations 2, 5, 8,
 * ... degrees and constant beyond, as Mitsuba has it. */
static float sun_radiance(float turbidity, float elevation, int channel) {
    float share, at = fminf(fmaxf((elevation * (180 / PI_F) - 2) / 3, 0), ELEVATIONS - 1);
    int cell = turbidity_cell(turbidity, &share);
    int i = at < ELEVATIONS - 2 ? (int)at : ELEVATIONS - 2;
    const float *v = sunsky_sun + (cell * ELEVATIONS + i) * CHANNELS + channel;
    const float *w = v + ELEVATIONS * CHANNELS;
    float f = at - (float)i;
    float low = (1 - share) * v[0] + share * w[0];
    return low + f * ((1 - share) * v[CHANNELS] + share * w[CHANNELS] - low);
}

static void make_sun(const struct sunsky *s, float elevation, struct light *sun) {
    float half = 0.5f * s->sun_aperture * PI_F / 180;
    float ratio = sinf(0.5f * DATA_HALF_ANGLE) / sinf(0.5f * half);
    float factor = s->sun_scale * RADIANCE_SCALE * ratio * ratio;
    *sun = (struct light){.kind = LIGHT_SUN, .direction = s->sun_direction, .cutoff = half};
    if (s->sun_direction.z >= 0)
        sun->intensity = scale(vec(fmaxf(0, sun_radiance(s->turbidity, elevation, 0)),
                                   fmaxf(0, sun_radiance(s->turbidity, elevation, 1)),
                                   fmaxf(0, sun_radiance(s->turbidity, elevation, 2))),
                               factor);
}

static void fill_row(const struct sunsky *s, const struct channel channels[3], int y,
                     struct fewray_image *image) {
    float theta = (float)y / (float)(image->height - 1) * PI_F;
    float cos_theta = cosf(theta), sin_theta = sinf(theta);
    for (int x = 0; x < image->width; x++) {
        float phi = ((float)x + 0.5f) / (float)image->width * 2 * PI_F;
        /* The map's (x, y, z) = (sin phi sin theta, cos theta, -cos phi sin theta). */
        struct vec3 d = vec(sinf(phi) * sin_theta, cosf(phi) * sin_theta, cos_theta);
        float gamma = angle_between(d, s->sun_direction);
        float *p = image->floats + ((size_t)y * (size_t)image->width + (size_t)x) * CHANNELS;
        for (int c = 0; c < CHANNELS; c++)
            p[c] = s->sky_scale * RADIANCE_SCALE * sky_radiance(&channels[c], cos_theta, gamma);
    }
}

int sunsky_create(const struct sunsky *s, struct fewray_image **out, struct light *sun,
                  struct fewray_error *error) {
    struct fewray_image *image = calloc(1, sizeof(*image));
    *out = NULL;
    if (image)
        image->floats = calloc((size_t)ROWS * 2 * ROWS * CHANNELS, sizeof(float));
    if (!image || !image->floats) {
        fewray_image_destroy(&image);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the sky");
    }
    image->width = 2 * ROWS;
    image->height = ROWS;
    image->channels = CHANNELS;
    float elevation = asinf(fminf(s->sun_direction.z, 1));
    make_sun(s, elevation, sun);
    if (s->sun_direction.z >= 0) {
        struct channel channels[3];
        for (int c = 0; c < CHANNELS; c++)
            channels[c] = make_channel(s, c, elevation);
#pragma omp parallel for schedule(static)
        for (int y = 0; y < ROWS / 2; y++)
            fill_row(s, channels, y, image);
    }
    *out = image;
    return FEWRAY_OK;
}
