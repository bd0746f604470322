/* SPDX-License-Identifier: Apache-2.0 */
/* Sampling of materials: directions follow the density, weights estimate the same integral as the
 * values, nothing gains energy, and light's way back is worth as much. */

#include "tests/unit/bsdf_cases.h"

#include "guide/odis/sphere_grid.h"
#include "guide/trace/sampler.h"

static const float texture_u = 0.37f, texture_v = 0.81f;

/* Views at three angles from in front, and one from behind. */
static const struct vec3 views[] = {
    {0.1f, 0.2f, 0.97f}, {-0.6f, 0.5f, 0.62f}, {0.9f, -0.35f, 0.25f}, {0.4f, 0.6f, -0.69f}};
#define VIEWS ((int)(sizeof(views) / sizeof(*views)))

static struct shading view_of(const json_t *entry, int view) {
    return case_shading(entry, normalize(views[view]), texture_u, texture_v);
}

static float random_unit(uint32_t stream, uint32_t i) {
    return to_unit_float(hash_combine(hash_u32(stream), i));
}

static bool draw(const struct shading *s, uint32_t i, struct bsdf_sample *out) {
    const float u[2] = {random_unit(1, i), random_unit(2, i)};
    return bsdf_sample(s, random_unit(3, i), u, out);
}

/* Integrals over a bin of the sphere of the density and of the value, by the midpoints of a grid
 * that is refined where a lobe is narrow. The sphere's y axis is the surface's normal. */
struct integral {
    double pdf, value[3];
};

static struct vec3 grid_direction(const struct basis *frame, int bin, int k, int side) {
    struct vec3 d = sphere_direction(bin / SPHERE_COLUMNS, bin % SPHERE_COLUMNS,
                                     ((float)(k / side) + 0.5f) / (float)side,
                                     ((float)(k % side) + 0.5f) / (float)side);
    return to_world(frame, vec(d.x, d.z, d.y));
}

static int grid_bin(const struct basis *frame, struct vec3 direction) {
    return sphere_bin(
        vec(dot(direction, frame->s), dot(direction, frame->n), dot(direction, frame->t)));
}

static struct integral integrate_bin(const struct shading *s, int bin, int side) {
    struct integral sum = {0};
    double area = SPHERE_BIN_SOLID_ANGLE / (side * side);
    for (int k = 0; k < side * side; k++) {
        struct vec3 d = grid_direction(&cases.frame, bin, k, side);
        struct vec3 value = bsdf_times_cosine(s, d);
        sum.pdf += bsdf_pdf(s, d) * area;
        sum.value[0] += value.x * area;
        sum.value[1] += value.y * area;
        sum.value[2] += value.z * area;
    }
    return sum;
}

static struct integral integrate_finely(const struct shading *s, int bin) {
    struct integral coarse = integrate_bin(s, bin, 1), fine = integrate_bin(s, bin, 3);
    for (int side = 6; side <= 48; side *= 2) {
        double error = fabs(fine.pdf - coarse.pdf) + fabs(fine.value[0] - coarse.value[0]);
        if (error < 1e-5)
            break;
        coarse = fine;
        fine = integrate_bin(s, bin, side);
    }
    return fine;
}

enum { SAMPLES = 1 << 13 };

/* What the samples of one view come to. */
struct tally {
    double observed[SPHERE_BINS + 1], expected[SPHERE_BINS + 1]; /* the last cell: nothing drawn */
    double mean[3], square[3]; /* of the weights of the smooth parts */
    double pdf, value[3];      /* integrals */
    int deltas, odd;           /* odd: the sample's weight or pdf isn't its direction's */
};

static void tally_samples(const struct shading *s, struct tally *t) {
    for (uint32_t i = 0; i < SAMPLES; i++) {
        struct bsdf_sample sample;
        if (!draw(s, i, &sample)) {
            t->observed[SPHERE_BINS]++;
            continue;
        }
        if (sample.delta) {
            t->deltas++;
            continue;
        }
        t->observed[grid_bin(&cases.frame, sample.direction)]++;
        const float w[3] = {sample.weight.x, sample.weight.y, sample.weight.z};
        for (int c = 0; c < 3; c++) {
            t->mean[c] += w[c] / (double)SAMPLES;
            t->square[c] += (double)w[c] * w[c] / SAMPLES;
        }
        if (i % 4)
            continue;
        float pdf = bsdf_pdf(s, sample.direction);
        struct vec3 value = scale(sample.weight, sample.pdf);
        struct vec3 difference = sub(bsdf_times_cosine(s, sample.direction), value);
        t->odd += fabsf(pdf - sample.pdf) > 0.01f * pdf ||
                  length(difference) > 0.01f * length(value) + 1e-6f;
    }
}

