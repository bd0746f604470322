/* SPDX-License-Identifier: Apache-2.0 */
/* Furniture made of boxes: tables, chairs, shelves, sofas, beds, cabinets. */

#include "guide/train/scenes/furniture.h"

#include "guide/train/scenes/palette.h"
#include "guide/train/scenes/things.h"

static void four_legs(struct stage *stage, struct xform place, float half_x, float half_z,
                      float height, float thick, int material) {
    for (int i = 0; i < 4; i++) {
        float x = (i & 1 ? 1 : -1) * (half_x - thick), z = (i & 2 ? 1 : -1) * (half_z - thick);
        stage_box(stage, place, vec(x, height / 2, z), vec(thick, height / 2, thick), material);
    }
}

float build_table(struct stage *stage, struct xform place, bool laid) {
    struct random *r = &stage->random;
    float half_x = uniform(r, 0.3f, 1.1f), half_z = uniform(r, 0.25f, 0.6f),
          height = uniform(r, 0.35f, 0.95f);
    float thick = uniform(r, 0.015f, 0.05f);
    int wood = chance(r, 0.7f) ? surface_wood(stage) : surface_any(stage);
    stage_box(stage, place, vec(0, height - thick, 0), vec(half_x, thick, half_z), wood);
    if (chance(r, 0.75f)) {
        four_legs(stage, place, half_x, half_z, height - 2 * thick, uniform(r, 0.015f, 0.05f),
                  wood);
    } else {
        stage_box(stage, place, vec(0, height / 2 - thick, 0),
                  vec(0.05f, height / 2 - thick, 0.05f), wood);
        stage_box(stage, place, vec(0, 0.02f, 0), vec(half_x * 0.5f, 0.02f, half_z * 0.6f), wood);
    }
    if (laid)
        build_clutter(stage, moved(place, 0, height, 0, 0), half_x * 0.85f, half_z * 0.85f,
                      uniform(r, 0.04f, 0.12f), between(r, 2, 14));
    stage_look_here(stage, place, vec(0, height, 0));
    return sqrtf(half_x * half_x + half_z * half_z);
}

float build_chair(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float half = uniform(r, 0.19f, 0.26f), seat = uniform(r, 0.4f, 0.5f),
          back = uniform(r, 0.3f, 0.6f);
    float thick = uniform(r, 0.01f, 0.025f);
    int wood = chance(r, 0.6f) ? surface_wood(stage) : surface_any(stage);
    four_legs(stage, place, half, half, seat, thick, wood);
    stage_box(stage, place, vec(0, seat, 0), vec(half, uniform(r, 0.015f, 0.04f), half),
              chance(r, 0.5f) ? wood : surface_any(stage));
    if (chance(r, 0.5f)) {
        stage_box(stage, place, vec(0, seat + back / 2 + 0.05f, -half + thick),
                  vec(half, back / 2, thick), wood);
    } else {
        int slats = between(r, 3, 7);
        stage_box(stage, place, vec(0, seat + back, -half + thick), vec(half, 0.03f, thick), wood);
        for (int i = 0; i < slats; i++) {
            float x = half * (2 * ((float)i + 0.5f) / (float)slats - 1);
            stage_box(stage, place, vec(x, seat + back / 2, -half + thick),
                      vec(0.012f, back / 2, thick * 0.6f), wood);
        }
    }
    return half * 1.5f;
}

static void books(struct stage *stage, struct xform place, float x0, float x1, float y, float room,
                  float depth) {
    struct random *r = &stage->random;
    int materials[4];
    for (int i = 0; i < 4; i++)
        materials[i] = surface_any(stage);
    for (float x = x0; x < x1 - 0.05f;) {
        float width = uniform(r, 0.015f, 0.06f), height = room * uniform(r, 0.5f, 0.92f);
        if (chance(r, 0.12f))
            x += uniform(r, 0.05f, 0.3f);
        if (x + width > x1)
            break;
        struct vec3 half = vec(width * 0.48f, height / 2, depth * uniform(r, 0.3f, 0.45f));
        stage_box(stage, place, vec(x + width / 2, y + height / 2, 0), half,
                  materials[between(r, 0, 3)]);
        x += width;
    }
}

float build_shelf(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float half_x = uniform(r, 0.3f, 0.9f), height = uniform(r, 0.8f, 2.1f),
          depth = uniform(r, 0.2f, 0.4f);
    int boards = between(r, 2, 5), wood = surface_wood(stage);
    float thick = 0.012f, gap = height / (float)boards;
    for (int side = -1; side <= 1; side += 2)
        stage_box(stage, place, vec((float)side * half_x, height / 2, 0),
                  vec(thick, height / 2, depth / 2), wood);
    if (chance(r, 0.6f))
        stage_box(stage, place, vec(0, height / 2, -depth / 2), vec(half_x, height / 2, 0.005f),
                  wood);
    for (int i = 0; i <= boards; i++)
        stage_box(stage, place, vec(0, gap * (float)i + thick, 0), vec(half_x, thick, depth / 2),
                  wood);
    for (int i = 0; i < boards; i++) {
        float y = gap * (float)i + 2 * thick;
        if (stage->mixed && chance(r, 0.7f))
            build_library(stage, place, -half_x + 0.03f, half_x - 0.03f, y, gap - 2 * thick, depth);
        else if (chance(r, 0.5f))
            books(stage, place, -half_x + 0.03f, half_x - 0.03f, y, gap - 2 * thick, depth);
        else if (chance(r, 0.6f))
            build_clutter(stage, moved(place, 0, y, 0, 0), half_x * 0.8f, depth * 0.3f,
                          fminf(0.08f, gap * 0.2f), between(r, 1, 5));
    }
    stage_look_here(stage, place, vec(0, height / 2, 0));
    return half_x;
}

