/* SPDX-License-Identifier: Apache-2.0 */
/* fewray-odis-data: training maps for the guide. For random grid points of each scene it writes
 * what the network gets (made by the shipped gather code) and the truth, traced with many samples
 * in every bin (paper, section 4.3).
 *
 *     fewray-odis-data -o FILE [--maps N] [--samples N] [--seed S] [--width W] [--initial N]
 * SCENE.xml...
 *
 * FILE: "ODISDATA", uint32 version, uint32 bytes a record, then records: uint32 scene, x, y, look
 * samples a pixel; half floats planes (10, 32, 32), mask, cosine, fill (each 32, 32); floats mean
 * radiance (32, 32) and root of the second moment (32, 32), both divided by the gathered scale. */

#include <getopt.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "guide/odis/gather.h"
#include "guide/odis/maps.h"
#include "guide/trace/film.h"

#define HALF_PLANES (GATHER_PLANES + 3)

struct record {
    uint32_t scene, x, y, samples;
    _Float16 input[HALF_PLANES][SPHERE_BINS];
    float target[2][SPHERE_BINS];
};

struct options {
    const char *output;
    int maps, samples, width, initial;
    uint32_t seed;
};

static void to_half(const float *from, _Float16 *to) {
    for (int b = 0; b < SPHERE_BINS; b++)
        to[b] = (_Float16)fminf(fmaxf(from[b], -60000), 60000);
}

/* The truth of one bin: uniform directions within it, each with one estimate of the radiance that
 * arrives. */
static void trace_bin(const struct integrator *in, const struct gathered *g, int bin, int samples,
                      uint32_t seed, float target[2][SPHERE_BINS]) {
    double mean = 0, moment = 0;
    int used = 0;
    for (int s = 0; s < samples; s++) {
        struct sampler sampler = sampler_start(hash_combine(seed, (uint32_t)bin), (uint32_t)s);
        float u[2];
        sampler_2d(&sampler, u);
        struct vec3 direction =
            sphere_direction(bin / SPHERE_COLUMNS, bin % SPHERE_COLUMNS, u[0], u[1]);
        struct incident i = trace_incident(in, &sampler, g->position, g->normal, direction,
                                           0.5f / PI_F, 1, vec(1, 1, 1));
        float full = mean_component(i.full), weighted = mean_component(i.radiance);
        if (!isfinite(full) || !isfinite(weighted))
            continue;
        mean += full;
        moment += (double)weighted * weighted;
        used++;
    }
    if (used) {
        target[0][bin] = (float)(mean / used / g->scale);
        target[1][bin] = (float)(sqrt(moment / used) / g->scale);
    }
}

static void make_record(const struct integrator *in, const struct gathered *g,
                        const struct options *o, uint32_t seed, struct record *record) {
    for (int p = 0; p < GATHER_PLANES; p++)
        to_half(g->planes[p], record->input[p]);
    to_half(g->mask, record->input[GATHER_PLANES]);
    to_half(g->cosine, record->input[GATHER_PLANES + 1]);
    to_half(g->fill, record->input[GATHER_PLANES + 2]);
    for (int b = 0; b < SPHERE_BINS; b++) {
        record->target[0][b] = record->target[1][b] = 0;
        if (g->cosine[b] > 0)
            trace_bin(in, g, b, o->samples, seed, record->target);
    }
}

