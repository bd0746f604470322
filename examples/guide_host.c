/* SPDX-License-Identifier: Apache-2.0 */
/* The guide in another renderer: guide_host [SAMPLES]
 *
 * A path tracer of its own, as small as can be: a closed room and an uplight, a disc near the
 * ceiling that shines on nothing else, so that light sampling finds little and all else depends on
 * bounces that happen to hit the bright spot. It traces a first look, has maps made of it, and
 * compares what the two estimators give: their means must agree, and the guided one is less noisy.
 */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "fewray/guiding.h"

enum {
    WIDTH = 96,
    HEIGHT = 64,
    PIXELS = WIDTH * HEIGHT,
    DEPTH = 3
}; /* DEPTH: surfaces of a path */

typedef float vec3[3];

static const float ROOM[2][3] = {{-2, 0, -3}, {2, 2.5f, 3}}, LAMP[3] = {1.2f, 1.6f, -2.2f};
static const float RADIUS = 0.15f, RADIANCE = 60, ALBEDO = 0.7f, PI = 3.14159265f;

static float random_float(uint64_t *state) { /* PCG (O'Neill 2014) */
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    const uint32_t x = (uint32_t)(((*state >> 18) ^ *state) >> 27), r = (uint32_t)(*state >> 59);
    return (float)(((x >> r) | (x << (-r & 31))) >> 8) / 16777216.0f;
}

