/* SPDX-License-Identifier: Apache-2.0 */
/* fewray-draw-map: what the guide knows at one pixel, beside the truth.
 *
 *     fewray-draw-map -o OUT.png --pixel X,Y [--width W] [--spp N] [--samples N] [--seed S]
 *                     [--threads N] [--guide-weights FILE] SCENE
 *
 * Draws five panels, left to right: the picture (guided at --spp, denoised) with a cross at the
 * pixel; the first look's bins around it; these with their holes filled from coarser ones; the map
 * that the network made of it, as samples are drawn from it there; and the true one, traced by
 * --samples in each bin. The last four show densities over the sphere (1/sr, logarithmic, 0.003
 * black to 30 white), rows from +y down to -y, columns around y: dark grey lies below the horizon,
 * light grey had no sample. All are times the cosine. Prints what their noise is, relative to the
 * true one's. */

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fewray/denoise.h"
#include "guide/odis/gather.h"
#include "guide/odis/maps.h"
#include "guide/trace/film.h"
#include "guide/train/truth.h"

enum { PANELS = 4, GAP = 8, CROSS = 9, BELOW = 0x2b2f36, EMPTY = 0x7d838c, PAPER = 0xffffff };
#define DARKEST   0.003f /* 1/sr */
#define BRIGHTEST 30.0f

struct options {
    const char *scene, *output, *weights;
    int x, y, width, spp, samples, seed, threads;
};

/* A panel: values up to a factor, made a density; negative: no sample. */
struct panel {
    float density[SPHERE_BINS];
};

struct drawing {
    struct fewray_scene *scene;
    struct fewray_world *world;
    struct fewray_film *film;
    struct fewray_look *look;
    struct fewray_maps *maps;
    struct fewray_frame *frame;
    struct gathered g;
    struct panel panels[PANELS]; /* look, fill, map, truth */
    float bsdf_fraction;
};

static void normalize_panel(struct panel *p) {
    double sum = 0;
    for (int b = 0; b < SPHERE_BINS; b++)
        sum += fmaxf(p->density[b], 0);
    for (int b = 0; b < SPHERE_BINS && sum > 0; b++)
        p->density[b] *=
            p->density[b] > 0 ? (float)(1 / (sum * (double)SPHERE_BIN_SOLID_ANGLE)) : 1;
}

static void fill_panels(struct drawing *d, const struct options *o) {
    struct fewray_render_settings settings;
    fewray_render_settings_init(&settings);
    struct integrator in = film_integrator(d->world, d->film, &settings);
    in.guides.probes = d->maps->probes;
    const struct gathered *g = &d->g;
    const struct map_mixture mixture = maps_at(d->maps, o->x, o->y, g->position, g->normal);
    d->bsdf_fraction = mixture.bsdf_fraction;
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < SPHERE_BINS; b++) {
        const struct vec3 centre =
            sphere_direction(b / SPHERE_COLUMNS, b % SPHERE_COLUMNS, 0.5f, 0.5f);
        const float cosine = g->cosine[b];
        const float moment = range_expand(g->planes[GATHER_POOLED_MOMENT][b]);
        struct truth_bin truth = {0, 0, 0};
        if (cosine > 0)
            truth = truth_bin(&in, g->position, g->normal, b, o->samples, (uint32_t)o->seed);
        d->panels[0].density[b] = g->mask[b] > 0 ? cosine * moment : -1;
        d->panels[1].density[b] = cosine * expf(g->fill[b]);
        d->panels[2].density[b] = mixture.count ? map_mixture_pdf(&mixture, centre) : 0;
        d->panels[3].density[b] = cosine * (float)truth.root_moment;
    }
    for (int p = 0; p < PANELS; p++)
        normalize_panel(&d->panels[p]);
}

/* Second moment of samples that are drawn from a density, with this share from the cosine, over the
 * least possible, that of the true density t: integral of t^2 / (a q + (1 - a) p). */
static double noise(const struct drawing *d, const struct panel *p, float a) {
    double sum = 0;
    for (int b = 0; b < SPHERE_BINS; b++) {
        const double t = (double)d->panels[3].density[b], q = (double)(d->g.cosine[b] / PI_F);
        const double pdf = (double)a * q + (1 - (double)a) * (p ? (double)p->density[b] : 0);
        sum += t > 0 && pdf > 0 ? t * t / pdf : 0;
    }
    return sum * (double)SPHERE_BIN_SOLID_ANGLE;
}

