/* SPDX-License-Identifier: Apache-2.0 */
/* fewray-true-maps: what maps could do at best. Renders with maps of the true mean radiance or root
 * second moment, traced in every bin of every grid point instead of inferred, and prints the
 * picture's error for each resolution of the maps (paper, figure 6).
 *
 *     fewray-true-maps [--map mean|moment] [--bins 8,16,32] [--spp 4,16,...] [--samples N]
 *                      [--fraction F] [--width W] [--seed S] [--seeds N] [--threads N]
 *                      SCENE.xml REFERENCE.exr
 *
 * All samples are guided: there is no look. --samples: traced in each of the 32 x 32 bins; coarser
 * maps are their averages. --fraction: of the samples for the BSDF (0). Prints one JSON object a
 * line; "bins" 0 is path tracing without a guide. The reference must have the picture's size.
 */

#include <getopt.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fewray/pipeline.h"
#include "guide/odis/gather.h"
#include "guide/odis/maps.h"
#include "guide/trace/film.h"
#include "guide/train/truth.h"

#define MAX_LIST     32
#define MOMENT_LEAST 1e-3f /* of the mean over the bins: no bin becomes unreachable */

struct int_list {
    int values[MAX_LIST], count;
};

struct options {
    bool moments;
    struct int_list bins, spp;
    int samples, width, seed, seeds, threads;
    float fraction;
    const char *scene, *reference;
};

/* Truth of one map, before the cosine. */
struct truth {
    bool valid;
    struct vec3 position, normal;
    float wanted[SPHERE_BINS];
};

struct study {
    struct fewray_scene *scene;
    struct fewray_world *world;
    struct fewray_frame *reference;
    struct truth *truths; /* (rows, columns) of blocks */
    int columns, rows;
};

/* The surface at the middle of a block; false where it shows none. */
static bool find_surface(const struct integrator *in, int x, int y, struct truth *t) {
    struct sampler sampler = sampler_start(hash_combine((uint32_t)x, (uint32_t)y), 0);
    struct look_record record;
    const struct path_notes notes = {.record = &record};
    const float u[2] = {0.5f, 0.5f};
    trace_look_path(in, x, y, &sampler, u, &notes);
    t->position = record.position;
    t->normal = record.normal;
    return record.depth > 0;
}

static void trace_truth(const struct integrator *in, int x, int y, const struct options *o,
                        struct truth *t) {
    t->valid = find_surface(in, x, y, t);
    if (!t->valid)
        return;
    float cosine[SPHERE_BINS], sum = 0;
    int above = 0;
    sphere_cosines(t->normal, cosine);
    uint32_t seed = hash_combine(hash_combine((uint32_t)x, (uint32_t)y), 0x74727574u);
    for (int b = 0; b < SPHERE_BINS; b++) {
        struct truth_bin truth = {0, 0, 0};
        if (cosine[b] > 0)
            truth = truth_bin(in, t->position, t->normal, b, o->samples, seed);
        t->wanted[b] = (float)(o->moments ? truth.root_moment : truth.mean);
        sum += t->wanted[b];
        above += cosine[b] > 0;
    }
    t->valid = sum > 0;
    float least = above ? MOMENT_LEAST * sum / (float)above : 0;
    for (int b = 0; b < SPHERE_BINS; b++)
        if (cosine[b] > 0)
            t->wanted[b] = fmaxf(t->wanted[b], least);
}

static struct fewray_render_settings render_settings(const struct options *o, int spp, int seed) {
    struct fewray_render_settings s;
    fewray_render_settings_init(&s);
    s.width = o->width;
    s.threads = o->threads;
    s.spp = spp;
    s.seed = (uint64_t)seed;
    s.initial = 0; /* nothing looked before: all samples are the maps' */
    s.probes = s.refine = false;
    return s;
}