float build_sofa(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float half_x = uniform(r, 0.4f, 1.1f), depth = uniform(r, 0.38f, 0.5f),
          seat = uniform(r, 0.3f, 0.45f);
    float back = uniform(r, 0.3f, 0.5f), arm = uniform(r, 0.06f, 0.14f);
    int cloth = surface_any(stage), pillow = surface_any(stage),
        seats = half_x > 0.7f   ? 3
                : half_x > 0.5f ? 2
                                : 1;
    stage_box(stage, place, vec(0, seat * 0.4f + 0.05f, 0), vec(half_x, seat * 0.4f, depth), cloth);
    stage_box(stage, place, vec(0, seat + back * 0.4f, -depth + 0.08f),
              vec(half_x, back * 0.6f, 0.09f), cloth);
    for (int side = -1; side <= 1; side += 2)
        stage_box(stage, place, vec((float)side * (half_x + arm), seat * 0.75f, 0),
                  vec(arm, seat * 0.7f, depth), cloth);
    for (int i = 0; i < seats; i++) {
        float width = half_x / (float)seats,
              x = half_x * (2 * ((float)i + 0.5f) / (float)seats - 1);
        stage_box(stage, place, vec(x, seat * 0.8f + 0.1f, 0.06f),
                  vec(width * 0.97f, 0.07f, depth * 0.88f), cloth);
        if (chance(r, 0.5f)) {
            struct xform leaning =
                moved(place, x, seat + 0.25f, -depth * 0.35f, uniform(r, -0.4f, 0.4f));
            leaning = xform_multiply(leaning, xform_rotate(vec(1, 0, 0), uniform(r, -0.6f, -0.2f)));
            stage_box(stage, leaning, vec(0, 0, 0), vec(0.18f, 0.18f, 0.05f), pillow);
        }
    }
    stage_look_here(stage, place, vec(0, seat, 0));
    return half_x + arm;
}

float build_bed(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float half_x = uniform(r, 0.45f, 0.95f), half_z = uniform(r, 0.9f, 1.05f),
          height = uniform(r, 0.3f, 0.5f);
    int wood = surface_wood(stage), sheet = surface_any(stage), pillow = surface_wall(stage);
    stage_box(stage, place, vec(0, height * 0.35f, 0), vec(half_x, height * 0.2f, half_z), wood);
    stage_box(stage, place, vec(0, height * 0.75f, 0),
              vec(half_x * 0.97f, height * 0.22f, half_z * 0.98f), pillow);
    stage_box(stage, place, vec(0, height * 0.8f, half_z * 0.25f),
              vec(half_x * 1.02f, height * 0.24f, half_z * 0.7f), sheet);
    stage_box(stage, place, vec(0, height, -half_z), vec(half_x, height * 0.8f, 0.03f), wood);
    for (int side = -1; side <= 1; side += 2) {
        struct xform at = moved(place, (float)side * half_x * 0.48f, height + 0.06f, -half_z * 0.7f,
                                uniform(r, -0.2f, 0.2f));
        stage_box(stage, at, vec(0, 0, 0), vec(half_x * 0.38f, 0.07f, 0.18f), pillow);
    }
    stage_look_here(stage, place, vec(0, height, 0));
    return half_z;
}

float build_cabinet(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float half_x = uniform(r, 0.25f, 0.9f), height = uniform(r, 0.4f, 2),
          depth = uniform(r, 0.2f, 0.35f);
    int wood = chance(r, 0.6f) ? surface_wood(stage) : surface_any(stage),
        knob = surface_any(stage);
    int columns = between(r, 1, 4), rows = between(r, 1, 4);
    stage_box(stage, place, vec(0, height / 2, 0), vec(half_x, height / 2, depth), wood);
    float cell_x = half_x / (float)columns, cell_y = height / 2 / (float)rows;
    for (int i = 0; i < columns * rows; i++) {
        float x = -half_x + cell_x * (float)(2 * (i % columns) + 1),
              y = cell_y * (float)(2 * (i / columns) + 1);
        stage_box(stage, place, vec(x, y, depth), vec(cell_x * 0.92f, cell_y * 0.92f, 0.012f),
                  wood);
        stage_ball(stage, place, vec(x + cell_x * 0.6f, y, depth + 0.025f), 0.015f, knob);
    }
    if (height < 1.4f)
        build_clutter(stage, moved(place, 0, height, 0, 0), half_x * 0.8f, depth * 0.7f,
                      uniform(r, 0.05f, 0.15f), between(r, 0, 6));
    stage_look_here(stage, place, vec(0, height * 0.6f, 0));
    return half_x;
}