/* Black, violet, red, yellow, white. */
static void heat(float density, uint8_t rgb[3]) {
    static const float anchors[5][3] = {
        {0, 0, 0}, {80, 18, 123}, {205, 60, 60}, {252, 180, 50}, {255, 255, 230}};
    float t = logf(fmaxf(density, DARKEST) / DARKEST) / logf(BRIGHTEST / DARKEST) * 4;
    t = fminf(t, 3.999f);
    const int k = (int)t;
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint8_t)(anchors[k][c] + (t - (float)k) * (anchors[k + 1][c] - anchors[k][c]));
}

static void put(uint8_t *rgb, int color) {
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint8_t)(color >> (16 - 8 * c));
}

static uint8_t encode(float linear) {
    const float x = fminf(fmaxf(linear, 0), 1);
    const float y = x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
    return (uint8_t)(255 * y + 0.5f);
}

static void draw_picture(const struct drawing *d, const struct options *o, int pitch,
                         uint8_t *rgb) {
    const struct fewray_frame *f = d->frame;
    float *color[3];
    fewray_frame_layer(f, FEWRAY_COLOR, color);
    for (int y = 0; y < f->height; y++)
        for (int x = 0; x < f->width; x++) {
            uint8_t *out = rgb + 3 * ((size_t)y * (size_t)pitch + (size_t)x);
            const int dx = abs(x - o->x), dy = abs(y - o->y);
            const bool cross = dx <= CROSS && dy <= CROSS && dx + dy > 2 && (dx <= 1 || dy <= 1);
            for (int c = 0; c < 3; c++)
                out[c] = encode(color[c][(size_t)y * (size_t)f->width + (size_t)x]);
            if (cross)
                put(out, dx == 0 || dy == 0 ? 0xff2d55 : 0xffffff);
        }
}

static void draw_panel(const struct drawing *d, int p, int cell, int pitch, uint8_t *rgb) {
    for (int y = 0; y < cell * SPHERE_ROWS; y++)
        for (int x = 0; x < cell * SPHERE_COLUMNS; x++) {
            const int b = y / cell * SPHERE_COLUMNS + x / cell;
            uint8_t *out = rgb + 3 * ((size_t)y * (size_t)pitch + (size_t)x);
            const float density = d->panels[p].density[b];
            if (!(d->g.cosine[b] > 0))
                put(out, BELOW);
            else if (density < 0)
                put(out, EMPTY);
            else
                heat(density, out);
        }
}

static int draw(const struct drawing *d, const struct options *o, struct fewray_error *error) {
    const int cell = d->frame->height >= SPHERE_ROWS ? d->frame->height / SPHERE_ROWS : 1;
    const int side = cell * SPHERE_ROWS, first = d->frame->width + GAP;
    const int pitch = first + PANELS * (side + GAP) - GAP;
    const int height = d->frame->height > side ? d->frame->height : side;
    uint8_t *rgb = malloc(3 * (size_t)pitch * (size_t)height);
    if (!rgb)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the drawing");
    memset(rgb, PAPER & 0xff, 3 * (size_t)pitch * (size_t)height);
    draw_picture(d, o, pitch, rgb);
    for (int p = 0; p < PANELS; p++)
        draw_panel(d, p, cell, pitch, rgb + 3 * (size_t)(first + p * (side + GAP)));
    const int status = fewray_image_write_png(o->output, pitch, height, rgb, error);
    free(rgb);
    return status;
}

static int denoise(const struct options *o, struct fewray_frame *frame,
                   struct fewray_error *error) {
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    fewray_denoise_options_init(&options);
    options.threads = o->threads;
    int status = fewray_denoiser_create(&options, &denoiser, error);
    status = status ? status : fewray_denoise_frame(denoiser, frame, NULL, error);
    fewray_denoiser_destroy(&denoiser);
    return status;
}

/* What a render does up to the maps, and the records around the pixel. */
static int guide(const struct options *o, struct fewray_render_settings *settings,
                 struct drawing *d, struct fewray_render_stats *stats, struct fewray_error *error) {
    int width, height;
    int status = fewray_scene_load(o->scene, NULL, &d->scene, error);
    status = status ? status : fewray_world_create(d->scene, o->threads, &d->world, error);
    status = status ? status : fewray_film_create(d->world, settings, &d->film, error);
    if (status)
        return status;
    fewray_film_size(d->film, &width, &height);
    if (o->x >= width || o->y >= height)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "--pixel %d,%d lies outside of %dx%d pixels", o->x, o->y, width, height);
    status = fewray_trace_look(d->world, settings, d->film, &d->look, stats, error);
    status = status ? status : fewray_maps_create(d->look, settings, &d->maps, stats, error);
    if (status)
        return status;
    const int i = o->x / BLOCK_SIZE, j = o->y / BLOCK_SIZE;
    gather(d->look, i - 1, j - 1, i + 2, j + 2, o->x, o->y, &d->g);
    return d->g.valid ? FEWRAY_OK
                      : fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                                    "the look found no lit surface at --pixel %d,%d", o->x, o->y);
}