static void fill_tally(const struct shading *s, struct tally *t) {
    memset(t, 0, sizeof(*t));
    for (int b = 0; b < SPHERE_BINS; b++) {
        struct integral integral = integrate_finely(s, b);
        t->expected[b] = integral.pdf * SAMPLES;
        t->pdf += integral.pdf;
        for (int c = 0; c < 3; c++)
            t->value[c] += integral.value[c];
    }
    tally_samples(s, t);
    t->expected[SPHERE_BINS] = fmax(0, 1 - t->pdf - s->delta_chance) * SAMPLES;
}

/* Returns the number of complaints. */
static int check_tally(const json_t *entry, int view, const struct shading *s,
                       const struct tally *t) {
    const char *name = case_name(entry);
    int degrees, wrong = 0;
    double statistic = chi_square(t->observed, t->expected, SPHERE_BINS + 1, &degrees);
    if (degrees > 0 && statistic > chi_square_limit(degrees)) {
        print_error(
            "%s, view %d: chi-square %.1f of %d degrees, limit %.1f; density sums to %.4f\n", name,
            view, statistic, degrees, chi_square_limit(degrees), t->pdf);
        wrong++;
    }
    if (t->pdf + s->delta_chance > 1.005) {
        print_error("%s, view %d: density sums to %.4f, specular %.4f\n", name, view, t->pdf,
                    s->delta_chance);
        wrong++;
    }
    double chance = s->delta_chance, noise = sqrt(chance * (1 - chance) / SAMPLES);
    if (s->scatters && t->deltas > SAMPLES * (chance + 5 * noise)) {
        print_error("%s, view %d: %d specular samples, chance %.4f\n", name, view, t->deltas,
                    chance);
        wrong++;
    }
    if (t->odd > SAMPLES / 4000) {
        print_error("%s, view %d: %d samples aren't weighted by value / density\n", name, view,
                    t->odd);
        wrong++;
    }
    for (int c = 0; c < 3; c++) {
        double variance = fmax(0, t->square[c] - t->mean[c] * t->mean[c]);
        double tolerance = 5 * sqrt(variance / SAMPLES) + 0.005 * t->value[c] + 1e-4;
        if (!(fabs(t->mean[c] - t->value[c]) <= tolerance)) {
            print_error("%s, view %d: mean weight %.5f, integral of the value %.5f +- %.5f\n", name,
                        view, t->mean[c], t->value[c], tolerance);
            wrong++;
            break;
        }
    }
    return wrong;
}

static void test_samples_follow_pdf_and_weights_the_value(void **state) {
    (void)state;
    static struct tally tally;
    int wrong = 0;
    json_t *entry;
    for (size_t i = 0; (entry = json_array_get(cases.table.configurations, i)); i++)
        for (int view = 0; view < VIEWS; view++) {
            struct shading s = view_of(entry, view);
            fill_tally(&s, &tally);
            wrong += check_tally(entry, view, &s, &tally);
        }
    assert_int_equal(wrong, 0);
}

/* Mean weight in a white furnace; what was transmitted counts without the change that the radiance
 * underwent by the index of refraction. */
static double furnace(const struct shading *s) {
    double sum = 0;
    for (uint32_t i = 0; i < SAMPLES / 4; i++) {
        struct bsdf_sample sample;
        if (draw(s, i, &sample))
            sum += (double)max_component(sample.weight) * sample.eta * sample.eta;
    }
    return sum / (SAMPLES / 4);
}

/* Lobes of the principled BSDF are summed without a balance of their energy. */
static void test_nothing_gains_energy(void **state) {
    (void)state;
    int wrong = 0;
    json_t *entry;
    for (size_t i = 0; (entry = json_array_get(cases.table.configurations, i)); i++)
        for (int view = 0; view < VIEWS; view++) {
            struct shading s = view_of(entry, view);
            double albedo = furnace(&s);
            bool lossless = json_is_true(json_object_get(entry, "lossless"));
            bool black = !s.scatters;
            double limit = strstr(case_name(entry), "principled") ? 1.1 : 1.02;
            if (albedo > limit || (lossless && !black && albedo < 0.98) || (black && albedo > 0)) {
                print_error("%s, view %d: albedo %.4f\n", case_name(entry), view, albedo);
                wrong++;
            }
        }
    assert_int_equal(wrong, 0);
}

static struct vec3 random_direction(uint32_t stream, uint32_t i) {
    float z = 2 * random_unit(stream, i) - 1, r = sqrtf(fmaxf(0, 1 - z * z));
    float phi = 2 * PI_F * random_unit(stream + 1, i);
    return vec(r * cosf(phi), r * sinf(phi), z);
}

