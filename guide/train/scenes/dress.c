/* SPDX-License-Identifier: Apache-2.0 */
/* Materials and textures by what a surface is for. */

#include "guide/train/scenes/dress.h"

#include "guide/train/scenes/palette.h"

/* Shares in percent: plastic, rough plastic, conductor, rough conductor, principled; the rest is
 * diffuse. And the share of surfaces with a picture. */
static const struct {
    int kinds[5], picture;
} shares[] = {
    [ROLE_WALL] = {{4, 12, 0, 1, 7}, 45},
    [ROLE_FLOOR] = {{12, 24, 0, 2, 14}, 65},
    [ROLE_WOOD] = {{10, 24, 0, 0, 20}, 55},
    [ROLE_ANY] = {{12, 14, 4, 13, 13}, 25},
};

static enum picture_kind picture_kind(struct random *r, enum dress_role role) {
    static const enum picture_kind kinds[][8] = {
        [ROLE_WALL] = {PICTURE_CLOUDS, PICTURE_CLOUDS, PICTURE_BRICKS, PICTURE_TILES,
                       PICTURE_STRIPES, PICTURE_DOTS, PICTURE_GRAIN, PICTURE_MARBLE},
        [ROLE_FLOOR] = {PICTURE_WOOD, PICTURE_WOOD, PICTURE_WOOD, PICTURE_TILES, PICTURE_GRAIN,
                        PICTURE_MARBLE, PICTURE_CLOUDS, PICTURE_BRICKS},
        [ROLE_WOOD] = {PICTURE_WOOD, PICTURE_WOOD, PICTURE_WOOD, PICTURE_WOOD, PICTURE_WOOD,
                       PICTURE_WOOD, PICTURE_MARBLE, PICTURE_CLOUDS},
        [ROLE_ANY] = {PICTURE_CLOUDS, PICTURE_GRAIN, PICTURE_STRIPES, PICTURE_PLAID, PICTURE_PLAID,
                      PICTURE_DOTS, PICTURE_MARBLE, PICTURE_TEXT},
    };
    return kinds[role][between(r, 0, 7)];
}

/* A new picture of that kind, or one that exists where the stage has enough. */
static int stage_picture(struct stage *stage, enum picture_kind kind, struct vec3 color,
                         struct vec3 other) {
    struct random *r = &stage->random;
    if (stage->picture_count == STAGE_PICTURES || (stage->picture_count > 2 && chance(r, 0.5f)))
        return between(r, 0, stage->picture_count - 1);
    stage->pictures[stage->picture_count] = picture_random(r, kind, color, other);
    return stage->picture_count++;
}

static void set_picture(struct stage *stage, struct material *m, enum dress_role role) {
    struct random *r = &stage->random;
    struct vec3 other = chance(r, 0.6f) ? scale(m->color0, uniform(r, 0.3f, 0.85f)) : color_any(r);
    m->picture = stage_picture(stage, picture_kind(r, role), m->color0, other);
    m->color0 = stage->pictures[m->picture].colors[0];
    m->color1 = stage->pictures[m->picture].colors[1];
    bool large = role == ROLE_WALL || role == ROLE_FLOOR;
    m->scale_u = log_uniform(r, large ? 1 : 0.4f, large ? 7 : 3);
    m->scale_v = chance(r, 0.6f) ? m->scale_u : log_uniform(r, large ? 1 : 0.4f, large ? 7 : 3);
}

static enum material_kind choose_kind(struct random *r, enum dress_role role) {
    static const enum material_kind kinds[5] = {MATERIAL_PLASTIC, MATERIAL_ROUGH_PLASTIC,
                                                MATERIAL_CONDUCTOR, MATERIAL_ROUGH_CONDUCTOR,
                                                MATERIAL_PRINCIPLED};
    int u = between(r, 0, 99);
    for (int i = 0; i < 5; i++) {
        if (u < shares[role].kinds[i])
            return kinds[i];
        u -= shares[role].kinds[i];
    }
    return MATERIAL_DIFFUSE;
}

/* A metal of its own colour, or a pale one with the surface's colour as tint. */
static void set_metal(struct random *r, struct material *m) {
    static const char *const coloured[] = {"Au", "Cu", "TiN", "CuO", "VN"};
    static const char *const pale[] = {"Al", "Ag", "Cr", "W", "Ir", "Rh"};
    struct vec3 tint = vec(1, 1, 1);
    if (m->picture < 0 && chance(r, 0.4f)) {
        m->metal = coloured[between(r, 0, 4)];
    } else {
        m->metal = chance(r, 0.2f) ? "none" : pale[between(r, 0, 5)];
        if (chance(r, 0.5f))
            tint = scale(m->color0, 0.9f / fmaxf(max_component(m->color0), 1e-3f));
    }
    if (m->picture < 0)
        m->color0 = m->color1 = scale(tint, 0.95f);
}