static int trace_truths(struct study *study, const struct options *o, struct fewray_error *error) {
    struct fewray_render_settings settings = render_settings(o, 1, o->seed);
    struct fewray_film *film = NULL;
    int status = fewray_film_create(study->world, &settings, &film, error);
    if (status)
        return status;
    const struct integrator in = film_integrator(study->world, film, &settings);
    int width = film->width, height = film->height;
    fewray_film_destroy(&film);
    study->columns = (width + BLOCK_SIZE - 1) / BLOCK_SIZE;
    study->rows = (height + BLOCK_SIZE - 1) / BLOCK_SIZE;
    int count = study->columns * study->rows;
    study->truths = calloc((size_t)count, sizeof(*study->truths));
    if (!study->truths)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the true maps");
#pragma omp parallel for schedule(dynamic) num_threads(film_threads(&settings))
    for (int k = 0; k < count; k++) {
        int x0 = k % study->columns * BLOCK_SIZE, y0 = k / study->columns * BLOCK_SIZE;
        int x1 = x0 + BLOCK_SIZE < width ? x0 + BLOCK_SIZE : width;
        int y1 = y0 + BLOCK_SIZE < height ? y0 + BLOCK_SIZE : height;
        trace_truth(&in, (x0 + x1) / 2, (y0 + y1) / 2, o, &study->truths[k]);
    }
    return FEWRAY_OK;
}

/* Maps of bins x bins for a picture of this size; NULL without memory. */
static struct fewray_maps *make_maps(const struct study *study, const struct options *o, int bins) {
    struct fewray_maps *maps = calloc(1, sizeof(*maps));
    if (!maps)
        return NULL;
    int count = study->columns * study->rows;
    *maps = (struct fewray_maps){.columns = study->columns,
                                 .rows = study->rows,
                                 .width = study->reference->width,
                                 .height = study->reference->height,
                                 .count = count,
                                 .merge = SPHERE_ROWS / bins};
    maps->maps = calloc((size_t)count, sizeof(*maps->maps));
    maps->index = malloc((size_t)count * sizeof(*maps->index));
    if (!maps->maps || !maps->index) {
        fewray_maps_destroy(&maps);
        return NULL;
    }
    for (int k = 0; k < count; k++) {
        const struct truth *t = &study->truths[k];
        struct map *map = &maps->maps[k];
        float cosine[SPHERE_BINS], wanted[SPHERE_BINS];
        *map = (struct map){t->position, t->normal, .bsdf_fraction = o->fraction};
        memcpy(wanted, t->wanted, sizeof(wanted));
        sphere_cosines(t->normal, cosine);
        maps->index[k] = t->valid && maps_set(maps, map, cosine, wanted) ? k : -1;
    }
    return maps;
}

/* Renders by maps of bins x bins (0: without) and prints the errors. */
static int render(const struct study *study, const struct options *o, int bins, int spp, int seed,
                  struct fewray_error *error) {
    struct fewray_render_settings settings = render_settings(o, spp, seed);
    struct fewray_render_stats stats = {0};
    struct fewray_maps *maps = bins ? make_maps(study, o, bins) : NULL;
    struct fewray_film *film = NULL;
    struct fewray_frame *frame = NULL;
    struct fewray_metrics m;
    int status = FEWRAY_OK;
    if (bins && !maps)
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the maps");
    double start = omp_get_wtime(), seconds = 0;
    status = status ? status : fewray_film_create(study->world, &settings, &film, error);
    status =
        status ? status : fewray_trace_rest(study->world, maps, &settings, film, &stats, error);
    seconds = omp_get_wtime() - start;
    status = status ? status : fewray_trace_edges(study->world, &settings, film, &stats, error);
    status = status ? status : fewray_film_frame(film, maps, &frame, error);
    status = status ? status : fewray_compare(frame, study->reference, &m, error);
    if (!status) {
        printf("{\"bins\": %d, \"map\": \"%s\", \"spp\": %d, \"seed\": %d, \"mrse\": %.6g, "
               "\"mrse_trimmed\": %.6g, \"ssim_loss\": %.6g, \"seconds\": %.3f}\n",
               bins, o->moments ? "moment" : "mean", spp, seed, m.mrse, m.mrse_trimmed, m.ssim_loss,
               seconds);
        fflush(stdout);
    }
    fewray_frame_destroy(&frame);
    fewray_film_destroy(&film);
    if (maps)
        fewray_maps_destroy(&maps);
    return status;
}

