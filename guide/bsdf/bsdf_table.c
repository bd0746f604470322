/* SPDX-License-Identifier: Apache-2.0 */
/* What plastics need beforehand: mean reflectances of their textures, and what their coats let
 * through, as Mitsuba 3 computes them. */

#include "guide/bsdf/bsdf_local.h"

#include "guide/bsdf/fresnel.h"
#include "guide/bsdf/microfacet.h"
#include "guide/trace/texture.h"

#define MOST_NODES 48
#define MEAN_SIDE  1024 /* most pixels of a bitmap's mean along each axis */

static float bitmap_mean(const struct texture *texture) {
    struct texture t = *texture;
    static const float identity[6] = {1, 0, 0, 0, 1, 0};
    for (int i = 0; i < 6; i++)
        t.to_uv[i] = identity[i];
    t.nearest = true;
    int w = t.image->width, h = t.image->height;
    int step_x = 1 + (w - 1) / MEAN_SIDE, step_y = 1 + (h - 1) / MEAN_SIDE;
    double sum = 0, count = 0;
    for (int y = 0; y < h; y += step_y)
        for (int x = 0; x < w; x += step_x) {
            float u = ((float)x + 0.5f) / (float)w, v = ((float)y + 0.5f) / (float)h;
            sum += (double)luminance(texture_value(&t, u, v));
            count++;
        }
    return count > 0 ? (float)(sum / count) : 0;
}

/* Mitsuba's Texture::mean(): of bitmaps the luminance, of others the mean of the components; 1
 * without a texture. */
static float texture_mean(const struct fewray_scene *scene, int index) {
    if (index < 0)
        return 1;
    const struct texture *t = &scene->textures[index];
    switch (t->kind) {
    case TEXTURE_CONSTANT:
        return mean_component(t->color0);
    case TEXTURE_CHECKERBOARD:
        return 0.5f * (mean_component(t->color0) + mean_component(t->color1));
    case TEXTURE_BITMAP:
        return bitmap_mean(t);
    }
    return 0;
}

/* Gauss-Legendre quadrature on [0, 1]. */
struct quadrature {
    int count;
    float at[MOST_NODES], weight[MOST_NODES];
};

/* The roots of Legendre's polynomial by Newton's method (Press et al., Numerical Recipes, 3rd
 * edition, section 4.6). */
static struct quadrature quadrature_make(int n) {
    struct quadrature q = {.count = n};
    for (int i = 0; i < n; i++) {
        double x = cos(M_PI * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 20; step++) {
            double p = 1, previous = 0;
            for (int k = 1; k <= n; k++) {
                double next = ((2 * k - 1) * x * p - (k - 1) * previous) / k;
                previous = p;
                p = next;
            }
            slope = n * (x * p - previous) / (x * x - 1);
            x -= p / slope;
        }
        q.at[i] = (float)(0.5 * (1 + x));
        q.weight[i] = (float)(1 / ((1 - x * x) * slope * slope));
    }
    return q;
}

/* Shares of light at this angle that the microfacets mirror, or bend, once and that leaves then:
 * the integral over the visible ones of what Fresnel's equations give each way, and the shadowing
 * of the way out. What the Smith model loses in further bounces is in neither. */
struct coat_shares {
    float mirrored, passed;
};

static struct coat_shares coat_shares(const struct microfacets *d, const struct quadrature nodes[2],
                                      float cos_theta, float eta) {
    struct vec3 v = vec(sqrtf(fmaxf(1 - cos_theta * cos_theta, 0)), 0, cos_theta);
    double mirrored = 0, passed = 0;
    for (int i = 0; i < nodes[0].count; i++)
        for (int j = 0; j < nodes[1].count; j++) {
            /* the other half of u[1] holds the mirror images */
            const float u[2] = {nodes[0].at[i], 0.5f * nodes[1].at[j]};
            float weight = nodes[0].weight[i] * nodes[1].weight[j];
            struct vec3 m = microfacet_sample(d, v, u);
            struct fresnel f = fresnel_dielectric(dot(v, m), eta);
            struct vec3 up = reflect_at(v, m), down = refract_at(v, m, &f);
            if (up.z > 0)
                mirrored += (double)(weight * f.reflectance * microfacet_g1(d, up, m));
            if (down.z < 0 && f.reflectance < 1)
                passed += (double)(weight * (1 - f.reflectance) * microfacet_g1(d, down, m));
        }
    return (struct coat_shares){(float)mirrored, (float)passed};
}

static float entry_cos(int i) {
    return fmaxf((float)i / (BSDF_TRANSMITTANCE_SIZE - 1), 1e-6f);
}

static void fill_rough(const struct microfacets *d, float eta, struct bsdf_table *out) {
    /* For tables within 1e-3 of their limits: GGX's long tails need more nodes, and the inside does
     * for the kink where total reflection begins. */
    bool tails = d->kind == MICROFACET_GGX;
    int out_nodes = tails ? 32 : 22, in_nodes = tails ? MOST_NODES : 36;
    const struct quadrature outside[2] = {quadrature_make(out_nodes),
                                          quadrature_make(out_nodes / 2)};
    const struct quadrature inside[2] = {quadrature_make(in_nodes), quadrature_make(in_nodes / 2)};
    double internal = 0, transmitted = 0, shares = 0;
    for (int i = 0; i < BSDF_TRANSMITTANCE_SIZE; i++) {
        float c = entry_cos(i);
        bool end = i == 0 || i == BSDF_TRANSMITTANCE_SIZE - 1;
        struct coat_shares from_outside = coat_shares(d, outside, c, eta);
        out->transmittance[i] = fminf(from_outside.passed, 1);
        out->coat_albedo[i] = fminf(from_outside.mirrored, 1);
        internal += (double)(coat_shares(d, inside, c, 1 / eta).mirrored * c);
        transmitted += (double)(out->transmittance[i] * c) * (end ? 0.5 : 1);
        shares += (double)c * (end ? 0.5 : 1);
    }
    out->mean_transmittance = (float)(transmitted / shares);
    /* Mitsuba's sum: an end counts as much as any other entry. */
    out->internal_reflectance = (float)(2 * internal / BSDF_TRANSMITTANCE_SIZE);
    /* A cone of refraction too narrow for the table: what it lets in is held to what gets out. */
    float most = 1 - out->mean_transmittance / (eta * eta);
    if (out->internal_reflectance - most > 0.01f * fabsf(1 - most))
        out->internal_reflectance = most;
}

void bsdf_table_fill(const struct fewray_scene *scene, const struct bsdf *bsdf,
                     struct bsdf_table *out) {
    *out = (struct bsdf_table){0};
    if (bsdf->kind != BSDF_PLASTIC && bsdf->kind != BSDF_ROUGH_PLASTIC)
        return;
    float base = texture_mean(scene, bsdf->reflectance);
    float coat = texture_mean(scene, bsdf->specular_reflectance);
    out->specular_sampling_weight = base + coat > 0 ? coat / (base + coat) : 1;
    if (bsdf->kind == BSDF_PLASTIC) {
        out->internal_reflectance = fresnel_diffuse_reflectance(1 / bsdf->eta);
        out->mean_transmittance = 1 - fresnel_diffuse_reflectance(bsdf->eta);
        return;
    }
    float alpha = texture_mean(scene, bsdf->alpha_u);
    const struct microfacets d = microfacets_make(bsdf->microfacets, alpha, alpha);
    fill_rough(&d, bsdf->eta, out);
}