static float dot(const vec3 a, const vec3 b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

struct hit {
    float distance;
    vec3 position, normal; /* the normal towards where the ray comes from */
    float emission;
    int lamp;
};

/* From inside the room there is always a hit; the lamp's lower side is black. */
static struct hit trace(const vec3 from, const vec3 d) {
    struct hit h = {.distance = INFINITY};
    for (int c = 0; c < 3; c++) {
        const float t = d[c] != 0 ? (ROOM[d[c] > 0][c] - from[c]) / d[c] : INFINITY;
        if (t < h.distance) {
            h = (struct hit){.distance = t};
            h.normal[c] = d[c] > 0 ? -1 : 1;
        }
    }
    const float t = d[1] != 0 ? (LAMP[1] - from[1]) / d[1] : INFINITY;
    const float x = from[0] + t * d[0] - LAMP[0], z = from[2] + t * d[2] - LAMP[2];
    if (t > 1e-4f && t < h.distance && x * x + z * z < RADIUS * RADIUS)
        h = (struct hit){t, {0}, {0, d[1] > 0 ? -1 : 1, 0}, d[1] < 0 ? RADIANCE : 0, 1};
    for (int c = 0; c < 3; c++)
        h.position[c] = from[c] + h.distance * d[c];
    return h;
}

/* (a, b, height) around the normal: the room's are along axes. */
static void around(const vec3 normal, float a, float b, float height, vec3 d) {
    const int axis = normal[0] != 0 ? 0 : normal[1] != 0 ? 1 : 2;
    d[axis] = height * normal[axis];
    d[(axis + 1) % 3] = a;
    d[(axis + 2) % 3] = b;
}

static void hemisphere(const vec3 normal, int uniform, uint64_t *state, vec3 d) {
    const float u = random_float(state), phi = 2 * PI * random_float(state);
    const float height = uniform ? u : sqrtf(u), r = sqrtf(fmaxf(0, 1 - height * height));
    around(normal, r * cosf(phi), r * sinf(phi), height, d);
}

/* Light sampling: a point of the lamp. Returns its radiance where it is seen; *pdf: solid angle. */
static float sample_lamp(const struct hit *h, uint64_t *state, vec3 d, float *pdf) {
    const float r = RADIUS * sqrtf(random_float(state)), phi = 2 * PI * random_float(state);
    const vec3 to = {LAMP[0] + r * cosf(phi) - h->position[0], LAMP[1] - h->position[1],
                     LAMP[2] + r * sinf(phi) - h->position[2]};
    const float distance = sqrtf(dot(to, to));
    for (int c = 0; c < 3; c++)
        d[c] = to[c] / distance;
    *pdf = -d[1] > 0 ? distance * distance / (-d[1] * PI * RADIUS * RADIUS) : 0;
    return *pdf > 0 && dot(d, h->normal) > 0 && trace(h->position, d).lamp ? RADIANCE : 0;
}

/* With what density sample_lamp() would have drawn the direction that hit the lamp. */
static float lamp_pdf(const struct hit *lamp, const vec3 d) {
    return lamp->emission > 0 ? lamp->distance * lamp->distance / (-d[1] * PI * RADIUS * RADIUS)
                              : 0;
}

static float power_heuristic(float pdf, float other) { /* Veach 1997, eq. 9.13 */
    return pdf > 0 ? pdf * pdf / (pdf * pdf + other * other) : 0;
}

/* Density of the mixture that fewray/guiding.h asks for. */
static float mixture_pdf(const struct fewray_guide_at *at, const vec3 normal, const vec3 d) {
    const float bsdf = fmaxf(0, dot(normal, d)) / PI;
    return at->bsdf_fraction >= 1
               ? bsdf
               : at->bsdf_fraction * bsdf + (1 - at->bsdf_fraction) * fewray_guide_pdf(at, d);
}

static void draw(const struct fewray_guide_at *at, const vec3 normal, uint64_t *state, vec3 d) {
    if (random_float(state) < at->bsdf_fraction) {
        hemisphere(normal, 0, state, d);
    } else {
        const float u[2] = {random_float(state), random_float(state)};
        fewray_guide_sample(at, u, d);
    }
}

/* Radiance that a surface reflects, its own emission left out. guide: NULL: path tracing. */
static float reflected(const struct fewray_guide *guide, int pixel, struct hit h, int depth,
                       uint64_t *state) {
    float sum = 0, throughput = 1;
    for (; depth < DEPTH && !h.lamp; depth++) {
        struct fewray_guide_at at = {.bsdf_fraction = 1};
        if (guide && depth == 0)
            at = fewray_guide_first(guide, pixel % WIDTH, pixel / WIDTH, h.position, h.normal);
        else if (guide)
            at = fewray_guide_later(guide, h.position, h.normal, depth + 1 == DEPTH);
        vec3 d;
        float light_pdf;
        const float light = sample_lamp(&h, state, d, &light_pdf);
        if (light > 0)
            sum += throughput * ALBEDO / PI * dot(d, h.normal) * light / light_pdf *
                   power_heuristic(light_pdf, mixture_pdf(&at, h.normal, d));
        draw(&at, h.normal, state, d);
        const float pdf = mixture_pdf(&at, h.normal, d), cosine = dot(d, h.normal);
        if (!(pdf > 0) || !(cosine > 0))
            break;
        throughput *= ALBEDO / PI * cosine / pdf;
        h = trace(h.position, d);
        sum += throughput * h.emission * power_heuristic(pdf, lamp_pdf(&h, d));
    }
    return sum;
}

static struct hit camera(int pixel, uint64_t *state) {
    const vec3 eye = {-1.2f, 1.2f, 2.8f};
    vec3 d = {((float)(pixel % WIDTH) + random_float(state)) / WIDTH - 0.5f,
              ((float)HEIGHT / 2 - (float)(pixel / WIDTH) - random_float(state)) / WIDTH, -0.6f};
    const float length = sqrtf(dot(d, d));
    for (int c = 0; c < 3; c++)
        d[c] /= length;
    return trace(eye, d);
}

/* The first look: its arrays, one record a pixel, grey. */
struct look {
    vec3 position[PIXELS], normal[PIXELS], direction[PIXELS], emitted[PIXELS], reflected[PIXELS],
        second_normal[PIXELS], light[PIXELS], bounce[PIXELS];
    float depth[PIXELS], light_pdf[PIXELS], distance[PIXELS], albedo[PIXELS], light_value[PIXELS],
        bounce_value[PIXELS];
};

static void copy(const vec3 from, vec3 to) {
    for (int c = 0; c < 3; c++)
        to[c] = from[c];
}

/* What the second vertex finds by its own two samples, for the probes. */
static void look_on(struct look *l, int i, const struct hit *second, uint64_t *state) {
    const struct fewray_guide_at plain = {.bsdf_fraction = 1};
    float light_pdf, value = 0;
    l->albedo[i] = ALBEDO;
    const float light = sample_lamp(second, state, l->light[i], &light_pdf);
    const float cosine = fmaxf(0, dot(l->light[i], second->normal));
    if (light_pdf > 0 && cosine > 0) {
        l->light_value[i] = light / (light_pdf + cosine / PI);
        if (light > 0)
            value =
                ALBEDO / PI * cosine * light / light_pdf * power_heuristic(light_pdf, cosine / PI);
    } else {
        l->light_value[i] = -1; /* none was drawn */
    }
    draw(&plain, second->normal, state, l->bounce[i]);
    const float pdf = dot(l->bounce[i], second->normal) / PI;
    const struct hit third = trace(second->position, l->bounce[i]);
    const float lamp = lamp_pdf(&third, l->bounce[i]);
    const float beyond = reflected(NULL, i, third, 2, state);
    l->bounce_value[i] = third.emission / (lamp + pdf) + beyond / pdf;
    value += ALBEDO * (third.emission * power_heuristic(pdf, lamp) + beyond);
    for (int c = 0; c < 3; c++)
        l->reflected[i][c] = value;
}

static void look_through(struct look *l, int i, uint64_t *state) {
    const struct hit first = camera(i, state);
    l->depth[i] = first.lamp ? 0 : first.distance;
    copy(first.position, l->position[i]);
    copy(first.normal, l->normal[i]);
    fewray_guide_look_direction(1, i % WIDTH, i / WIDTH, 0, first.normal, l->direction[i]);
    const struct hit second = trace(first.position, l->direction[i]);
    l->distance[i] = second.distance;
    copy(second.normal, l->second_normal[i]);
    for (int c = 0; c < 3; c++)
        l->emitted[i][c] = second.emission;
    l->light_pdf[i] = lamp_pdf(&second, l->direction[i]);
    if (!second.lamp)
        look_on(l, i, &second, state);
}

static int make_guide(struct fewray_guide **guide, struct fewray_error *error) {
    static struct look l;
    uint64_t state = 1;
    for (int i = 0; i < PIXELS; i++)
        look_through(&l, i, &state);
    const struct fewray_guide_look look = {.width = WIDTH,
                                           .height = HEIGHT,
                                           .samples = 1,
                                           .position = l.position[0],
                                           .normal = l.normal[0],
                                           .depth = l.depth,
                                           .direction = l.direction[0],
                                           .emitted = l.emitted[0],
                                           .light_pdf = l.light_pdf,
                                           .reflected = l.reflected[0],
                                           .distance = l.distance,
                                           .second_normal = l.second_normal[0],
                                           .second_albedo = l.albedo,
                                           .second_light = l.light[0],
                                           .second_light_value = l.light_value,
                                           .second_bounce = l.bounce[0],
                                           .second_bounce_value = l.bounce_value};
    struct fewray_guide_stats stats;
    const int status = fewray_guide_create(&look, NULL, guide, &stats, error);
    if (!status)
        printf("a look of %lld records makes %d maps and %d probes\n", stats.records, stats.maps,
               stats.probes);
    return status;
}

struct estimate {
    double mean, error; /* of the picture's radiance, and its standard error */
    double noise;       /* variance of one sample over its pixel's squared mean, mean over pixels */
};

static struct estimate measure(const struct fewray_guide *guide, int samples) {
    struct estimate e = {0, 0, 0};
    double variance_of_mean = 0;
    uint64_t state = guide ? 3 : 2;
    for (int i = 0; i < PIXELS; i++) {
        double sum = 0, squares = 0;
        for (int s = 0; s < samples; s++) {
            const double value = (double)reflected(guide, i, camera(i, &state), 0, &state);
            sum += value;
            squares += value * value;
        }
        const double mean = sum / samples, variance = (squares - sum * mean) / (samples - 1);
        e.mean += mean / PIXELS;
        variance_of_mean += variance / samples / PIXELS / PIXELS;
        e.noise += variance / (mean * mean + 1e-4) / PIXELS;
    }
    e.error = sqrt(variance_of_mean);
    return e;
}

int main(int argc, char **argv) {
    const int samples = argc > 1 ? atoi(argv[1]) : 64;
    struct fewray_guide *guide = NULL;
    struct fewray_error error;
    char text[1024];
    if (samples < 2) {
        fprintf(stderr, "usage: guide_host [SAMPLES], of each pixel, 2 or more (64)\n");
        return 2;
    }
    if (make_guide(&guide, &error)) {
        fprintf(stderr, "guide_host: %s\n", fewray_error_text(&error, text, sizeof text));
        return 1;
    }
    const struct estimate plain = measure(NULL, samples), guided = measure(guide, samples);
    fewray_guide_destroy(&guide);
    printf("path traced: mean radiance %.5f +- %.5f, noise (relative variance of a sample) %.3g\n"
           "guided:      mean radiance %.5f +- %.5f, noise %.3g: %.2f times less\n",
           plain.mean, plain.error, plain.noise, guided.mean, guided.error, guided.noise,
           plain.noise / guided.noise);
    const double apart = fabs(plain.mean - guided.mean) / hypot(plain.error, guided.error);
    printf("the means are %.2f standard errors apart\n", apart);
    return apart < 4 ? 0 : 1;
}
