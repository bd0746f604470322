/* SPDX-License-Identifier: Apache-2.0 */
/* Whatever the look, the network, the maps and the probes say, the picture's mean is that of plain
 * path tracing, and every number in it is finite. */

#include "guide_stage.h"

#include <omp.h>

#include <zlib.h>

#include "guide_bias.h"

/* --- looks that tell little or nonsense */

static void look_dark(struct stage *s) {
    for (int i = 0; i < stage_records(s->look); i++) {
        struct look_record *r = &s->look->records[i];
        r->radiance = r->direct = vec(0, 0, 0);
        r->emitted = r->reflected = r->mean = r->moment = 0;
        s->look->seconds[i].light_value = s->look->seconds[i].bounce_value = 0;
    }
}

static void look_blind(struct stage *s) {
    for (int i = 0; i < stage_records(s->look); i++)
        s->look->records[i].depth = s->look->seconds[i].albedo = 0;
}

/* One record out of all found light: one bin of each map around it. */
static void look_one_bin(struct stage *s) {
    look_dark(s);
    struct look_record *r = &s->look->records[stage_records(s->look) * 5 / 8];
    assert_true(r->depth > 0);
    r->radiance = vec(7, 7, 7);
    r->reflected = r->mean = r->moment = 7;
}

/* Every fifth record at the picture's left is a fault. */
static void look_faulty(struct stage *s) {
    const float faults[] = {NAN,    INFINITY, -INFINITY, -1,    -1e30f, 3e38f,
                            1e-45f, 1e-38f,   1e30f,     1e19f, -0.0f};
    const int count = sizeof faults / sizeof *faults;
    for (int i = 0; i < stage_records(s->look); i += 5) {
        struct look_record *r = &s->look->records[i];
        if (i / s->look->samples % s->look->width >= 8)
            continue;
        const float fault = faults[i / 5 % count], other = faults[(i / 5 + 3) % count];
        r->radiance = vec(fault, other, fault);
        r->direct = vec(other, fault, other);
        r->reflected = fault;
        r->emitted = i % 2 ? other : r->emitted;
        s->look->seconds[i].light_value = other;
        s->look->seconds[i].bounce_value = fault;
    }
}

static void scale_look(struct stage *s, float factor) {
    for (int i = 0; i < stage_records(s->look); i++) {
        struct look_record *r = &s->look->records[i];
        r->radiance = scale(r->radiance, factor);
        r->direct = scale(r->direct, factor);
        r->reflected *= factor;
        r->emitted *= factor;
        s->look->seconds[i].light_value *= factor;
        s->look->seconds[i].bounce_value *= factor;
    }
}

static void look_faint(struct stage *s) {
    scale_look(s, 1e-19f);
}

static void look_glaring(struct stage *s) {
    scale_look(s, 1e14f);
}

/* --- maps */

static void set_values(struct stage *s, int m, const float values[SPHERE_BINS], float fraction) {
    assert_true(map_set_density(&s->maps->maps[m], values));
    s->maps->maps[m].bsdf_fraction = fraction;
}

static void maps_random(struct stage *s) {
    float values[SPHERE_BINS];
    for (int m = 0; m < s->maps->count; m++) {
        for (int b = 0; b < SPHERE_BINS; b++) {
            const float v = stage_random((uint32_t)m, b);
            values[b] = v < 0.33f ? 0 : v * v * v;
        }
        set_values(s, m, values, MAP_LEAST_FRACTION);
    }
}

static void all_in_one_bin(struct stage *s, float side) {
    for (int m = 0; m < s->maps->count; m++) {
        float values[SPHERE_BINS] = {0};
        values[sphere_bin(scale(s->maps->maps[m].normal, side))] = 1;
        set_values(s, m, values, MAP_LEAST_FRACTION);
    }
}

static void maps_one_bin(struct stage *s) {
    all_in_one_bin(s, 1);
}

/* Nothing that a map draws leaves the surface. */
static void maps_backwards(struct stage *s) {
    all_in_one_bin(s, -1);
}

static void maps_inverted(struct stage *s) {
    float values[SPHERE_BINS];
    for (int m = 0; m < s->maps->count; m++) {
        for (int b = 0; b < SPHERE_BINS; b++)
            values[b] = 1 / (1e-3f + s->maps->maps[m].density[b]);
        set_values(s, m, values, MAP_LEAST_FRACTION);
    }
}

/* Each cell has the density of another one. */
static void maps_permuted(struct stage *s) {
    const int count = s->maps->count;
    assert_true(count > 2);
    for (int m = 0; m + 1 < count; m++) {
        float here[SPHERE_BINS], there[SPHERE_BINS];
        memcpy(here, s->maps->maps[m].density, sizeof here);
        memcpy(there, s->maps->maps[m + 1].density, sizeof there);
        set_values(s, m, there, MAP_LEAST_FRACTION);
        set_values(s, m + 1, here, MAP_LEAST_FRACTION);
    }
}

