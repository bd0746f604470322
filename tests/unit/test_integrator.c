/* SPDX-License-Identifier: Apache-2.0 */
/* Paths drawn from guides: whatever the guides say, however wrong, the mean stays. */

#include "tests/unit/check.h"
#include "tests/unit/lambert_shading.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "guide/odis/density.h"
#include "guide/trace/film.h"
#include "guide/trace/integrator.h"

enum { WIDTH = 24, HEIGHT = 18 };

static float uniform(uint32_t stream, uint32_t i) {
    return to_unit_float(hash_combine(stream, i));
}

/* The corner of a room without ceiling under an even sky: shadow rays and bounces find the light
 * equally well, so that a wrong weight of either shows. */
static const char corner[] =
    "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='5'/>"
    "</integrator><sensor type='perspective'><float name='fov' value='40'/><transform "
    "name='to_world'><lookat origin='1.5,1.2,3' target='-0.3,0.7,-0.3' up='0,1,0'/></transform>"
    "<film type='hdrfilm'><integer name='width' value='24'/><integer name='height' value='18'/>"
    "<rfilter type='box'/></film></sensor>"
    "<bsdf type='twosided' id='b'><bsdf type='diffuse'><rgb name='reflectance' "
    "value='0.9,0.8,0.7'/></bsdf></bsdf>"
    "<shape type='rectangle'><ref id='b'/><transform name='to_world'><rotate x='1' angle='-90'/>"
    "</transform></shape>"
    "<shape type='rectangle'><ref id='b'/><transform name='to_world'><translate y='1' z='-1'/>"
    "</transform></shape>"
    "<shape type='rectangle'><ref id='b'/><transform name='to_world'><rotate y='1' angle='90'/>"
    "<translate x='-1' y='1'/></transform></shape>"
    "<emitter type='constant'><rgb name='radiance' value='0.5,0.5,0.5'/></emitter></scene>";

struct stage {
    struct fewray_scene *scene;
    struct fewray_world *world;
    struct fewray_look *look;
    struct fewray_maps *maps;
    struct fewray_film *film;
    struct fewray_render_settings settings;
    struct integrator in; /* without guides */
};

static void stage_open(struct stage *s, const char *path) {
    struct fewray_render_stats stats = {0};
    struct fewray_error error = {.line = 0};
    memset(s, 0, sizeof(*s));
    fewray_render_settings_init(&s->settings);
    s->settings.width = WIDTH;
    s->settings.height = HEIGHT;
    s->settings.initial = 8;
    s->settings.spp = 24;
    s->settings.bsdf_fraction = 0.5f;
    s->settings.threads = 2;
    int status = fewray_scene_load(path, NULL, &s->scene, &error);
    status = status ? status : fewray_world_create(s->scene, 2, &s->world, &error);
    status = status ? status : fewray_film_create(s->world, &s->settings, &s->film, &error);
    status = status ? status
                    : fewray_trace_look(s->world, &s->settings, s->film, &s->look, &stats, &error);
    status = status ? status : fewray_maps_create(s->look, &s->settings, &s->maps, &stats, &error);
    if (status)
        fail_msg("%s: %s:%d: %s", path, error.file, error.line, error.what);
    s->in = film_integrator(s->world, s->film, &s->settings);
}

static void stage_open_corner(struct stage *s) {
    char path[] = "/tmp/fewray-corner-XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, corner, sizeof(corner) - 1), sizeof(corner) - 1);
    close(fd);
    stage_open(s, path);
    unlink(path);
}

static void stage_close(struct stage *s) {
    fewray_maps_destroy(&s->maps);
    fewray_look_destroy(&s->look);
    fewray_film_destroy(&s->film);
    fewray_world_destroy(&s->world);
    fewray_scene_destroy(&s->scene);
}

/* Densities that have nothing to do with the light; a third of the bins is ruled out. */
static void random_values(uint32_t seed, int bins, float *values) {
    for (int b = 0; b < bins; b++) {
        float v = uniform(seed, (uint32_t)b);
        values[b] = v < 0.33f ? 0 : v * v * v;
    }
}