/* Writes up to o->maps records of random grid points; returns their number. */
static int write_maps(const struct fewray_world *world, const struct fewray_look *look,
                      const struct fewray_film *film, const struct fewray_render_settings *settings,
                      const struct options *o, uint32_t scene, FILE *file) {
    struct integrator in = film_integrator(world, film, NULL, settings);
    int written = 0;
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < o->maps; i++) {
        uint32_t seed = hash_combine(hash_combine((uint32_t)settings->seed, scene), (uint32_t)i);
        struct record *record = malloc(sizeof(*record));
        struct gathered *g = malloc(sizeof(*g));
        if (record && g) {
            record->scene = scene;
            record->x = hash_combine(seed, 1) % (uint32_t)look->width;
            record->y = hash_combine(seed, 2) % (uint32_t)look->height;
            record->samples = (uint32_t)look->samples;
            gather(look, (int)record->x, (int)record->y, g);
            if (g->valid) {
                make_record(&in, g, o, seed, record);
#pragma omp critical(write_record)
                written += fwrite(record, sizeof(*record), 1, file) == 1;
            }
        }
        free(record);
        free(g);
    }
    return written;
}

static int make_scene(const char *path, uint32_t index, const struct options *o, FILE *file,
                      struct fewray_error *error) {
    struct fewray_scene *scene = NULL;
    struct fewray_world *world = NULL;
    struct fewray_film *film = NULL;
    struct fewray_look *look = NULL;
    struct fewray_render_settings settings;
    struct fewray_render_stats stats = {0};
    fewray_render_settings_init(&settings);
    settings.seed = hash_combine(o->seed, index);
    settings.width = o->width;
    settings.initial = settings.spp = o->initial;
    int status = fewray_scene_load(path, NULL, &scene, error);
    if (!status)
        status = fewray_world_create(scene, 0, &world, error);
    if (!status)
        status = fewray_film_create(world, &settings, &film, error);
    if (!status)
        status = fewray_trace_look(world, &settings, film, &look, &stats, error);
    if (!status)
        printf("%s: %d maps\n", path, write_maps(world, look, film, &settings, o, index, file));
    fewray_look_destroy(&look);
    fewray_film_destroy(&film);
    fewray_world_destroy(&world);
    fewray_scene_destroy(&scene);
    return status;
}

static int parse(int argc, char **argv, struct options *o) {
    static const struct option names[] = {{"maps", 1, NULL, 'm'},    {"samples", 1, NULL, 's'},
                                          {"seed", 1, NULL, 'r'},    {"width", 1, NULL, 'w'},
                                          {"initial", 1, NULL, 'i'}, {NULL, 0, NULL, 0}};
    *o = (struct options){.maps = 100, .samples = 16, .width = 0, .initial = 1, .seed = 1};
    for (int c; (c = getopt_long(argc, argv, "o:", names, NULL)) != -1;) {
        switch (c) {
        case 'o':
            o->output = optarg;
            break;
        case 'm':
            o->maps = atoi(optarg);
            break;
        case 's':
            o->samples = atoi(optarg);
            break;
        case 'r':
            o->seed = (uint32_t)atoi(optarg);
            break;
        case 'w':
            o->width = atoi(optarg);
            break;
        case 'i':
            o->initial = atoi(optarg);
            break;
        default:
            return -1;
        }
    }
    return o->output && optind < argc && o->maps > 0 && o->samples > 0 && o->initial > 0 ? 0 : -1;
}

int main(int argc, char **argv) {
    struct options o;
    if (parse(argc, argv, &o)) {
        fprintf(stderr,
                "usage: %s -o FILE [--maps N] [--samples N] [--seed S] [--width PIXELS] [--initial "
                "SPP] "
                "SCENE.xml...\n",
                argv[0]);
        return 2;
    }
    FILE *file = fopen(o.output, "wb");
    if (!file) {
        fprintf(stderr, "%s: can't be written\n", o.output);
        return 1;
    }
    const uint32_t head[2] = {1, sizeof(struct record)};
    fwrite("ODISDATA", 8, 1, file);
    fwrite(head, sizeof(head), 1, file);
    for (int i = optind; i < argc; i++) {
        struct fewray_error error;
        char text[1100];
        if (make_scene(argv[i], (uint32_t)(i - optind), &o, file, &error))
            fprintf(stderr, "skipped: %s\n", fewray_error_text(&error, text, sizeof(text)));
    }
    return fclose(file) ? 1 : 0;
}