/* What a network gone mad might want of the maps; those that it leaves none of have none, as in
 * fewray_maps_create(). */
static void maps_hostile(struct stage *s) {
    const float odd[] = {NAN, INFINITY, -1, 0, 1e-45f, 3e38f};
    int kept = 0;
    for (int m = 0; m < s->maps->count; m++) {
        float wanted[SPHERE_BINS], cosine[SPHERE_BINS];
        for (int b = 0; b < SPHERE_BINS; b++)
            wanted[b] = (b + m) % 7 ? 1e-45f * (float)(m % 2) : odd[m % 6];
        sphere_cosines(s->maps->maps[m].normal, cosine);
        s->maps->maps[m].bsdf_fraction = MAP_LEAST_FRACTION;
        const bool set = maps_set(s->maps, &s->maps->maps[m], cosine, wanted);
        kept += set;
        for (int k = 0; k < s->maps->columns * s->maps->rows; k++)
            if (s->maps->index[k] == m && !set)
                s->maps->index[k] = -1;
    }
    assert_true(kept < s->maps->count);
}

/* No share for the BSDF: maps_set() sees to it that every direction can be drawn. */
static void maps_alone(struct stage *s) {
    for (int m = 0; m < s->maps->count; m++) {
        float wanted[SPHERE_BINS], cosine[SPHERE_BINS];
        for (int b = 0; b < SPHERE_BINS; b++)
            wanted[b] = 0.5f + stage_random((uint32_t)m, b);
        sphere_cosines(s->maps->maps[m].normal, cosine);
        s->maps->maps[m].bsdf_fraction = 0;
        assert_true(maps_set(s->maps, &s->maps->maps[m], cosine, wanted));
    }
}

static void maps_fractions(struct stage *s) {
    const float fractions[] = {0.1f, 0.94f, 0.96f, 1, 1e-3f};
    maps_random(s);
    for (int m = 0; m < s->maps->count; m++)
        s->maps->maps[m].bsdf_fraction = fractions[m % 5];
}

/* --- probes */

static void each_probe(struct stage *s, void (*set)(struct probe *, uint32_t number)) {
    struct probes *p = s->maps->probes;
    assert_true(p->fine.voxels.count > 20);
    for (int k = 0; k < p->fine.voxels.count; k++)
        set(&p->fine.probes[k], (uint32_t)k);
    for (int k = 0; k < p->coarse.voxels.count; k++)
        set(&p->coarse.probes[k], (uint32_t)k + 1000);
}

static void set_probe(struct probe *p, const float values[PROBE_BINS], float light_chance) {
    assert_true(density_build(values, PROBE_SIZE, p->row_cdf, p->density));
    p->records = 100;
    p->bsdf_fraction = 0.25f;
    p->light_chance = light_chance;
}

static void random_probe(struct probe *p, uint32_t number) {
    float values[PROBE_BINS];
    for (int b = 0; b < PROBE_BINS; b++) {
        const float v = stage_random(number, b);
        values[b] = v < 0.33f ? 0 : v * v * v;
    }
    set_probe(p, values, number % 2 ? 0.25f : 1);
}

static void backward_probe(struct probe *p, uint32_t number) {
    float values[PROBE_BINS] = {0};
    values[density_bin(scale(p->normal, number % 2 ? 1 : -1), PROBE_SIZE)] = 1;
    set_probe(p, values, 0.5f);
}

static void probes_random(struct stage *s) {
    each_probe(s, random_probe);
}

static void probes_one_bin(struct stage *s) {
    each_probe(s, backward_probe);
}

/* Later vertices meet the maps of other places, and other voxels' probes. */
static void places_permuted(struct stage *s) {
    struct probes *p = s->maps->probes;
    for (int k = 0; k < s->maps->places.count; k++)
        s->maps->place_maps[k] = (s->maps->place_maps[k] + 1) % s->maps->count;
    for (int k = 0; k + 1 < p->fine.voxels.count; k++) {
        const struct probe here = p->fine.probes[k];
        p->fine.probes[k] = p->fine.probes[k + 1];
        p->fine.probes[k + 1] = here;
    }
}

static void everything_wrong(struct stage *s) {
    maps_random(s);
    probes_random(s);
    places_permuted(s);
}

/* --- all of them */