static void spoil_probes(struct probes *probes, float bsdf_fraction, float light_chance) {
    assert_true(probes->fine.voxels.count > 20);
    for (int k = 0; k < probes->fine.voxels.count; k++) {
        struct probe *p = &probes->fine.probes[k];
        float values[PROBE_BINS];
        random_values((uint32_t)k, PROBE_BINS, values);
        assert_true(density_build(values, PROBE_SIZE, p->row_cdf, p->density));
        p->records = 100;
        p->bsdf_fraction = bsdf_fraction;
        p->light_chance = light_chance;
    }
}

static void spoil_maps(struct fewray_maps *maps, float bsdf_fraction) {
    assert_true(maps->count > 0);
    for (int m = 0; m < maps->count; m++) {
        float values[SPHERE_BINS];
        random_values((uint32_t)m + 1000, SPHERE_BINS, values);
        assert_true(map_set_density(&maps->maps[m], values));
        maps->maps[m].bsdf_fraction = bsdf_fraction;
    }
}

/* Mean radiance of the picture over several seeds, and its standard error. */
static double mean_radiance(const struct integrator *in, uint32_t stream, double *error) {
    enum { SEEDS = 24, SPP = 4 };
    double sum = 0, squares = 0;
    for (uint32_t seed = 0; seed < SEEDS; seed++) {
        double picture = 0;
        for (int i = 0; i < WIDTH * HEIGHT * SPP; i++) {
            int pixel = i / SPP;
            struct sampler sampler = sampler_start(
                hash_combine(hash_combine(stream, seed), (uint32_t)pixel), (uint32_t)(i % SPP));
            struct path_sample p = trace_path(in, pixel % WIDTH, pixel / WIDTH, &sampler, NULL);
            picture += mean_component(p.radiance) / (WIDTH * HEIGHT * SPP);
        }
        sum += picture / SEEDS;
        squares += picture * picture / SEEDS;
    }
    *error = sqrt(fmax(0, squares - sum * sum) / (SEEDS - 1));
    return sum;
}

static void assert_same_mean(const struct stage *s, struct guides guides, double most_error) {
    struct integrator guided = s->in;
    guided.guides = guides;
    double plain_error, guided_error;
    double plain_mean = mean_radiance(&s->in, 1, &plain_error);
    double guided_mean = mean_radiance(&guided, 2, &guided_error);
    double error = sqrt(plain_error * plain_error + guided_error * guided_error);
    assert_near(guided_mean, plain_mean, 4 * error);
    assert_true(error < most_error * plain_mean); /* else the test says nothing */
}

static void test_wrong_probes_keep_the_mean(void **state) {
    (void)state;
    struct stage s;
    for (int k = 0; k < 2; k++) {
        k == 0 ? stage_open_corner(&s) : stage_open(&s, EXAMPLES "/cornell-box.xml");
        spoil_probes(s.maps->probes, 0.5f, 0.5f);
        assert_same_mean(&s, (struct guides){.probes = s.maps->probes}, k == 0 ? 0.004 : 0.02);
        spoil_probes(s.maps->probes, 1, 0.25f); /* roulette alone */
        assert_same_mean(&s, (struct guides){.probes = s.maps->probes}, k == 0 ? 0.004 : 0.02);
        stage_close(&s);
    }
}

static void test_wrong_maps_keep_the_mean(void **state) {
    (void)state;
    struct stage s;
    for (int k = 0; k < 2; k++) {
        k == 0 ? stage_open_corner(&s) : stage_open(&s, EXAMPLES "/cornell-box.xml");
        spoil_maps(s.maps, 0.1f);
        assert_same_mean(&s, (struct guides){.maps = s.maps}, k == 0 ? 0.01 : 0.05);
        stage_close(&s);
    }
}