static int run(const struct options *o, struct fewray_error *error) {
    struct study s = {.scene = NULL};
    int status = fewray_frame_read_exr(o->reference, &s.reference, error);
    status = status ? status : fewray_scene_load(o->scene, NULL, &s.scene, error);
    status = status ? status : fewray_world_create(s.scene, o->threads, &s.world, error);
    status = status ? status : trace_truths(&s, o, error);
    for (int i = 0; i < o->seeds && !status; i++)
        for (int k = 0; k < o->spp.count && !status; k++) {
            int seed = o->seed + i, spp = o->spp.values[k];
            status = render(&s, o, 0, spp, seed, error);
            for (int b = 0; b < o->bins.count && !status; b++)
                status = render(&s, o, o->bins.values[b], spp, seed, error);
        }
    free(s.truths);
    fewray_world_destroy(&s.world);
    fewray_scene_destroy(&s.scene);
    fewray_frame_destroy(&s.reference);
    return status;
}

/* "8,16,32"; false where it isn't a list of numbers in least..most. */
static bool parse_list(const char *text, int least, int most, struct int_list *list) {
    list->count = 0;
    for (const char *at = text; list->count < MAX_LIST; at++) {
        char *end;
        long n = strtol(at, &end, 10);
        if (end == at || n < least || n > most)
            return false;
        list->values[list->count++] = (int)n;
        if (!*end)
            return true;
        if (*end != ',')
            return false;
        at = end;
    }
    return false;
}

static bool parse(int argc, char **argv, struct options *o) {
    static const struct option names[] = {{"map", 1, NULL, 'm'},      {"bins", 1, NULL, 'b'},
                                          {"spp", 1, NULL, 'n'},      {"samples", 1, NULL, 's'},
                                          {"fraction", 1, NULL, 'f'}, {"width", 1, NULL, 'w'},
                                          {"seed", 1, NULL, 'r'},     {"seeds", 1, NULL, 'k'},
                                          {"threads", 1, NULL, 't'},  {NULL, 0, NULL, 0}};
    *o = (struct options){.samples = 64, .seed = 1, .seeds = 1};
    bool good = parse_list("8,16,32", 1, 32, &o->bins) && parse_list("4,16,64", 1, 65536, &o->spp);
    for (int c; good && (c = getopt_long(argc, argv, "", names, NULL)) != -1;) {
        switch (c) {
        case 'm':
            o->moments = !strcmp(optarg, "moment");
            good = o->moments || !strcmp(optarg, "mean");
            break;
        case 'b':
            good = parse_list(optarg, 1, 32, &o->bins);
            for (int i = 0; i < o->bins.count; i++)
                good &= SPHERE_ROWS % o->bins.values[i] == 0;
            break;
        case 'n':
            good = parse_list(optarg, 1, 65536, &o->spp);
            break;
        case 's':
            o->samples = atoi(optarg);
            break;
        case 'f':
            o->fraction = (float)atof(optarg);
            break;
        case 'w':
            o->width = atoi(optarg);
            break;
        case 'r':
            o->seed = atoi(optarg);
            break;
        case 'k':
            o->seeds = atoi(optarg);
            break;
        case 't':
            o->threads = atoi(optarg);
            break;
        default:
            good = false;
        }
    }
    if (!good || optind + 2 != argc)
        return false;
    o->scene = argv[optind];
    o->reference = argv[optind + 1];
    return o->samples > 0 && o->seeds > 0 && o->width >= 0 && o->threads >= 0 && o->fraction >= 0 &&
           o->fraction <= 1;
}

int main(int argc, char **argv) {
    struct options o;
    if (!parse(argc, argv, &o)) {
        fprintf(stderr,
                "usage: %s [--map mean|moment] [--bins 8,16,32] [--spp 4,16,64] [--samples N]\n"
                "       [--fraction F] [--width W] [--seed S] [--seeds N] [--threads N]\n"
                "       SCENE.xml REFERENCE.exr\n",
                argv[0]);
        return 2;
    }
    struct fewray_error error;
    char text[1100];
    int status = run(&o, &error);
    if (status)
        fprintf(stderr, "fewray-true-maps: %s\n", fewray_error_text(&error, text, sizeof(text)));
    return status ? 1 : 0;
}
