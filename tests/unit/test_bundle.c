/* SPDX-License-Identifier: Apache-2.0 */
/* A bundle's paths are those of the path tracer that follows one at a time: sample by sample, in
 * all that they report, with every instruction set that the CPU has. */

#include <math.h>
#include <omp.h>
#include <stdbool.h>

#include "bundle_scenes.h"
#include "guide/odis/density.h"
#include "guide/trace/bundle.h"
#include "guide/trace/film.h"
#include "guide/trace/surface.h"

#define COUNT(array) (sizeof(array) / sizeof(*(array)))

enum { WIDTH = 24, HEIGHT = 18, PATHS = WIDTH * HEIGHT };

/* Packets and single rays round differently, so that hits lie a few units in the last place apart;
 * where a light is near or a surface is seen edge-on, that grows. */
#define TOLERANCE 1e-4
/* Share of the samples that may differ: a ray just misses what the other one hits. */
#define MOST_DIFFERENT 0.005

/* All that a path reports. */
struct outcome {
    struct path_sample sample;
    struct look_record record;
    struct look_second second;
};

#define FLOATS(member)                                                                             \
    {                                                                                              \
#member, offsetof(struct outcome, member),                                                 \
            sizeof(((struct outcome *)0)->member) / sizeof(float)                                  \
    }

static const struct {
    const char *name;
    size_t offset, count;
} fields[] = {
    FLOATS(sample.radiance),    FLOATS(sample.emission),     FLOATS(sample.bounce),
    FLOATS(sample.indirect),    FLOATS(sample.albedo),       FLOATS(sample.normal),
    FLOATS(sample.depth),       FLOATS(sample.alpha),        FLOATS(record.position),
    FLOATS(record.normal),      FLOATS(record.depth),        FLOATS(record.direction),
    FLOATS(record.direct),      FLOATS(record.radiance),     FLOATS(record.emitted),
    FLOATS(record.reflected),   FLOATS(record.distance),     FLOATS(record.second_normal),
    FLOATS(second.albedo),      FLOATS(second.light),        FLOATS(second.bounce),
    FLOATS(second.light_value), FLOATS(second.bounce_value),
};

static bool is_near(float a, float b) {
    return fabs((double)a - b) <= TOLERANCE * (0.01 + fmax(fabs(a), fabs(b)));
}

static const char *counts_difference(const struct outcome *a, const struct outcome *b) {
    return a->sample.rays != b->sample.rays               ? "sample.rays"
           : a->sample.guided != b->sample.guided         ? "sample.guided"
           : a->record.bin != b->record.bin               ? "record.bin"
           : a->second.light_sent != b->second.light_sent ? "second.light_sent"
                                                          : NULL;
}

/* The name of a field that differs, or NULL. */
static const char *difference(const struct outcome *a, const struct outcome *b) {
    for (size_t f = 0; f < COUNT(fields); f++) {
        const float *x = (const float *)(const void *)((const char *)a + fields[f].offset);
        const float *y = (const float *)(const void *)((const char *)b + fields[f].offset);
        for (size_t c = 0; c < fields[f].count; c++)
            if (!is_near(x[c], y[c]))
                return fields[f].name;
    }
    return counts_difference(a, b);
}

/* The name of a field without the same bits, or NULL; padding has any. */
static const char *changed_bits(const struct outcome *a, const struct outcome *b) {
    for (size_t f = 0; f < COUNT(fields); f++)
        if (memcmp((const char *)a + fields[f].offset, (const char *)b + fields[f].offset,
                   fields[f].count * sizeof(float)))
            return fields[f].name;
    return counts_difference(a, b);
}

static const struct {
    const char *name;
    enum nn_isa isa;
    const struct bundle_tracer *tracer;
} fast[] = {
#if defined(__x86_64__)
    {"avx2", NN_ISA_AVX2, &bundle_avx2},
    {"avx512", NN_ISA_AVX512, &bundle_avx512},
#endif
};

/* Taught: paths that tell maps what they saw. */
enum kind { TRACE_PATHS, TRACE_TAUGHT, TRACE_LOOKS, TRACE_FEATURES, KINDS };
static const char *const kind_names[] = {"path", "taught path", "look", "features"};

/* Path i, and the point of the picture where features are wanted. */
static struct bundle_start start_of(int i, float point[2]) {
    struct bundle_start start = {
        .x = i % WIDTH, .y = i / WIDTH, .sampler = sampler_start((uint32_t)i, (uint32_t)i % 4)};
    sobol_point((uint32_t)i, 99, start.direction);
    sobol_point((uint32_t)i, 7, point);
    point[0] += (float)start.x;
    point[1] += (float)start.y;
    return start;
}

/* Looks may do without, so some do. */
static bool wants_second(int i) {
    return i % 8 > 0;
}