/* A surface that a map and a BSDF guide: the density is the mixture, and samples follow it. */
static void test_proposal_samples_follow_mixture(void **state) {
    (void)state;
    static struct map map;
    float values[SPHERE_BINS];
    random_values(5, SPHERE_BINS, values);
    assert_true(map_set_density(&map, values));
    const struct shading s = lambert_shading(normalize(vec(0.3f, 0.8f, -0.5f)));
    struct proposal p = proposal_bsdf();
    p.bsdf_fraction = 0.35f;
    p.maps = (struct map_mixture){1, {&map}, {1}, 0.35f};
    static double observed[SPHERE_BINS], expected[SPHERE_BINS];
    const int n = 1 << 16, grid = 8;
    for (int b = 0; b < SPHERE_BINS; b++) {
        observed[b] = expected[b] = 0;
        for (int k = 0; k < grid * grid; k++) {
            struct vec3 d = sphere_direction(b / SPHERE_COLUMNS, b % SPHERE_COLUMNS,
                                             ((float)(k / grid) + 0.5f) / (float)grid,
                                             ((float)(k % grid) + 0.5f) / (float)grid);
            struct proposal_pdf pdf = proposal_pdf(&p, &s, d);
            assert_near(pdf.bsdf, fmaxf(0, dot(d, s.normal)) / PI_F, 1e-6);
            assert_near(pdf.guide, map.density[b], 0);
            assert_near(pdf.mixture, 0.35 * pdf.bsdf + 0.65 * pdf.guide, 1e-6 * pdf.mixture);
            expected[b] += (double)pdf.mixture * SPHERE_BIN_SOLID_ANGLE * n / (grid * grid);
        }
    }
    for (uint32_t i = 0; i < (uint32_t)n; i++) {
        struct bsdf_sample sample;
        struct proposal_pdf pdf;
        const float u[2] = {uniform(11, i), uniform(12, i)};
        assert_true(proposal_sample(&p, &s, uniform(10, i), u, &sample, &pdf));
        observed[sphere_bin(sample.direction)]++;
    }
    int degrees;
    double statistic = chi_square(observed, expected, SPHERE_BINS, &degrees);
    assert_true(degrees > 400 && statistic < chi_square_limit(degrees));
    struct proposal_pdf alone = proposal_pdf(&(struct proposal){.bsdf_fraction = 1}, &s, s.normal);
    assert_near(alone.mixture, 1 / PI_F, 1e-6);
}

static double component(struct vec3 v, int c) {
    return c == 0 ? v.x : c == 1 ? v.y : v.z;
}

/* A path's log against its radiance. `shallow`: the same path cut after its first bounce, whose
 * radiance beside next-event estimation at the first hit is all in the log. */
static void assert_log(const struct path_sample *path, const struct vertex_log *log,
                       const struct path_sample *shallow, const struct vertex_log *shallow_log,
                       int rr_depth) {
    for (int c = 0; c < 3; c++) {
        double weight = component(log->vertices[0].weight, c);
        double direct = component(shallow->radiance, c) - component(shallow->emission, c) -
                        weight * component(shallow_log->vertices[0].incident, c);
        double radiance = component(path->emission, c) + direct +
                          weight * component(log->vertices[0].incident, c);
        assert_true(direct > -1e-5);
        assert_near(radiance, component(path->radiance, c),
                    1e-4 * (1e-3 + component(path->radiance, c)));
        assert_near(component(log->throughput[0], c), 1, 0);
        for (int k = 0; k + 1 < log->count; k++) {
            const struct path_vertex *v = &log->vertices[k], *next = v + 1;
            double before = component(log->throughput[k], c) * component(v->weight, c);
            double after = component(log->throughput[k + 1], c);
            double survived = before > 0 ? after / before : 1; /* 1 / chance of survival */
            assert_near(after, survived * before, 1e-6);
            assert_true(k + 2 < rr_depth ? fabs(survived - 1) < 1e-5 : survived > 1 - 1e-5);
            /* What is left is emission and next-event estimation at the next vertex. */
            double incident = component(v->incident, c);
            double left =
                incident - survived * component(next->weight, c) * component(next->incident, c);
            assert_true(left > -1e-4 * (1e-3 + incident));
        }
    }
}