static int run(const struct options *o, struct drawing *d, struct fewray_error *error) {
    struct fewray_render_settings settings;
    struct fewray_render_stats stats = {0};
    fewray_render_settings_init(&settings);
    settings.width = o->width;
    settings.spp = o->spp;
    settings.initial = 1;
    settings.seed = (uint64_t)o->seed;
    settings.threads = o->threads;
    settings.weights_path = o->weights;
    settings.refine = false; /* the map is drawn as the network made it */
    int status = guide(o, &settings, d, &stats, error);
    status =
        status ? status : fewray_trace_rest(d->world, d->maps, &settings, d->film, &stats, error);
    status = status ? status : fewray_trace_edges(d->world, &settings, d->film, &stats, error);
    status = status ? status : fewray_film_frame(d->film, d->maps, &d->frame, error);
    status = status ? status : denoise(o, d->frame, error);
    if (status)
        return status;
    fill_panels(d, o);
    printf("noise at pixel %d,%d over the least possible: cosine %.2f, filled look %.2f, map %.2f "
           "(%.0f %% of its samples by the BSDF)\n",
           o->x, o->y, noise(d, NULL, 1), noise(d, &d->panels[1], 0.25f),
           noise(d, &d->panels[2], d->bsdf_fraction), 100 * (double)d->bsdf_fraction);
    return draw(d, o, error);
}

static bool parse(int argc, char **argv, struct options *o) {
    static const struct option names[] = {
        {"output", 1, NULL, 'o'},  {"pixel", 1, NULL, 'p'},         {"width", 1, NULL, 'w'},
        {"spp", 1, NULL, 'n'},     {"samples", 1, NULL, 's'},       {"seed", 1, NULL, 'r'},
        {"threads", 1, NULL, 't'}, {"guide-weights", 1, NULL, 'g'}, {NULL, 0, NULL, 0}};
    *o = (struct options){.width = 448, .spp = 16, .samples = 256, .seed = 1, .x = -1};
    char end;
    for (int c; (c = getopt_long(argc, argv, "o:", names, NULL)) != -1;) {
        if (c == 'o')
            o->output = optarg;
        else if (c == 'g')
            o->weights = optarg;
        else if (c == 'p' && sscanf(optarg, "%d,%d%c", &o->x, &o->y, &end) != 2)
            return false;
        else if (c == 'w')
            o->width = atoi(optarg);
        else if (c == 'n')
            o->spp = atoi(optarg);
        else if (c == 's')
            o->samples = atoi(optarg);
        else if (c == 'r')
            o->seed = atoi(optarg);
        else if (c == 't')
            o->threads = atoi(optarg);
        else if (c == '?')
            return false;
    }
    if (!o->output || optind + 1 != argc)
        return false;
    o->scene = argv[optind];
    return o->x >= 0 && o->y >= 0 && o->width > 0 && o->spp > 0 && o->samples > 0 &&
           o->threads >= 0;
}

int main(int argc, char **argv) {
    struct options o;
    if (!parse(argc, argv, &o)) {
        fprintf(stderr,
                "usage: %s -o OUT.png --pixel X,Y [--width W] [--spp N] [--samples N] [--seed S]\n"
                "       [--threads N] [--guide-weights FILE] SCENE\n",
                argv[0]);
        return 2;
    }
    struct fewray_error error;
    char text[1100];
    struct drawing *d = calloc(1, sizeof(*d));
    int status = d ? run(&o, d, &error)
                   : fewray_fail(&error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the drawing");
    if (status)
        fprintf(stderr, "fewray-draw-map: %s\n", fewray_error_text(&error, text, sizeof(text)));
    if (d) {
        fewray_frame_destroy(&d->frame);
        if (d->maps)
            fewray_maps_destroy(&d->maps);
        fewray_look_destroy(&d->look);
        fewray_film_destroy(&d->film);
        fewray_world_destroy(&d->world);
        fewray_scene_destroy(&d->scene);
    }
    free(d);
    return status ? 1 : 0;
}
