/* SPDX-License-Identifier: Apache-2.0 */
/* From a material to the plain BSDFs at a point, and the sums over them. */

#include "guide/bsdf/bsdf.h"

#include "guide/bsdf/perturb.h"
#include "guide/trace/texture.h"

/* A point's way down through the wrappers. A two-sided BSDF seen from behind turns the local z axis
 * over, so that all below it works as if in front. */
struct place {
    const struct fewray_world *world;
    const struct surface *surface;
    struct vec3 outgoing;
    float weight;
    struct vec3 normal; /* the local z axis */
    struct basis frame; /* where has_frame; its n is `normal` */
    bool has_frame, perturbed;
    struct vec3 unperturbed_normal;
    float terminator_alpha2;
};

static struct vec3 color_of(const struct place *p, int texture) {
    return clamp_color(
        texture_value(&p->world->scene->textures[texture], p->surface->u, p->surface->v));
}

static struct vec3 color_or_white(const struct place *p, int texture) {
    return texture >= 0 ? color_of(p, texture) : vec(1, 1, 1);
}

/* Grey value of a texture; Mitsuba takes the luminance of coloured ones. */
static float grey_of(const struct place *p, int texture) {
    const struct texture *t = &p->world->scene->textures[texture];
    return luminance(texture_value(t, p->surface->u, p->surface->v));
}

/* Mitsuba's initialize_sh_frame(): s along dp/du. */
static struct basis shading_frame(const struct surface *surface, struct vec3 normal) {
    struct vec3 s = sub(surface->dp_du, scale(normal, dot(normal, surface->dp_du)));
    if (!(dot(s, s) > 0))
        return basis_around(normal);
    s = normalize(s);
    return (struct basis){s, cross(normal, s), normal};
}

static void ensure_frame(struct place *p, bool tangents) {
    if (p->has_frame)
        return;
    struct vec3 n = p->surface->normal;
    p->frame = tangents ? shading_frame(p->surface, n) : basis_around(n);
    p->frame.n = p->normal;
    p->has_frame = true;
}

static struct vec3 to_local(const struct basis *b, struct vec3 v) {
    return vec(dot(v, b->s), dot(v, b->t), dot(v, b->n));
}

static void look_up(const struct place *p, const struct bsdf *bsdf, struct bsdf_local *b) {
    if (bsdf->reflectance >= 0)
        b->reflectance = color_of(p, bsdf->reflectance);
    if (bsdf->kind == BSDF_DIFFUSE)
        return;
    b->specular_reflectance = color_or_white(p, bsdf->specular_reflectance);
    b->specular_transmittance = color_or_white(p, bsdf->specular_transmittance);
    if (bsdf->alpha_u >= 0)
        b->alpha_u = grey_of(p, bsdf->alpha_u);
    if (bsdf->alpha_v >= 0)
        b->alpha_v = bsdf->alpha_v == bsdf->alpha_u ? b->alpha_u : grey_of(p, bsdf->alpha_v);
    for (int i = 0; i < PRINCIPLED_COUNT && bsdf->kind == BSDF_PRINCIPLED; i++)
        b->principled[i] =
            bsdf->principled[i] >= 0 ? clamp_unit(grey_of(p, bsdf->principled[i])) : 0;
}