static void set_principled(struct random *r, struct material *m) {
    m->metallic = chance(r, 0.25f) ? uniform(r, 0.3f, 1) : 0;
    m->specular = uniform(r, 0.1f, 0.9f);
    m->clearcoat = chance(r, 0.3f) ? uniform(r, 0.2f, 1) : 0;
    m->sheen = chance(r, 0.2f) ? uniform(r, 0.2f, 1) : 0;
    m->alpha = uniform(r, 0.15f, 0.9f);
}

int dress(struct stage *stage, int index, enum dress_role role) {
    struct random *r = &stage->random;
    if (!stage->mixed || index >= stage->material_count)
        return index;
    struct material m = stage->materials[index];
    m.kind = choose_kind(r, role);
    m.alpha = log_uniform(r, 0.05f, 0.5f);
    m.ggx = chance(r, 0.5f);
    m.ior = uniform(r, 1.35f, 1.7f);
    m.nonlinear = chance(r, 0.4f);
    bool metal = m.kind == MATERIAL_CONDUCTOR || m.kind == MATERIAL_ROUGH_CONDUCTOR;
    if (!metal && 100 * uniform(r, 0, 1) < (float)shares[role].picture)
        set_picture(stage, &m, role);
    if (metal)
        set_metal(r, &m);
    if (m.kind == MATERIAL_PRINCIPLED)
        set_principled(r, &m);
    stage->materials[index] = m;
    return index;
}

static struct material plain(struct vec3 color) {
    return (struct material){
        .color0 = color, .color1 = color, .scale_u = 1, .scale_v = 1, .picture = -1, .ior = 1.5f};
}

int surface_glass(struct stage *stage) {
    struct random *r = &stage->random;
    struct vec3 tint =
        chance(r, 0.6f) ? vec(1, 1, 1) : color_hsv(uniform(r, 0, 1), uniform(r, 0.1f, 0.6f), 1);
    struct material m = plain(tint);
    m.kind = chance(r, 0.12f) ? MATERIAL_ROUGH_DIELECTRIC : MATERIAL_DIELECTRIC;
    m.alpha = log_uniform(r, 0.03f, 0.35f);
    m.ggx = chance(r, 0.5f);
    m.ior = chance(r, 0.15f) ? uniform(r, 1.7f, 2.4f) : uniform(r, 1.3f, 1.6f);
    return stage_add_material(stage, &m);
}

int surface_pane(struct stage *stage) {
    struct material m = plain(scale(vec(0.98f, 1, 0.99f), uniform(&stage->random, 0.85f, 1)));
    m.kind = MATERIAL_THIN;
    return stage_add_material(stage, &m);
}

int surface_metal(struct stage *stage) {
    struct random *r = &stage->random;
    struct material m = plain(color_any(r));
    m.kind = MATERIAL_ROUGH_CONDUCTOR;
    m.alpha = log_uniform(r, 0.05f, 0.5f);
    m.ggx = chance(r, 0.6f);
    set_metal(r, &m);
    return stage_add_material(stage, &m);
}

int surface_mirror(struct stage *stage) {
    struct material m = plain(scale(vec(1, 1, 1), uniform(&stage->random, 0.8f, 0.97f)));
    m.kind = MATERIAL_CONDUCTOR;
    m.metal = chance(&stage->random, 0.5f) ? "none" : "Ag";
    return stage_add_material(stage, &m);
}

int surface_print(struct stage *stage) {
    struct random *r = &stage->random;
    struct material m = plain(chance(r, 0.5f) ? vec(0.85f, 0.84f, 0.8f) : color_any(r));
    enum picture_kind kind =
        chance(r, 0.5f) ? PICTURE_TEXT : (enum picture_kind)between(r, 0, PICTURE_KINDS - 1);
    struct vec3 ink = chance(r, 0.5f) ? vec(0.03f, 0.03f, 0.04f) : color_any(r);
    m.picture = stage_picture(stage, kind, m.color0, ink);
    m.color0 = stage->pictures[m.picture].colors[0];
    m.color1 = stage->pictures[m.picture].colors[1];
    m.kind = chance(r, 0.3f) ? MATERIAL_PLASTIC : MATERIAL_DIFFUSE;
    return stage_add_material(stage, &m);
}

int surface_leaf(struct stage *stage) {
    struct random *r = &stage->random;
    struct material m = plain(
        color_hsv(uniform(r, 0.15f, 0.42f), uniform(r, 0.4f, 0.85f), log_uniform(r, 0.08f, 0.5f)));
    m.kind = chance(r, 0.4f) ? MATERIAL_ROUGH_PLASTIC : MATERIAL_DIFFUSE;
    m.alpha = uniform(r, 0.15f, 0.4f);
    m.ggx = true;
    return stage_add_material(stage, &m);
}