static void test_log_adds_up_to_the_path(void **state) {
    (void)state;
    struct stage s;
    static struct vertex_log log, shallow_log;
    int vertices = 0, lit = 0;
    stage_open(&s, EXAMPLES "/cornell-box.xml");
    spoil_probes(s.maps->probes, 0.5f, 0.5f);
    spoil_maps(s.maps, 0.3f);
    struct integrator in = s.in, cut;
    in.guides = (struct guides){.maps = s.maps, .probes = s.maps->probes};
    in.max_depth = 12;
    cut = in;
    cut.max_depth = 2;
    const struct path_notes notes = {.log = &log}, shallow_notes = {.log = &shallow_log};
    for (int i = 0; i < WIDTH * HEIGHT * 4; i++) {
        int x = i / 4 % WIDTH, y = i / 4 / WIDTH;
        struct sampler a = sampler_start((uint32_t)(i / 4), (uint32_t)(i % 4)), b = a;
        struct path_sample path = trace_path(&in, x, y, &a, &notes);
        struct path_sample shallow = trace_path(&cut, x, y, &b, &shallow_notes);
        assert_int_equal(log.count > 0, shallow_log.count > 0);
        if (!log.count)
            continue;
        assert_int_equal(shallow_log.count, 1);
        assert_log(&path, &log, &shallow, &shallow_log, in.rr_depth);
        vertices += log.count;
        for (int k = 0; k < log.count; k++) {
            const struct path_vertex *v = &log.vertices[k];
            assert_near(length(v->direction), 1, 1e-5);
            assert_near(v->bsdf_pdf, dot(v->normal, v->direction) / PI_F, 1e-5);
            assert_true(v->pdf > 0 && v->pdf <= fmaxf(v->bsdf_pdf, v->guide_pdf) * 1.00001f);
            lit += k > 0 && max_component(v->incident) > 0;
        }
    }
    assert_true(vertices > 4 * WIDTH * HEIGHT && lit > WIDTH * HEIGHT);
    stage_close(&s);
}

/* Of 24 samples a pixel, the maps learn from the 8 that follow the look's 8. */
static void test_maps_learn_while_rendering(void **state) {
    (void)state;
    struct stage s;
    static struct map before;
    struct fewray_render_stats stats = {0};
    stage_open(&s, EXAMPLES "/cornell-box.xml");
    int m = s.maps->index[s.maps->columns + 1];
    assert_true(m >= 0 && s.maps->sums);
    before = s.maps->maps[m];
    s.settings.spp = 16; /* nothing would be left to profit */
    assert_int_equal(fewray_trace_rest(s.world, s.maps, &s.settings, s.film, &stats, NULL), 0);
    assert_memory_equal(&before, &s.maps->maps[m], sizeof(before));
    s.settings.spp = 24;
    assert_int_equal(fewray_trace_rest(s.world, s.maps, &s.settings, s.film, &stats, NULL), 0);
    double distance = 0;
    for (int b = 0; b < SPHERE_BINS; b++)
        distance +=
            fabs((double)s.maps->maps[m].density[b] - before.density[b]) * SPHERE_BIN_SOLID_ANGLE;
    assert_true(distance > 0.02 && distance < 1.8);
    assert_near(s.maps->maps[m].bsdf_fraction, before.bsdf_fraction, 0); /* it was given */
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_proposal_samples_follow_mixture),
        cmocka_unit_test(test_wrong_probes_keep_the_mean),
        cmocka_unit_test(test_wrong_maps_keep_the_mean),
        cmocka_unit_test(test_maps_learn_while_rendering),
        cmocka_unit_test(test_log_adds_up_to_the_path),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
