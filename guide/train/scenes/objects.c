/* SPDX-License-Identifier: Apache-2.0 */
/* Clutter, stacks, plants, bars, partitions, steps, boulders, pictures and rugs. */

#include "guide/train/scenes/dress.h"
#include "guide/train/scenes/furniture.h"
#include "guide/train/scenes/palette.h"
#include "guide/train/scenes/things.h"

static void small_thing(struct stage *stage, struct xform place, float size) {
    struct random *r = &stage->random;
    if (stage->mixed && chance(r, 0.45f)) {
        build_ware(stage, place, size);
        return;
    }
    int material = surface_any(stage);
    float a = size * uniform(r, 0.4f, 1), b = size * uniform(r, 0.4f, 1.4f),
          c = size * uniform(r, 0.4f, 1);
    switch (between(r, 0, 6)) {
    case 0:
    case 1:
        stage_box(stage, place, vec(0, b, 0), vec(a, b, c), material);
        break;
    case 2:
        stage_ball(stage, place, vec(0, a, 0), a, material);
        break;
    case 3:
        stage_tube(stage, place, vec(0, 0, 0), a * 0.6f, b * 1.5f, between(r, 6, 10), material);
        break;
    case 4:
        stage_box(stage, tumbled(r, place, vec(0, size, 0)), vec(0, 0, 0),
                  vec(a, a * 0.7f, c * 0.7f), material);
        break;
    case 5: {
        struct xform leaning =
            xform_multiply(place, xform_rotate(vec(1, 0, 0), uniform(r, -0.3f, 0.3f)));
        stage_box(stage, leaning, vec(0, b * 1.5f, 0), vec(a * 0.1f, b * 1.5f, a * 0.1f), material);
        break;
    }
    default:
        for (int i = 0; i < 4; i++)
            stage_box(stage,
                      moved(place, 0, size * 0.22f * ((float)i + 0.5f), 0, uniform(r, -0.3f, 0.3f)),
                      vec(0, 0, 0), vec(a, size * 0.1f, c), i % 2 ? surface_any(stage) : material);
    }
}

void build_clutter(struct stage *stage, struct xform place, float half_x, float half_z, float size,
                   int n) {
    struct random *r = &stage->random;
    for (int i = 0; i < n; i++) {
        float x = uniform(r, -half_x, half_x), z = uniform(r, -half_z, half_z),
              yaw = uniform(r, 0, 2 * PI_F);
        small_thing(stage, moved(place, x, 0, z, yaw), size * uniform(r, 0.4f, 1.1f));
    }
}

float build_stack(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float half = uniform(r, 0.12f, 0.4f), y = 0, radius = half * 1.5f;
    int n = between(r, 1, 6);
    for (int i = 0; i < n && y < 2; i++) {
        float tall = half * uniform(r, 0.4f, 1), deep = half * uniform(r, 0.6f, 1);
        struct xform at = moved(place, uniform(r, -0.1f, 0.1f) * half, y + tall,
                                uniform(r, -0.1f, 0.1f) * half, uniform(r, -0.5f, 0.5f));
        stage_box(stage, at, vec(0, 0, 0), vec(half, tall, deep), surface_any(stage));
        y += 2 * tall;
        half *= uniform(r, 0.6f, 1);
    }
    if (chance(r, 0.4f))
        stage_ball(stage, place, vec(0, y + half * 0.7f, 0), half * 0.7f, surface_any(stage));
    stage_look_here(stage, place, vec(0, y * 0.6f, 0));
    return radius;
}

float build_plant(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float pot = uniform(r, 0.08f, 0.22f), height = uniform(r, 0.3f, 1.6f),
          spread = uniform(r, 0.12f, 0.5f);
    float leaf = uniform(r, 0.03f, 0.12f);
    int leaves = between(r, 12, 45),
        green = stage_material(stage, color_hsv(uniform(r, 0.2f, 0.4f), uniform(r, 0.4f, 0.8f),
                                                uniform(r, 0.1f, 0.5f)));
    int clay = surface_any(stage), bark = surface_wood(stage);
    stage_tube(stage, place, vec(0, 0, 0), pot, pot * 1.6f, 8, clay);
    stage_panel(stage, SHAPE_DISK, place, vec(0, pot * 1.4f, 0), vec(0, 1, 0), pot, pot, bark);
    stage_box(stage, place, vec(0, height / 2, 0), vec(0.012f, height / 2, 0.012f), bark);
    for (int i = 0; i < leaves; i++) {
        float rho = spread * sqrtf(uniform(r, 0, 1)), azimuth = uniform(r, 0, 2 * PI_F);
        struct vec3 at = vec(rho * cosf(azimuth), height + spread * uniform(r, -1.2f, 0.8f),
                             rho * sinf(azimuth));
        at.y = fmaxf(at.y, leaf);
        struct vec3 normal = vec(uniform(r, -1, 1), uniform(r, 0.1f, 1), uniform(r, -1, 1));
        stage_panel(stage, chance(r, 0.5f) ? SHAPE_DISK : SHAPE_RECTANGLE, place, at, normal, leaf,
                    leaf * uniform(r, 0.3f, 0.9f), green);
    }
    stage_look_here(stage, place, vec(0, height, 0));
    return fmaxf(pot, spread * 0.7f);
}