static void trace_alone(const struct integrator *in, enum kind kind, struct outcome *out) {
    memset(out, 0, PATHS * sizeof(*out));
    for (int i = 0; i < PATHS; i++) {
        float point[2];
        struct bundle_start s = start_of(i, point);
        const struct path_notes notes = {.record = &out[i].record,
                                         .second = wants_second(i) ? &out[i].second : NULL};
        out[i].sample = kind == TRACE_PATHS    ? trace_path(in, s.x, s.y, &s.sampler, NULL)
                        : kind == TRACE_TAUGHT ? trace_path(in, s.x, s.y, &s.sampler, &notes)
                        : kind == TRACE_LOOKS
                            ? trace_look_path(in, s.x, s.y, &s.sampler, s.direction, &notes)
                            : trace_features(in, point[0], point[1], &s.sampler);
    }
}

/* One bundle from path `first` on; it leaves the samples that aren't its own alone. */
static void trace_bundle(const struct integrator *in, const struct bundle_tracer *tracer,
                         enum kind kind, int first, int count, struct outcome *out) {
    struct bundle_start starts[BUNDLE_LANES];
    struct path_sample samples[BUNDLE_LANES + 1], guard[BUNDLE_LANES + 1];
    float x[BUNDLE_LANES], y[BUNDLE_LANES];
    memset(samples, 0x5a, sizeof(samples));
    memcpy(guard, samples, sizeof(samples));
    for (int k = 0; k < count; k++) {
        float point[2];
        starts[k] = start_of(first + k, point);
        x[k] = point[0];
        y[k] = point[1];
        if (kind == TRACE_TAUGHT || kind == TRACE_LOOKS) {
            starts[k].record = &out[first + k].record;
            starts[k].second = wants_second(first + k) ? &out[first + k].second : NULL;
        }
    }
    if (kind == TRACE_FEATURES)
        tracer->features(in, count, x, y, starts, samples);
    else
        (kind == TRACE_LOOKS ? tracer->looks : tracer->paths)(in, count, starts, samples);
    for (int k = 0; k < count; k++)
        out[first + k].sample = samples[k];
    assert_memory_equal(samples + count, guard + count,
                        (size_t)(BUNDLE_LANES + 1 - count) * sizeof(*samples));
}

static void trace_bundles(const struct integrator *in, const struct bundle_tracer *tracer,
                          enum kind kind, struct outcome *out) {
    static const int counts[] = {BUNDLE_LANES, 7, 1};
    memset(out, 0, PATHS * sizeof(*out));
    for (int i = 0, k = 0; i < PATHS; k++) {
        int left = PATHS - i, count = counts[k % 3] < left ? counts[k % 3] : left;
        trace_bundle(in, tracer, kind, i, count, out);
        i += count;
    }
}

static void assert_like(const char *scene, const char *kind, const char *name,
                        const struct outcome *alone, const struct outcome *bundled) {
    int different = 0;
    const char *field = NULL;
    for (int i = 0; i < PATHS; i++) {
        const char *found = difference(&alone[i], &bundled[i]);
        different += found != NULL;
        field = found ? found : field;
    }
    if (different > MOST_DIFFERENT * PATHS)
        fail_msg("%s: %d of %d %s samples differ, the last in %s (%s)", scene, different, PATHS,
                 kind, field, name);
}

static void assert_same(const char *scene, const struct integrator *in, enum kind kinds) {
    static struct outcome alone[PATHS], plain[PATHS], bundled[PATHS];
    for (enum kind kind = 0; kind < kinds; kind++) {
        trace_alone(in, kind, alone);
        trace_bundles(in, &bundle_plain, kind, plain);
        assert_like(scene, kind_names[kind], "plain", alone, plain);
        for (size_t t = 0; t < COUNT(fast); t++) {
            if (nn_kernels_get(fast[t].isa)->isa != fast[t].isa)
                continue;
            trace_bundles(in, fast[t].tracer, kind, bundled);
            assert_like(scene, kind_names[kind], fast[t].name, alone, bundled);
            for (int i = 0; i < PATHS; i++) {
                const char *changed = changed_bits(&plain[i], &bundled[i]);
                if (changed)
                    fail_msg("%s: %s of %s sample %d of %s isn't plain's", scene, changed,
                             kind_names[kind], i, fast[t].name);
            }
        }
    }
}

static struct integrator integrator_of(const struct fewray_world *world, int max_depth,
                                       int rr_depth) {
    return (struct integrator){.world = world,
                               .width = WIDTH,
                               .height = HEIGHT,
                               .max_depth = max_depth,
                               .rr_depth = rr_depth,
                               .part = 3};
}

static struct fewray_world *make_world(const struct fewray_scene *scene) {
    struct fewray_world *world = NULL;
    struct fewray_error error = {.line = 0};
    if (fewray_world_create(scene, 1, &world, &error))
        fail_msg("%s", error.what);
    return world;
}

/* Shares of the paths that bring light, and that guides may draw. */
static void count_paths(const struct integrator *in, double *lit, double *guided) {
    *lit = *guided = 0;
    for (int i = 0; i < PATHS; i++) {
        float point[2];
        struct bundle_start s = start_of(i, point);
        const struct path_sample sample = trace_path(in, s.x, s.y, &s.sampler, NULL);
        *lit += (mean_component(sample.radiance) > 0) / (double)PATHS;
        *guided += sample.guided / (double)PATHS;
    }
}