/* What the plain kinds do; see bsdf_local.h. */
static const struct {
    void (*prepare)(struct bsdf_local *);
    struct vec3 (*eval)(const struct bsdf_local *, struct vec3);
    float (*pdf)(const struct bsdf_local *, struct vec3);
    bool (*sample)(const struct bsdf_local *, float, const float[2], struct bsdf_sample *);
} plain[] = {
#define KIND(name)                                                                                 \
    { name##_prepare, name##_eval, name##_pdf, name##_sample }
    [BSDF_DIFFUSE] = KIND(diffuse),
    [BSDF_PLASTIC] = KIND(plastic),
    [BSDF_ROUGH_PLASTIC] = KIND(plastic),
    [BSDF_CONDUCTOR] = KIND(conductor),
    [BSDF_ROUGH_CONDUCTOR] = KIND(conductor),
    [BSDF_DIELECTRIC] = KIND(dielectric),
    [BSDF_THIN_DIELECTRIC] = KIND(dielectric),
    [BSDF_ROUGH_DIELECTRIC] = KIND(dielectric),
    [BSDF_PRINCIPLED] = KIND(principled),
    [BSDF_NULL] = {null_prepare, NULL, NULL, null_sample}, /* specular: never evaluated */
#undef KIND
};

/* Turns the frame as a bump or normal map says. */
static void perturb(struct place *p, const struct bsdf *bsdf) {
    ensure_frame(p, true);
    struct basis shading = shading_frame(p->surface, p->surface->normal);
    struct basis axes = perturbed_axes(p->world->scene, bsdf, p->surface, &shading,
                                       to_local(&p->frame, p->outgoing));
    if (!p->perturbed)
        p->unperturbed_normal = p->normal;
    if (bsdf->use_shadowing_function)
        p->terminator_alpha2 = fmaxf(p->terminator_alpha2, terminator_alpha2(axes.n.z));
    p->frame = (struct basis){to_world(&p->frame, axes.s), to_world(&p->frame, axes.t),
                              to_world(&p->frame, axes.n)};
    p->normal = p->frame.n;
    p->perturbed = true;
}

static void turn_over(struct place *p) {
    p->normal = p->frame.n = negate(p->normal);
    p->unperturbed_normal = negate(p->unperturbed_normal);
}

static void add_plain(struct place *p, const struct bsdf *bsdf, struct shading *out) {
    if (out->count == SHADING_LOCALS || !(p->weight > 0))
        return;
    struct bsdf_local *b = &out->locals[out->count++];
    b->bsdf = bsdf;
    b->table = &p->world->bsdf_tables[bsdf - p->world->scene->bsdfs];
    b->weight = p->weight;
    b->perturbed = p->perturbed;
    b->unperturbed_normal = p->unperturbed_normal;
    b->terminator_alpha2 = p->terminator_alpha2;
    look_up(p, bsdf, b);
    if (bsdf->kind == BSDF_DIFFUSE && !p->perturbed) {
        b->frame.n = p->normal;
        b->outgoing = vec(0, 0, dot(b->frame.n, p->outgoing));
    } else {
        ensure_frame(p, bsdf->tangents);
        b->frame = p->frame;
        b->outgoing = to_local(&b->frame, p->outgoing);
    }
    plain[bsdf->kind].prepare(b);
}

static void add_bsdf(struct place p, int index, struct shading *out) {
    const struct bsdf *bsdf = &p.world->scene->bsdfs[index];
    float share;
    switch (bsdf->kind) {
    case BSDF_TWOSIDED: {
        bool behind = dot(p.normal, p.outgoing) <= 0;
        if (behind)
            turn_over(&p);
        add_bsdf(p, bsdf->nested[behind && bsdf->nested[1] >= 0], out);
        break;
    }
    case BSDF_MASK:
    case BSDF_BLEND: {
        share = clamp_unit(grey_of(&p, bsdf->weight));
        struct place other = p;
        bool mask = bsdf->kind == BSDF_MASK;
        p.weight *= mask ? share : 1 - share;
        other.weight *= mask ? 1 - share : share;
        add_bsdf(p, bsdf->nested[0], out);
        add_bsdf(other, bsdf->nested[1], out);
        break;
    }
    case BSDF_BUMP_MAP:
    case BSDF_NORMAL_MAP:
        perturb(&p, bsdf);
        add_bsdf(p, bsdf->nested[0], out);
        break;
    default:
        add_plain(&p, bsdf, out);
    }
}

/* Whether it scatters light through the surface other than straight. */
static bool transmits(const struct bsdf_local *b) {
    return b->bsdf->kind == BSDF_ROUGH_DIELECTRIC ||
           (b->bsdf->kind == BSDF_PRINCIPLED && b->principled[PRINCIPLED_SPEC_TRANS] > 0);
}

/* Sums over the point's BSDFs. */
static void summarize(struct shading *out) {
    float smooth = 0;
    for (int i = 0; i < out->count; i++) {
        const struct bsdf_local *b = &out->locals[i];
        float rest = b->weight * (1 - b->delta_chance);
        out->delta_chance += b->weight * b->delta_chance;
        out->albedo = add(out->albedo, scale(b->albedo, b->weight));
        out->breadth += rest * b->breadth;
        smooth += rest;
        out->scatters |= b->delta_chance > 0 || max_component(b->albedo) > 0;
        out->transmits |= transmits(b);
    }
    out->breadth = smooth > 0 && !out->transmits ? out->breadth / smooth : 0;
}

void bsdf_at(const struct fewray_world *world, const struct surface *surface, struct vec3 outgoing,
             struct shading *out) {
    out->position = surface->position;
    out->geometric_normal = surface->geometric_normal;
    out->normal = dot(surface->normal, outgoing) < 0 ? negate(surface->normal) : surface->normal;
    out->albedo = vec(0, 0, 0);
    out->delta_chance = out->breadth = 0;
    out->scatters = out->transmits = false;
    out->count = 0;
    struct place place = {.world = world,
                          .surface = surface,
                          .outgoing = outgoing,
                          .weight = 1,
                          .normal = surface->normal};
    add_bsdf(place, surface->mesh->bsdf, out);
    summarize(out);
}

/* Share of the light from a direction that a bump or normal map leaves; local: the direction in the
 * frame that it made. 0 where the light would get through the surface, or through only one of both
 * surfaces. */
static float visibility(const struct bsdf_local *b, struct vec3 direction, struct vec3 local) {
    float cosine = dot(b->unperturbed_normal, direction);
    if (!(local.z * cosine > 0))
        return 0;
    return b->terminator_alpha2 > 0 ? terminator_shadowing(b->terminator_alpha2, cosine) : 1;
}

/* The incident direction in the BSDF's frame. Returns what a bump or normal map leaves of its
 * light. */
static float enter_frame(const struct bsdf_local *b, struct vec3 direction, struct vec3 *local) {
    if (b->bsdf->kind == BSDF_DIFFUSE && !b->perturbed) {
        *local = vec(0, 0, dot(b->frame.n, direction));
        return 1;
    }
    *local = to_local(&b->frame, direction);
    return b->perturbed ? visibility(b, direction, *local) : 1;
}

struct vec3 bsdf_times_cosine(const struct shading *s, struct vec3 incident) {
    struct vec3 sum = vec(0, 0, 0), local;
    for (int i = 0; i < s->count; i++) {
        const struct bsdf_local *b = &s->locals[i];
        float visible = b->delta_chance < 1 ? enter_frame(b, incident, &local) : 0;
        if (visible > 0)
            sum = add(sum, scale(plain[b->bsdf->kind].eval(b, local), b->weight * visible));
    }
    return sum;
}

float bsdf_pdf(const struct shading *s, struct vec3 incident) {
    float sum = 0;
    struct vec3 local;
    for (int i = 0; i < s->count; i++) {
        const struct bsdf_local *b = &s->locals[i];
        if (b->delta_chance < 1 && enter_frame(b, incident, &local) > 0)
            sum += b->weight * plain[b->bsdf->kind].pdf(b, local);
    }
    return sum;
}

/* The BSDF that `choice` falls on: first all perfectly specular parts, then all others. *choice
 * becomes what is left of it, for that BSDF's own use. */
static const struct bsdf_local *pick(const struct shading *s, float *choice) {
    const struct bsdf_local *last = NULL;
    bool delta = *choice < s->delta_chance;
    float left = delta ? *choice : *choice - s->delta_chance, share = 0;
    for (int i = 0; i < s->count; i++) {
        const struct bsdf_local *b = &s->locals[i];
        float next = b->weight * (delta ? b->delta_chance : 1 - b->delta_chance);
        if (!(next > 0))
            continue;
        left -= last ? share : 0;
        last = b;
        share = next;
        if (left < share)
            break;
    }
    if (!last)
        return NULL;
    float inside = fminf(fmaxf(left / share, 0), 0x1.fffffep-1f);
    *choice = delta ? inside * last->delta_chance
                    : last->delta_chance + inside * (1 - last->delta_chance);
    *choice = delta ? fminf(*choice, nextafterf(last->delta_chance, 0))
                    : fminf(fmaxf(*choice, last->delta_chance), 0x1.fffffep-1f);
    return last;
}

bool bsdf_sample(const struct shading *s, float choice, const float u[2], struct bsdf_sample *out) {
    const struct bsdf_local *b = pick(s, &choice);
    if (!b)
        return false;
    struct bsdf_local framed;
    if (b->bsdf->kind == BSDF_DIFFUSE && !b->perturbed) { /* it came without a whole frame */
        framed = *b;
        framed.frame = basis_around(b->frame.n);
        b = &framed;
    }
    if (!plain[b->bsdf->kind].sample(b, choice, u, out))
        return false;
    struct vec3 local = out->direction;
    out->direction = to_world(&b->frame, local);
    if (b->perturbed) {
        float visible = visibility(b, out->direction, local);
        if (!(visible > 0))
            return false;
        out->weight = scale(out->weight, visible);
    }
    if (out->delta) {
        out->pdf *= b->weight;
    } else if (s->count > 1) {
        out->pdf = bsdf_pdf(s, out->direction);
        if (!(out->pdf > 0))
            return false;
        out->weight = scale(bsdf_times_cosine(s, out->direction), 1 / out->pdf);
    }
    return true;
}
