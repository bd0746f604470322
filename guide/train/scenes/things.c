/* SPDX-License-Identifier: Apache-2.0 */
/* What mixed scenes have beside boxes. */

#include "guide/train/scenes/things.h"

#include "guide/train/scenes/dress.h"
#include "guide/train/scenes/palette.h"

static int ware_material(struct stage *stage) {
    struct random *r = &stage->random;
    float kind = uniform(r, 0, 1);
    if (kind < 0.3f)
        return surface_glass(stage);
    return kind < 0.5f ? surface_metal(stage) : surface_any(stage);
}

/* A smooth outline: radii as a sum of two waves, up outside and, for hollow ones, down inside. */
void build_vessel(struct stage *stage, struct xform place, float height, int material) {
    enum { RINGS = 14, HOLLOW = 2 * RINGS };
    struct random *r = &stage->random;
    float belly = uniform(r, 0.2f, 0.45f), wave = uniform(r, 0.05f, 0.45f) * belly,
          turns = uniform(r, 0.4f, 1.4f), phase = uniform(r, 0, 2 * PI_F),
          wall = uniform(r, 0.03f, 0.07f);
    bool hollow = chance(r, 0.7f);
    float profile[HOLLOW][2];
    for (int i = 0; i < RINGS; i++) {
        float t = (float)(i > 0 ? i - 1 : 0) / (RINGS - 2);
        float radius = belly + wave * sinf(2 * PI_F * turns * t + phase);
        int inner = HOLLOW - 1 - i;
        profile[i][0] = i == 0 ? 0 : radius * height;
        profile[i][1] = t * height;
        profile[inner][0] = i == 0 ? 0 : fmaxf(radius - wall, 0.02f) * height;
        profile[inner][1] = fmaxf(t, wall) * height;
    }
    int count = HOLLOW;
    if (!hollow) {
        profile[RINGS][0] = 0;
        profile[RINGS][1] = height;
        count = RINGS + 1;
    }
    stage_mesh(stage, place, mesh_revolution((const float(*)[2])profile, count, 24), material);
}

static void can(struct stage *stage, struct xform place, float radius, float height) {
    int material = chance(&stage->random, 0.5f) ? surface_metal(stage) : surface_any(stage);
    stage_cylinder(stage, place, vec(0, 0, 0), vec(0, height, 0), radius, material);
    stage_panel(stage, SHAPE_DISK, place, vec(0, height, 0), vec(0, 1, 0), radius, radius,
                material);
}

void build_ware(struct stage *stage, struct xform place, float size) {
    struct random *r = &stage->random;
    float a = size * uniform(r, 0.4f, 1);
    switch (between(r, 0, 5)) {
    case 0:
        stage_ball(stage, place, vec(0, a * 1.01f, 0), a, ware_material(stage));
        break;
    case 1:
        stage_box(stage, place, vec(0, a * 1.01f, 0), vec(a, a, a * uniform(r, 0.2f, 1)),
                  ware_material(stage));
        break;
    case 2:
        can(stage, place, a * 0.6f, size * uniform(r, 0.8f, 2));
        break;
    case 3: /* a book that lies, a card that stands */
        stage_box(stage, place, vec(0, size * 0.12f, 0), vec(size * 0.8f, size * 0.11f, size),
                  surface_print(stage));
        break;
    default:
        build_vessel(stage, moved(place, 0, 0.002f, 0, 0), size * uniform(r, 1, 3),
                     ware_material(stage));
    }
}

float build_foliage(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float height = uniform(r, 0.35f, 1.6f), spread = uniform(r, 0.15f, 0.5f);
    int leaf = surface_leaf(stage);
    if (chance(r, 0.25f)) {
        stage_mesh(stage, place, mesh_grass(r, between(r, 80, 400), spread, height * 0.6f), leaf);
    } else {
        struct vec3 top = vec(0, height + 0.2f * spread, 0);
        stage_cylinder(stage, place, vec(0, 0, 0), top, uniform(r, 0.006f, 0.03f),
                       surface_wood(stage));
        stage_mesh(stage, place,
                   mesh_foliage(r, (int)log_uniform(r, 60, 500), height, spread,
                                log_uniform(r, 0.03f, 0.16f)),
                   leaf);
    }
    float pot = uniform(r, 0.1f, 0.2f);
    can(stage, place, pot, pot * uniform(r, 0.8f, 1.4f));
    stage_look_here(stage, place, vec(0, height, 0));
    return spread;
}