float build_bars(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float half_x = uniform(r, 0.3f, 1), height = uniform(r, 0.6f, 2.1f),
          thick = log_uniform(r, 0.006f, 0.03f);
    int n = between(r, 4, 16), material = surface_any(stage);
    for (int i = 0; i < n; i++) {
        float x = half_x * (2 * (float)i / (float)(n - 1) - 1);
        stage_box(stage, place, vec(x, height / 2, 0), vec(thick, height / 2, thick), material);
    }
    for (int i = 0; i < 2; i++)
        stage_box(stage, place, vec(0, height * (i ? 0.97f : 0.2f), 0),
                  vec(half_x, thick, thick * 1.2f), material);
    return half_x * 0.7f;
}

float build_partition(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    int panels = between(r, 1, 4), material = surface_any(stage);
    float width = uniform(r, 0.2f, 0.6f), height = uniform(r, 1, 2.2f),
          fold = uniform(r, 0.1f, 0.7f);
    struct xform at = moved(place, -width * (float)(panels - 1) * cosf(fold), 0, 0, 0);
    for (int i = 0; i < panels; i++) {
        struct xform turned =
            moved(at, 2 * width * cosf(fold) * (float)i, 0, 0, i % 2 ? fold : -fold);
        stage_box(stage, turned, vec(0, height / 2 + 0.03f, 0), vec(width, height / 2, 0.015f),
                  material);
    }
    return width * (float)panels * 0.8f;
}

float build_steps(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    int n = between(r, 3, 10),
        material = chance(r, 0.5f) ? surface_wood(stage) : surface_any(stage);
    float half_x = uniform(r, 0.3f, 0.7f), rise = uniform(r, 0.12f, 0.2f),
          run = uniform(r, 0.18f, 0.3f);
    bool solid = chance(r, 0.5f);
    for (int i = 0; i < n; i++) {
        float y = rise * ((float)i + 1), z = run * ((float)(n - 1) / 2 - (float)i);
        float half_y = solid ? y / 2 : 0.02f;
        stage_box(stage, place, vec(0, y - half_y, z), vec(half_x, half_y, run * 0.5f), material);
    }
    stage_look_here(stage, place, vec(0, rise * (float)n / 2, 0));
    return fmaxf(half_x, run * (float)n / 2);
}

float build_boulder(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    float radius = uniform(r, 0.1f, 0.5f);
    int n = between(r, 1, 5), material = surface_any(stage);
    for (int i = 0; i < n; i++) {
        float size = i ? radius * uniform(r, 0.3f, 0.8f) : radius,
              azimuth = uniform(r, 0, 2 * PI_F);
        float away = i ? radius * uniform(r, 0.9f, 1.6f) : 0;
        struct vec3 at = vec(away * cosf(azimuth), size, away * sinf(azimuth));
        if (chance(r, 0.5f))
            stage_ball(stage, place, at, size, i % 2 ? surface_any(stage) : material);
        else
            stage_box(stage, tumbled(r, place, vec(at.x, size * 0.8f, at.z)), vec(0, 0, 0),
                      vec(size * 0.6f, size * 0.5f, size * 0.7f), material);
    }
    stage_look_here(stage, place, vec(0, radius, 0));
    return radius * 1.5f;
}

void build_picture(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    if (stage->mixed && chance(r, 0.2f)) {
        build_mirror(stage, place);
        return;
    }
    float half_x = uniform(r, 0.12f, 0.6f), half_y = uniform(r, 0.12f, 0.45f),
          rim = uniform(r, 0.01f, 0.05f);
    int frame = surface_wood(stage);
    struct vec3 ink = color_any(r), paper = color_any(r);
    int motif =
        stage_checkerboard(stage, ink, paper, log_uniform(r, 0.5f, 12), log_uniform(r, 0.5f, 12));
    if (stage->mixed && chance(r, 0.6f))
        motif = surface_print(stage);
    stage_box(stage, place, vec(0, 0, 0.012f), vec(half_x + rim, half_y + rim, 0.01f), frame);
    stage_panel(stage, SHAPE_RECTANGLE, place, vec(0, 0, 0.024f), vec(0, 0, 1), half_x, half_y,
                motif);
    for (int i = between(r, 0, 3); i > 0; i--) {
        struct vec3 at = vec(uniform(r, -0.7f, 0.7f) * half_x, uniform(r, -0.7f, 0.7f) * half_y,
                             0.025f + 0.001f * (float)i);
        stage_panel(stage, SHAPE_DISK, place, at, vec(0, 0, 1), half_x * 0.25f, half_y * 0.25f,
                    surface_any(stage));
    }
}

void build_rug(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    stage_box(stage, place, vec(0, 0.006f, 0),
              vec(uniform(r, 0.5f, 1.4f), 0.006f, uniform(r, 0.4f, 1)), surface_any(stage));
}

float build_something(struct stage *stage, struct xform place) {
    struct random *r = &stage->random;
    if (stage->mixed && chance(r, 0.35f))
        return build_thing(stage, place);
    switch (between(r, 0, 11)) {
    case 0:
    case 1:
        return build_table(stage, place, chance(r, 0.7f));
    case 2:
        return build_chair(stage, place);
    case 3:
        return build_shelf(stage, place);
    case 4:
        return build_sofa(stage, place);
    case 5:
        return chance(r, 0.5f) ? build_bed(stage, place) : build_cabinet(stage, place);
    case 6:
        return build_stack(stage, place);
    case 7:
        return build_plant(stage, place);
    case 8:
        return build_bars(stage, place);
    case 9:
        return build_partition(stage, place);
    case 10:
        return build_steps(stage, place);
    default:
        return build_boulder(stage, place);
    }
}
