/* SPDX-License-Identifier: Apache-2.0 */
/* fewray-odis-data: training maps for the guide. For random grid points of each scene it writes
 * what the network gets (made by the shipped gather code) and the truth, traced with a few samples
 * in every bin (paper, section 4.3).
 *
 *     fewray-odis-data -o FILE [--maps N] [--samples N] [--seed S] [--width W]
 *                      [--initials N,N,...] [--threads N] [--paper] SCENE.xml...
 *
 * --paper: the look as the paper's guide sees it (fewray_render_settings_paper()), a map for each
 * block and nothing pooled. The truth still gets help from probes: its mean is the same with less
 * noise, which L1 doesn't forgive. The root second moment isn't that of a render then.
 *
 * FILE: "ODISDATA", uint32 version 2, uint32 bytes a record, then records, scene after scene in
 * ascending order; within a scene their order depends on the threads. The first scene has number 0.
 */

#include <getopt.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

#include "guide/odis/gather.h"
#include "guide/trace/film.h"
#include "guide/train/truth.h"

#define HALF_PLANES     (GATHER_PLANES + 3)
#define MAX_INITIALS    16
#define TARGET_MAXIMUM  32768.0f /* of a record's stored targets: most of a half float's range */
#define ALONE_SAMPLES   8        /* look samples from which a block needs no neighbours' records */
#define STREAM_INITIALS 0x696e6974u
#define STREAM_WINDOW   0x77696e64u

/* Little endian, no padding. */
struct record {
    uint32_t scene, x, y; /* the reference pixel */
    uint32_t samples;     /* a pixel, of the look */
    uint32_t window;      /* blocks a side that were gathered */
    float target_scale;   /* times the stored targets: relative to the gathered scale */
    _Float16 input[HALF_PLANES][SPHERE_BINS]; /* gathered planes, mask, cosine, fill */
    _Float16 target[2][SPHERE_BINS];          /* mean radiance, root second moment of a sample */
};

struct options {
    const char *output;
    int maps, samples, width, threads;
    int initials[MAX_INITIALS], initial_count;
    uint32_t seed;
    bool paper;
};

/* A grid point: the pixel that stands for it, and the blocks that are gathered around it. */
struct place {
    int x, y, window;
    int i0, j0, i1, j1; /* blocks i0 <= i < i1, j0 <= j < j1 */
};

static void to_half(const float *from, float factor, _Float16 *to) {
    for (int b = 0; b < SPHERE_BINS; b++)
        to[b] = (_Float16)fminf(fmaxf(from[b] * factor, -60000), 60000);
}

/* Middle pixel of a cell of blocks, which the picture may cut. */
static int middle(int index, int cell, int size) {
    int begin = index * cell, end = begin + cell;
    return (begin + (end < size ? end : size)) / 2;
}

/* Grid points as maps.c places them: on a block, or, a quarter of them, on an
 * aligned group of 2x2 blocks as flat areas share a map (share). Few look samples: a ring of blocks
 * around counts too. */
static struct place random_place(const struct fewray_look *look, bool share, uint32_t seed) {
    int size = share && hash_combine(seed, STREAM_WINDOW) % 4 == 0 ? 2 : 1;
    int ring = look->samples < ALONE_SAMPLES ? 1 : 0;
    int cell = size * BLOCK_SIZE;
    int columns = (look->width + cell - 1) / cell, rows = (look->height + cell - 1) / cell;
    int column = (int)(hash_combine(seed, 1) % (uint32_t)columns);
    int row = (int)(hash_combine(seed, 2) % (uint32_t)rows);
    return (struct place){.x = middle(column, cell, look->width),
                          .y = middle(row, cell, look->height),
                          .window = size + 2 * ring,
                          .i0 = column * size - ring,
                          .j0 = row * size - ring,
                          .i1 = (column + 1) * size + ring,
                          .j1 = (row + 1) * size + ring};
}

static void trace_bin(const struct integrator *in, const struct gathered *g, int bin, int samples,
                      uint32_t seed, float target[2][SPHERE_BINS]) {
    struct truth_bin truth = truth_bin(in, g->position, g->normal, bin, samples, seed);
    target[0][bin] = (float)(truth.mean / g->scale);
    target[1][bin] = (float)(truth.root_moment / g->scale);
}

/* False where no light arrives: that teaches nothing, the map falls back to the BSDF there. */
static bool make_record(const struct integrator *in, const struct gathered *g,
                        const struct options *o, uint32_t seed, struct record *record) {
    for (int p = 0; p < GATHER_PLANES; p++)
        to_half(g->planes[p], 1, record->input[p]);
    to_half(g->mask, 1, record->input[GATHER_PLANES]);
    to_half(g->cosine, 1, record->input[GATHER_PLANES + 1]);
    to_half(g->fill, 1, record->input[GATHER_PLANES + 2]);
    float target[2][SPHERE_BINS] = {{0}}, largest = 0, largest_moment = 0;
    for (int b = 0; b < SPHERE_BINS; b++)
        if (g->cosine[b] > 0) {
            trace_bin(in, g, b, o->samples, seed, target);
            largest_moment = fmaxf(largest_moment, target[1][b]);
            largest = fmaxf(largest, fmaxf(target[0][b], target[1][b]));
        }
    record->target_scale = largest / TARGET_MAXIMUM;
    if (!(largest_moment > 0) || !(record->target_scale > 0) || !isfinite(1 / record->target_scale))
        return false;
    for (int t = 0; t < 2; t++)
        to_half(target[t], 1 / record->target_scale, record->target[t]);
    return true;
}