float build_fence(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    int n = between(r, 8, 30),
        material = chance(r, 0.4f) ? surface_metal(stage) : surface_any(stage);
    float half = uniform(r, 0.4f, 1.1f), height = uniform(r, 0.5f, 1.8f),
          thin = log_uniform(r, 0.003f, 0.015f);
    for (int i = 0; i < n; i++) {
        float x = half * (2 * ((float)i + 0.5f) / (float)n - 1);
        stage_cylinder(stage, place, vec(x, 0, 0), vec(x, height, 0), thin, material);
    }
    for (int i = 0; i < 2; i++) {
        float y = height * (i ? 0.95f : 0.15f);
        stage_box(stage, place, vec(0, y, 0), vec(half, thin * 1.5f, thin * 1.5f), material);
    }
    return half * 0.7f;
}

float build_column(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float radius = uniform(r, 0.06f, 0.22f), height = uniform(r, 0.5f, 1.3f);
    int stone = surface_wall(stage);
    stage_cylinder(stage, place, vec(0, 0, 0), vec(0, height, 0), radius, stone);
    stage_box(stage, place, vec(0, height, 0), vec(radius * 1.3f, 0.03f, radius * 1.3f), stone);
    build_ware(stage, moved(place, 0, height + 0.03f, 0, uniform(r, 0, 6)), radius);
    stage_look_here(stage, place, vec(0, height, 0));
    return radius * 1.4f;
}

/* Things under a box of thin sheets. */
float build_glass_case(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float half = uniform(r, 0.2f, 0.4f), foot = uniform(r, 0.4f, 0.9f),
          tall = uniform(r, 0.2f, 0.5f);
    int pane = surface_pane(stage);
    stage_box(stage, place, vec(0, foot / 2, 0), vec(half, foot / 2, half), surface_wood(stage));
    for (int i = 0; i < 4; i++) {
        struct xform side = moved(place, 0, 0, 0, 0.5f * PI_F * (float)i);
        stage_panel(stage, SHAPE_RECTANGLE, side, vec(0, foot + tall / 2, half * 0.98f),
                    vec(0, 0, 1), half * 0.98f, tall / 2, pane);
    }
    for (int i = 0; i < 3; i++)
        build_ware(stage,
                   moved(place, uniform(r, -0.5f, 0.5f) * half, foot, half * 0.6f * (float)(i - 1),
                         uniform(r, 0, 6)),
                   half * 0.25f);
    stage_look_here(stage, place, vec(0, foot + tall / 2, 0));
    return half * 1.3f;
}

void build_mirror(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float half_x = uniform(r, 0.15f, 0.6f), half_y = uniform(r, 0.2f, 0.7f);
    stage_box(stage, place, vec(0, 0, 0.012f), vec(half_x + 0.03f, half_y + 0.03f, 0.01f),
              surface_wood(stage));
    stage_panel(stage, chance(r, 0.2f) ? SHAPE_DISK : SHAPE_RECTANGLE, place, vec(0, 0, 0.024f),
                vec(0, 0, 1), half_x, half_y, surface_mirror(stage));
}

void build_library(struct stage *stage, struct xform place, float x0, float x1, float y, float room,
                   float depth) {
    struct random *r = &stage->random;
    int covers[10];
    for (int i = 0; i < 10; i++)
        covers[i] = i < 3 ? surface_print(stage) : surface_any(stage);
    for (float x = x0; x < x1 - 0.05f;) {
        float width = uniform(r, 0.012f, 0.05f), height = room * uniform(r, 0.5f, 0.92f);
        if (x + width > x1)
            break;
        stage_box(stage, place, vec(x + width / 2, y + height / 2, 0),
                  vec(width * 0.47f, height / 2, depth * uniform(r, 0.35f, 0.45f)),
                  covers[between(r, 0, 9)]);
        x += width + (chance(r, 0.08f) ? uniform(r, 0.05f, 0.2f) : 0);
    }
}

float build_thing(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    switch (between(r, 0, 6)) {
    case 0:
    case 1:
        return build_foliage(stage, place);
    case 2:
        return build_fence(stage, place);
    case 3:
    case 4:
        return build_column(stage, place);
    case 5:
        return build_glass_case(stage, place);
    default: {
        float height = uniform(r, 0.4f, 1.1f);
        build_vessel(stage, moved(place, 0, 0.002f, 0, 0), height, ware_material(stage));
        stage_look_here(stage, place, vec(0, height / 2, 0));
        return height / 2;
    }
    }
}