/* BSDF of light from b towards a. */
static struct vec3 scattering(const json_t *entry, struct vec3 a, struct vec3 b) {
    struct shading s = case_shading(entry, a, texture_u, texture_v);
    return scale(bsdf_times_cosine(&s, to_world(&cases.frame, b)), 1 / fabsf(b.z));
}

/* f(a, b) = f(b, a) on one side; across the surface times the squared relative index of refraction
 * (Veach 1997, equation 5.14). */
static void test_light_may_go_either_way(void **state) {
    (void)state;
    int wrong = 0;
    json_t *entry;
    for (size_t i = 0; (entry = json_array_get(cases.table.configurations, i)); i++) {
        const json_t *ratio = json_object_get(entry, "transmission_ratio");
        if (!json_is_true(json_object_get(entry, "reciprocal")))
            continue;
        for (uint32_t k = 0; k < 200; k++) {
            struct vec3 a = random_direction(10, k), b = random_direction(20, k);
            a.z = fabsf(a.z);
            if (a.z < 0.02f || fabsf(b.z) < 0.02f || (b.z < 0 && !ratio))
                continue;
            struct vec3 there = scattering(entry, a, b), back = scattering(entry, b, a);
            if (b.z < 0)
                back = scale(back, (float)json_number_value(ratio));
            if (length(sub(there, back)) > 0.005f * length(there) + 1e-3f) {
                print_error("%s (%g %g %g) (%g %g %g): %g there, %g back\n", case_name(entry), a.x,
                            a.y, a.z, b.x, b.y, b.z, there.x, back.x);
                wrong++;
                break;
            }
        }
    }
    assert_int_equal(wrong, 0);
}

static bool is_sound(struct vec3 v) {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && isfinite(v.x + v.y + v.z);
}

/* One sample, and its direction's value and density. */
static bool is_sound_sample(const struct shading *s, float choice, const float u[2]) {
    struct bsdf_sample sample;
    if (!bsdf_sample(s, choice, u, &sample))
        return true;
    float pdf = bsdf_pdf(s, sample.direction);
    return is_sound(sample.weight) && sample.pdf > 0 && isfinite(sample.pdf) && sample.eta > 0 &&
           fabsf(length(sample.direction) - 1) < 1e-3f && pdf >= 0 && isfinite(pdf) &&
           is_sound(bsdf_times_cosine(s, sample.direction));
}

/* Views along the surface and along its normal, numbers at the ends of their range. */
static void test_extremes_stay_finite(void **state) {
    (void)state;
    static const struct vec3 ends[] = {{0, 0, 1},      {0, 0, -1},         {1, 0, 0},
                                       {0, -1, 0},     {1, 0, 1e-7f},      {-1, 0, -1e-7f},
                                       {0, 1, 1e-20f}, {0.8f, 0.6f, 1e-4f}};
    static const float numbers[] = {0, 1e-8f, 0.5f, 0x1.fffffep-1f};
    int wrong = 0;
    json_t *entry;
    for (size_t i = 0; (entry = json_array_get(cases.table.configurations, i)); i++)
        for (int e = 0; e < 8; e++) {
            struct shading s = case_shading(entry, ends[e], 0.5f, 0.5f);
            bool sound = is_sound(s.albedo) && max_component(s.albedo) <= 1.001f &&
                         s.delta_chance >= 0 && s.delta_chance <= 1.0001f && s.breadth >= 0 &&
                         s.breadth <= 1.0001f;
            for (int k = 0; k < 64; k++) {
                const float u[2] = {numbers[k % 4], numbers[k / 4 % 4]};
                sound = is_sound_sample(&s, numbers[k / 16], u) && sound;
            }
            for (int k = 0; k < 8; k++) {
                struct vec3 d = to_world(&cases.frame, ends[k]);
                float pdf = bsdf_pdf(&s, d);
                sound = sound && is_sound(bsdf_times_cosine(&s, d)) && pdf >= 0 && isfinite(pdf);
            }
            if (!sound) {
                print_error("%s: not finite from (%g %g %g)\n", case_name(entry), ends[e].x,
                            ends[e].y, ends[e].z);
                wrong++;
            }
        }
    assert_int_equal(wrong, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_samples_follow_pdf_and_weights_the_value),
        cmocka_unit_test(test_nothing_gains_energy),
        cmocka_unit_test(test_light_may_go_either_way),
        cmocka_unit_test(test_extremes_stay_finite),
    };
    return cmocka_run_group_tests(tests, cases_create, cases_destroy);
}