/* Else the comparison would say nothing. */
static void assert_scene_tells(const struct bundle_scene *scene, const struct integrator *in) {
    const struct lights *lights = &in->world->lights;
    bool has_light = lights->source_count > 0 || lights->distant_count > 0;
    double lit, guided;
    count_paths(in, &lit, &guided);
    assert_true(lit > 0.3 || in->max_depth == 1 || !has_light);
    assert_true(guided > 0.3 || !in->guides.maps);
    assert_true(lights->tree.node_count > 0 || !strstr(scene->name, "light tree"));
}

static void test_bundled_paths_equal_single_ones(void **state) {
    (void)state;
    for (size_t i = 0; i < COUNT(bundle_scenes); i++) {
        const struct bundle_scene *s = &bundle_scenes[i];
        struct fewray_scene *scene = load_bundle_scene(s->text);
        struct fewray_world *world = make_world(scene);
        const struct integrator in = integrator_of(world, s->max_depth, s->rr_depth);
        assert_scene_tells(s, &in);
        assert_same(s->name, &in, KINDS);
        fewray_world_destroy(&world);
        fewray_scene_destroy(&scene);
    }
}

static float uniform(uint32_t stream, uint32_t i) {
    return to_unit_float(hash_combine(stream, i));
}

/* Densities that have nothing to do with the light; a third of the bins is ruled out. */
static void random_values(uint32_t seed, int bins, float *values) {
    for (int b = 0; b < bins; b++) {
        float v = uniform(seed, (uint32_t)b);
        values[b] = v < 0.33f ? 0 : v * v * v;
    }
}

/* Guides that the BSDF shares its samples with here and there, and elsewhere not. */
static void spoil(struct fewray_maps *maps) {
    float values[SPHERE_BINS];
    assert_true(maps->count > 0 && maps->probes->fine.voxels.count > 20);
    for (int m = 0; m < maps->count; m++) {
        random_values((uint32_t)m + 1000, SPHERE_BINS, values);
        assert_true(map_set_density(&maps->maps[m], values));
        maps->maps[m].bsdf_fraction = m % 4 ? 0.4f : 1;
    }
    for (int k = 0; k < maps->probes->fine.voxels.count; k++) {
        struct probe *p = &maps->probes->fine.probes[k];
        random_values((uint32_t)k, PROBE_BINS, values);
        assert_true(density_build(values, PROBE_SIZE, p->row_cdf, p->density));
        p->records = 100;
        p->bsdf_fraction = k % 3 ? 0.5f : 1;
        p->light_chance = k % 5 ? 0.3f : 1;
    }
}

struct stage {
    struct fewray_scene *scene;
    struct fewray_world *world;
    struct fewray_film *film;
    struct fewray_look *look;
    struct fewray_maps *maps;
};

static void stage_open(struct stage *s, const char *body) {
    struct fewray_render_settings settings;
    struct fewray_render_stats stats = {0};
    struct fewray_error error = {.line = 0};
    memset(s, 0, sizeof(*s));
    s->scene = load_bundle_scene(body);
    s->world = make_world(s->scene);
    fewray_render_settings_init(&settings);
    settings.width = WIDTH;
    settings.height = HEIGHT;
    settings.initial = 8;
    settings.spp = 24;
    settings.threads = 1;
    int status = fewray_film_create(s->world, &settings, &s->film, &error);
    status =
        status ? status : fewray_trace_look(s->world, &settings, s->film, &s->look, &stats, &error);
    status = status ? status : fewray_maps_create(s->look, &settings, &s->maps, &stats, &error);
    if (status)
        fail_msg("%s", error.what);
    spoil(s->maps);
}

static void stage_close(struct stage *s) {
    fewray_maps_destroy(&s->maps);
    fewray_look_destroy(&s->look);
    fewray_film_destroy(&s->film);
    fewray_world_destroy(&s->world);
    fewray_scene_destroy(&s->scene);
}

static void test_guided_bundles_equal_single_paths(void **state) {
    (void)state;
    for (size_t i = 0; i < COUNT(guided_scenes); i++) {
        const struct bundle_scene *scene = &guided_scenes[i];
        struct stage s;
        stage_open(&s, scene->text);
        struct integrator in = integrator_of(s.world, scene->max_depth, scene->rr_depth);
        in.guides = (struct guides){.probes = s.maps->probes};
        assert_same(scene->name, &in, TRACE_LOOKS); /* looks come before guides */
        in.guides = (struct guides){.maps = s.maps};
        assert_same(scene->name, &in, TRACE_LOOKS);
        in.guides = (struct guides){.maps = s.maps, .probes = s.maps->probes};
        assert_scene_tells(scene, &in);
        assert_same(scene->name, &in, TRACE_LOOKS);
        stage_close(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bundled_paths_equal_single_ones),
        cmocka_unit_test(test_guided_bundles_equal_single_paths),
    };
    omp_set_num_threads(1); /* for scenes so small threads cost more than they bring */
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