static const struct wrong_guide {
    const char *name;
    void (*look)(struct stage *), (*maps)(struct stage *);
    double resolution;
    bool mapless; /* no map can be made */
    int spp;      /* beside the look's; 0: SPP; above 4 the maps learn */
} cases[] = {
    {"as they should be", NULL, NULL, 0.01, .mapless = false},
    {"look that found no light", look_dark, NULL, 0.01, .mapless = true},
    {"look that saw no surface", look_blind, NULL, 0.01, .mapless = true},
    {"look with one lit bin", look_one_bin, NULL, 0.02, .mapless = false},
    {"look of NaN, Inf, negatives", look_faulty, NULL, 0.03, .mapless = false},
    {"look 1e-19 as bright", look_faint, NULL, 0.01, .mapless = false},
    {"look 1e14 as bright", look_glaring, NULL, 0.01, .mapless = false},
    {"random maps", NULL, maps_random, 0.02, .mapless = false},
    {"random maps that learn", NULL, maps_random, 0.02, .spp = 16},
    {"maps of one bin", NULL, maps_one_bin, 0.02, .mapless = false},
    {"maps into the surface", NULL, maps_backwards, 0.02, .mapless = false},
    {"maps that avoid the light", NULL, maps_inverted, 0.02, .mapless = false},
    {"maps of other cells", NULL, maps_permuted, 0.02, .mapless = false},
    {"maps of NaN, Inf, denormals", NULL, maps_hostile, 0.02, .mapless = false},
    {"maps without the BSDF", NULL, maps_alone, 0.02, .mapless = false},
    {"maps of any BSDF fraction", NULL, maps_fractions, 0.05, .mapless = false},
    {"random probes, roulette of shadow rays", NULL, probes_random, 0.02, .mapless = false},
    {"probes of one bin", NULL, probes_one_bin, 0.02, .mapless = false},
    {"probes and maps of other places", NULL, places_permuted, 0.02, .mapless = false},
    {"everything wrong at once", NULL, everything_wrong, 0.03, .mapless = false},
};

static void test_wrong_guides_keep_the_mean(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const struct wrong_guide *c = &cases[k];
        struct stage s;
        stage_open(&s, INITIAL, INITIAL + (c->spp ? c->spp : SPP));
        s.settings.refine = c->spp > 0;
        if (c->look)
            c->look(&s);
        stage_make_maps(&s);
        int made = 0;
        for (int i = 0; i < s.maps->columns * s.maps->rows; i++)
            made += s.maps->index[i] >= 0;
        if (c->mapless != !made)
            fail_msg("%s: %d blocks have a map", c->name, made);
        if (c->maps)
            c->maps(&s);
        assert_unbiased(&s, c->name, c->resolution);
        stage_close(&s);
    }
}

/* --- weights of the network gone wrong */

extern const unsigned char odis_weights[];
size_t odis_weights_size(void);

/* The built-in weights with all values of a layer's tensor replaced by one half float, as a file of
 * valid checksum. */
static void write_weights(const char *path, const char *tensor, uint16_t half) {
    const size_t size = odis_weights_size();
    unsigned char *bytes = malloc(size);
    assert_non_null(bytes);
    memcpy(bytes, odis_weights, size);
    unsigned char *name = NULL;
    for (size_t i = 0; i + 64 < size && !name; i++)
        if (!strcmp((const char *)bytes + i, tensor))
            name = bytes + i;
    assert_non_null(name);
    size_t count = 1;
    for (int d = 0; d < 4; d++) /* the shape follows the padded name */
        count *= name[48 + 4 * d] + 256u * name[49 + 4 * d];
    for (size_t i = 0; i < count; i++)
        memcpy(name + 64 + 2 * i, &half, sizeof half);
    const uint32_t crc = (uint32_t)crc32(0, bytes + 16, (uInt)(size - 16));
    memcpy(bytes + 12, &crc, sizeof crc);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
    free(bytes);
}

static const struct {
    const char *name, *tensor;
    uint16_t half;
} networks[] = {
    {"head of 65504", "head.bias", 0x7bff},       {"head of -65504", "head.bias", 0xfbff},
    {"all weights 65504", "stem.weight", 0x7bff}, {"BSDF share -65504", "mix.bias", 0xfbff},
    {"BSDF share 65504", "mix.bias", 0x7bff},
};

static void test_absurd_networks_keep_the_mean(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof networks / sizeof *networks; k++) {
        char path[] = "/tmp/fewray-weights-XXXXXX";
        close(mkstemp(path));
        write_weights(path, networks[k].tensor, networks[k].half);
        struct stage s;
        stage_open(&s, INITIAL, INITIAL + SPP);
        s.settings.weights_path = path;
        s.settings.refine = false;
        stage_make_maps(&s);
        unlink(path);
        for (int m = 0; m < s.maps->count; m++) {
            const float fraction = s.maps->maps[m].bsdf_fraction;
            assert_true(fraction >= MAP_LEAST_FRACTION && fraction <= 1);
        }
        assert_unbiased(&s, networks[k].name, 0.03);
        stage_close(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_wrong_guides_keep_the_mean),
        cmocka_unit_test(test_absurd_networks_keep_the_mean),
    };
    omp_set_num_threads(1); /* for scenes so small threads cost more than they bring */
    return cmocka_run_group_tests(tests, render_plain, forget_plain);
}