/* What a render does between the look and the maps, so that training sees the same inputs and the
 * same estimates: the integrator as it will run. */
static int setup_guiding(const struct fewray_world *world, const struct fewray_film *film,
                         const struct fewray_render_settings *settings, bool paper,
                         struct fewray_look *look, struct integrator *in, struct probes **probes,
                         struct fewray_error *error) {
    *in = film_integrator(world, film, settings);
    int status = probes_create(look, film_threads(settings), probes, error);
    in->guides.probes = *probes;
    if (paper)
        probes_do_without(look, film_threads(settings));
    return status;
}

/* Writes up to o->maps records of random grid points; returns their number. */
static int write_maps(const struct integrator *in, const struct fewray_look *look,
                      const struct fewray_render_settings *settings, const struct options *o,
                      uint32_t scene, FILE *file) {
    int written = 0;
#pragma omp parallel for schedule(dynamic) num_threads(film_threads(settings))
    for (int i = 0; i < o->maps; i++) {
        uint32_t seed = hash_combine(hash_combine((uint32_t)settings->seed, scene), (uint32_t)i);
        struct record *record = malloc(sizeof(*record));
        struct gathered *g = malloc(sizeof(*g));
        if (record && g) {
            struct place p = random_place(look, !o->paper, seed);
            record->scene = scene;
            record->x = (uint32_t)p.x;
            record->y = (uint32_t)p.y;
            record->samples = (uint32_t)look->samples;
            record->window = (uint32_t)p.window;
            gather(look, p.i0, p.j0, p.i1, p.j1, p.x, p.y, g);
            if (g->valid && make_record(in, g, o, seed, record)) {
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
    struct probes *probes = NULL;
    struct integrator in;
    struct fewray_render_settings settings;
    struct fewray_render_stats stats = {0};
    fewray_render_settings_init(&settings);
    uint32_t seed = hash_combine(o->seed, index);
    settings.seed = seed;
    settings.width = o->width;
    settings.threads = o->threads;
    settings.initial = settings.spp =
        o->initials[hash_combine(seed, STREAM_INITIALS) % (uint32_t)o->initial_count];
    int status = fewray_scene_load(path, NULL, &scene, error);
    if (!status)
        status = fewray_world_create(scene, o->threads, &world, error);
    if (!status)
        status = fewray_film_create(world, &settings, &film, error);
    if (!status)
        status = fewray_trace_look(world, &settings, film, &look, &stats, error);
    if (!status)
        status = setup_guiding(world, film, &settings, o->paper, look, &in, &probes, error);
    if (!status)
        printf("%s: %d maps, %d spp\n", path, write_maps(&in, look, &settings, o, index, file),
               settings.initial);
    probes_destroy(&probes);
    fewray_look_destroy(&look);
    fewray_film_destroy(&film);
    fewray_world_destroy(&world);
    fewray_scene_destroy(&scene);
    return status;
}

/* "1,1,2,8" */
static int parse_initials(const char *text, struct options *o) {
    o->initial_count = 0;
    for (const char *at = text; o->initial_count < MAX_INITIALS; at++) {
        char *end;
        long n = strtol(at, &end, 10);
        if (end == at || n < 1 || n > 4096)
            return -1;
        o->initials[o->initial_count++] = (int)n;
        if (!*end)
            return 0;
        if (*end != ',')
            return -1;
        at = end;
    }
    return -1;
}

static int parse(int argc, char **argv, struct options *o) {
    static const struct option names[] = {{"maps", 1, NULL, 'm'},     {"samples", 1, NULL, 's'},
                                          {"seed", 1, NULL, 'r'},     {"width", 1, NULL, 'w'},
                                          {"initials", 1, NULL, 'i'}, {"threads", 1, NULL, 't'},
                                          {"paper", 0, NULL, 'p'},    {NULL, 0, NULL, 0}};
    *o =
        (struct options){.maps = 100, .samples = 4, .initials = {1}, .initial_count = 1, .seed = 1};
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
            if (parse_initials(optarg, o))
                return -1;
            break;
        case 't':
            o->threads = atoi(optarg);
            break;
        case 'p':
            o->paper = true;
            break;
        default:
            return -1;
        }
    }
    return o->output && optind < argc && o->maps > 0 && o->samples > 0 && o->threads >= 0 ? 0 : -1;
}

int main(int argc, char **argv) {
    struct options o;
    if (parse(argc, argv, &o)) {
        fprintf(stderr,
                "usage: %s -o FILE [--maps N] [--samples N] [--seed S] [--width PIXELS]\n"
                "       [--initials SPP,SPP,...] [--threads N] [--paper] SCENE.xml...\n",
                argv[0]);
        return 2;
    }
    FILE *file = fopen(o.output, "wb");
    if (!file) {
        fprintf(stderr, "%s: can't be written\n", o.output);
        return 1;
    }
    const uint32_t head[2] = {2, sizeof(struct record)};
    fwrite("ODISDATA", 8, 1, file);
    fwrite(head, sizeof(head), 1, file);
    for (int i = optind; i < argc; i++) {
        struct fewray_error error;
        char text[1100];
        if (make_scene(argv[i], (uint32_t)(i - optind), &o, file, &error))
            fprintf(stderr, "skipped: %s\n", fewray_error_text(&error, text, sizeof(text)));
    }
    bool failed = ferror(file) != 0;
    failed |= fclose(file) != 0;
    if (failed)
        fprintf(stderr, "%s: writing failed\n", o.output);
    return failed;
}
