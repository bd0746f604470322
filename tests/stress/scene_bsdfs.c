/* SPDX-License-Identifier: Apache-2.0 */
/* BSDFs at the ends of their parameters: sampling, value and density stay finite and positive, and
 * no material makes light. */

#include "../unit/check.h"
#include "../unit/plain_bsdf.h"

#include <stdio.h>

#include "guide/bsdf/microfacet.h"
#include "guide/trace/sampler.h"

enum { SAMPLES = 256 };

struct plain_kind {
    const char *name;
    void (*prepare)(struct bsdf_local *);
    struct vec3 (*eval)(const struct bsdf_local *, struct vec3);
    float (*pdf)(const struct bsdf_local *, struct vec3);
    bool (*sample)(const struct bsdf_local *, float, const float[2], struct bsdf_sample *);
};
#define KIND(name)                                                                                 \
    { #name, name##_prepare, name##_eval, name##_pdf, name##_sample }
static const struct plain_kind diffuse = KIND(diffuse), conductor = KIND(conductor),
                               dielectric = KIND(dielectric), plastic = KIND(plastic),
                               principled = KIND(principled);

/* The white material of each kind: bounds of the share of even light that comes back. `least`:
 * where alpha is at most 1e-4, from outside; a microfacet model loses what is mirrored twice, 12 %
 * where the cosine is as small as alpha. `most`: anywhere; samples' noise is 0.01. */
static const struct material {
    const char *name;
    const struct plain_kind *kind;
    enum bsdf_kind bsdf;
    bool rough; /* alpha matters */
    bool etas;  /* so does eta */
    double least, most;
} materials[] = {
    {"diffuse", &diffuse, BSDF_DIFFUSE, false, false, 0.999, 1.001},
    {"conductor", &conductor, BSDF_CONDUCTOR, false, false, 0.999, 1.001},
    {"roughconductor", &conductor, BSDF_ROUGH_CONDUCTOR, true, false, 0.87, 1.01},
    {"dielectric", &dielectric, BSDF_DIELECTRIC, false, true, 0.999, 1.001},
    {"thindielectric", &dielectric, BSDF_THIN_DIELECTRIC, false, true, 0.999, 1.001},
    {"roughdielectric", &dielectric, BSDF_ROUGH_DIELECTRIC, true, true, 0.87, 1.01},
    /* Fits of the diffuse reflectances are 0.6 % off. */
    {"plastic", &plastic, BSDF_PLASTIC, false, true, 0, 1.01},
    /* Its table has 64 cosines: at the last before 0 it is off. */
    {"roughplastic", &plastic, BSDF_ROUGH_PLASTIC, true, true, 0, 1.06},
    /* Burley's diffuse lobe adds to the specular one, and up to 2 roughness to itself at grazing
     * angles: so is the model. */
    {"principled", &principled, BSDF_PRINCIPLED, true, true, 0, 2.25},
};

static const float alphas[] = {0, 1e-6f, 1e-4f, 1e-3f, 0.1f, 1};
static const float etas[] = {1.000001f, 1.01f, 1.5f, 3, 1e3f, 1 / 1.5f, 1e-3f};
static const float cosines[] = {1, 0.3f, 1e-2f, 1e-4f, 1e-6f, 1e-8f};
#define COUNT(array) ((int)(sizeof(array) / sizeof(*(array))))

struct setting {
    const struct material *material;
    float alpha, eta, cosine;
    bool ggx, inside;
    bool fresh; /* not the same but for the cosine as the one before: its table takes time */
};

static void describe(const struct setting *s, char text[160]) {
    snprintf(text, 160, "%s, %s, alpha %g, eta %.7g, cosine %s%g", s->material->name,
             s->ggx ? "ggx" : "beckmann", (double)s->alpha, (double)s->eta, s->inside ? "-" : "",
             (double)s->cosine);
}

static bool is_good(struct vec3 v) {
    return is_finite(v) && v.x >= 0 && v.y >= 0 && v.z >= 0;
}

static void check_sampled(const struct setting *s, const struct bsdf_local *b,
                          const struct bsdf_sample *out, const char *text) {
    if (!is_good(out->weight) || !(out->pdf > 0 && isfinite(out->pdf)) || !(out->eta > 0) ||
        !is_finite(out->direction) || !(fabsf(length(out->direction) - 1) < 1e-3f))
        fail_msg("%s: sampled weight %g, pdf %g, direction %g %g %g", text, (double)out->weight.x,
                 (double)out->pdf, (double)out->direction.x, (double)out->direction.y,
                 (double)out->direction.z);
    if (out->delta)
        return;
    struct vec3 value = s->material->kind->eval(b, out->direction);
    float pdf = s->material->kind->pdf(b, out->direction);
    if (!is_good(value) || !(pdf >= 0 && isfinite(pdf)))
        fail_msg("%s: value %g, pdf %g of a sample", text, (double)value.x, (double)pdf);
}

/* Directions that have nothing to do with the material's samples. */
static void check_anywhere(const struct setting *s, const struct bsdf_local *b, const char *text) {
    for (int i = 0; i < 2 * COUNT(cosines) * 8; i++) {
        float c = cosines[i / 16] * (i % 2 ? -1 : 1);
        struct vec3 incident = direction_at(c, 0.3f + (float)(i / 2 % 8) * (PI_F / 4));
        incident.z = c;
        struct vec3 value = s->material->kind->eval(b, incident);
        float pdf = s->material->kind->pdf(b, incident);
        if (!is_good(value) || !(pdf >= 0 && isfinite(pdf)))
            fail_msg("%s: value %g, pdf %g at %g", text, (double)value.x, (double)pdf, (double)c);
    }
}

/* Mean weight of the samples, radiance's scale by the index of refraction taken out: the albedo for
 * even light. */
static double check_setting(const struct setting *s) {
    struct plain_bsdf p;
    float values[PRINCIPLED_COUNT] = {[PRINCIPLED_ROUGHNESS] = sqrtf(s->alpha)};
    char text[160];
    describe(s, text);
    plain_bsdf_init(&p, s->material->bsdf, s->eta, vec(1, 1, 1), s->alpha, values);
    p.bsdf.conductor_k = vec(1, 1, 1);
    p.bsdf.microfacets = s->ggx ? MICROFACET_GGX : MICROFACET_BECKMANN;
    p.bsdf.specular_transmittance = PLAIN_SPECULAR;
    if (s->fresh)
        plain_bsdf_table(&p);
    static struct bsdf_table table;
    table = s->fresh ? p.table : table;
    p.table = table;
    struct vec3 outgoing = direction_at(s->cosine, 0.3f);
    outgoing.z = s->inside ? -s->cosine : s->cosine;
    struct bsdf_local b = plain_bsdf_at(&p, outgoing);
    b.specular_transmittance = vec(1, 1, 1);
    s->material->kind->prepare(&b);
    if (!is_good(b.albedo) || max_component(b.albedo) > 1.0001f || !(b.delta_chance >= 0) ||
        b.delta_chance > 1 || !(b.breadth >= 0 && b.breadth <= 1))
        fail_msg("%s: albedo %g, delta %g, breadth %g", text, (double)b.albedo.x,
                 (double)b.delta_chance, (double)b.breadth);
    double sum = 0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        float u[2], v[2];
        struct bsdf_sample out = {.pdf = 0};
        sobol_point(i, 1, u);
        sobol_point(i, 2, v);
        if (!s->material->kind->sample(&b, v[0], u, &out))
            continue;
        check_sampled(s, &b, &out, text);
        double crossed = (double)out.eta;
        sum += (double)out.weight.x * crossed * crossed / SAMPLES;
    }
    check_anywhere(s, &b, text);
    return sum;
}

static void test_extremes_stay_finite_and_make_no_light(void **state) {
    (void)state;
    for (int m = 0; m < COUNT(materials); m++)
        for (int a = 0; a < (materials[m].rough ? 2 * COUNT(alphas) : 1); a++)
            for (int e = 0; e < (materials[m].etas ? COUNT(etas) : 1); e++)
                for (int c = 0; c < 2 * COUNT(cosines); c++) {
                    struct setting s = {.material = &materials[m],
                                        .alpha = alphas[a / 2],
                                        .ggx = a % 2,
                                        .eta = etas[e],
                                        .cosine = cosines[c / 2],
                                        .inside = c % 2,
                                        .fresh = c == 0};
                    double albedo = check_setting(&s);
                    char text[160];
                    describe(&s, text);
                    bool is_smooth = s.alpha <= 1e-4f || !materials[m].rough;
                    double least = is_smooth && !s.inside ? materials[m].least : 0;
                    if (!(albedo >= least && albedo <= materials[m].most))
                        fail_msg("%s: %g of the light comes back, not %g to %g", text, albedo,
                                 least, materials[m].most);
                }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_extremes_stay_finite_and_make_no_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
