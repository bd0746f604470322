/* SPDX-License-Identifier: Apache-2.0 */
/* Walls with openings, windows, doors ajar and the lit rooms behind them. */

#include "guide/train/scenes/walls.h"

#include "guide/train/scenes/furniture.h"
#include "guide/train/scenes/palette.h"

/* A box given by its ranges in the wall's coordinates. */
static int block(struct stage *stage, struct xform place, float x0, float x1, float y0, float y1,
                 float z0, float z1, int material) {
    if (x1 - x0 < 1e-4f || y1 - y0 < 1e-4f)
        return 0;
    return stage_box(stage, place, vec((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2),
                     vec((x1 - x0) / 2, (y1 - y0) / 2, (z1 - z0) / 2), material);
}

void build_wall(struct stage *stage, const struct wall *wall) {
    float t = wall->thickness, from = -t, low = -t, high = wall->height + t;
    for (int i = 0; i < wall->opening_count; i++) {
        const struct opening *o = &wall->openings[i];
        block(stage, wall->place, from, o->x0, low, high, -t, 0, wall->material);
        block(stage, wall->place, o->x0, o->x1, low, o->y0, -t, 0, wall->material);
        block(stage, wall->place, o->x0, o->x1, o->y1, high, -t, 0, wall->material);
        from = o->x1;
    }
    block(stage, wall->place, from, wall->length + t, low, high, -t, 0, wall->material);
}

static void frame_around(struct stage *stage, const struct wall *wall, const struct opening *o,
                         float rim, float z0, float z1, bool sill, int material) {
    block(stage, wall->place, o->x0, o->x0 + rim, o->y0, o->y1, z0, z1, material);
    block(stage, wall->place, o->x1 - rim, o->x1, o->y0, o->y1, z0, z1, material);
    block(stage, wall->place, o->x0 + rim, o->x1 - rim, o->y1 - rim, o->y1, z0, z1, material);
    if (sill)
        block(stage, wall->place, o->x0 + rim, o->x1 - rim, o->y0, o->y0 + rim, z0, z1, material);
}

static void blinds(struct stage *stage, const struct wall *wall, const struct opening *o,
                   int material) {
    struct random *r = &stage->random;
    float pitch = uniform(r, 0.04f, 0.14f), tilt = uniform(r, -1.2f, 1.2f),
          width = (o->x1 - o->x0) / 2;
    float lowest = chance(r, 0.5f) ? o->y0 : o->y0 + (o->y1 - o->y0) * uniform(r, 0, 0.7f);
    pitch = fmaxf(pitch, (o->y1 - lowest) / 36);
    for (float y = o->y1 - pitch / 2; y > lowest; y -= pitch) {
        struct xform slat =
            xform_multiply(wall->place, xform_translate((o->x0 + o->x1) / 2, y, -0.04f));
        slat = xform_multiply(slat, xform_rotate(vec(1, 0, 0), tilt));
        stage_box(stage, slat, vec(0, 0, 0), vec(width * 0.98f, 0.0015f, pitch * 0.45f), material);
    }
}

static void curtains(struct stage *stage, const struct wall *wall, const struct opening *o,
                     int material) {
    struct random *r = &stage->random;
    float cover = uniform(r, 0.1f, 0.48f), width = o->x1 - o->x0, over = 0.1f,
          fold = uniform(r, 0.04f, 0.12f);
    float top = fminf(o->y1 + 0.1f, wall->height - 0.02f),
          bottom = chance(r, 0.5f) ? 0.03f : fmaxf(0.03f, o->y0 - 0.15f);
    for (int side = 0; side < 2; side++) {
        int n = (int)ceilf((cover * width + over) / fold);
        for (int i = 0; i < n && i < 30; i++) {
            float x = fold * ((float)i + 0.5f) - over;
            x = side ? o->x1 - x : o->x0 + x;
            struct xform at =
                moved(wall->place, x, (bottom + top) / 2, 0.08f, i % 2 ? 0.6f : -0.6f);
            stage_box(stage, at, vec(0, 0, 0), vec(fold * 0.62f, (top - bottom) / 2, 0.003f),
                      material);
        }
    }
}

void build_window(struct stage *stage, const struct wall *wall, const struct opening *o) {
    struct random *r = &stage->random;
    float middle = -wall->thickness * uniform(r, 0.3f, 0.9f), width = o->x1 - o->x0,
          height = o->y1 - o->y0;
    int paint = chance(r, 0.6f) ? surface_wall(stage) : surface_wood(stage);
    if (chance(r, 0.8f)) {
        float rim = uniform(r, 0.02f, 0.07f), thin = uniform(r, 0.008f, 0.03f);
        int nx = between(r, 0, 3), ny = between(r, 0, 3);
        frame_around(stage, wall, o, rim, middle - 0.03f, middle + 0.03f, true, paint);
        for (int i = 1; i <= nx; i++) {
            float x = o->x0 + width * (float)i / (float)(nx + 1);
            block(stage, wall->place, x - thin, x + thin, o->y0 + rim, o->y1 - rim, middle - thin,
                  middle + thin, paint);
        }
        for (int i = 1; i <= ny; i++) {
            float y = o->y0 + height * (float)i / (float)(ny + 1);
            block(stage, wall->place, o->x0 + rim, o->x1 - rim, y - thin, y + thin,
                  middle - thin * 0.9f, middle + thin * 0.9f, paint);
        }
    }
    float style = uniform(r, 0, 1);
    if (style < 0.15f) {
        blinds(stage, wall, o, paint);
    } else if (style < 0.3f) {
        int n = between(r, 3, 12), iron = surface_any(stage);
        for (int i = 1; i <= n; i++) {
            float x = o->x0 + width * (float)i / (float)(n + 1), thin = uniform(r, 0.006f, 0.015f);
            block(stage, wall->place, x - thin, x + thin, o->y0, o->y1,
                  -wall->thickness * 0.95f - thin, -wall->thickness * 0.95f + thin, iron);
        }
    } else if (style < 0.5f) {
        curtains(stage, wall, o, surface_any(stage));
    } else if (style < 0.6f) {
        float open = uniform(r, 0.1f, 0.8f);
        block(stage, wall->place, o->x0, o->x1, o->y0 + open * height, o->y1, -0.05f, -0.03f,
              surface_any(stage));
    }
    if (stage->mixed)
        build_glazing(stage, wall, o);
    if (chance(r, 0.6f) && o->y0 > 0.2f)
        block(stage, wall->place, o->x0 - 0.06f, o->x1 + 0.06f, o->y0 - 0.04f, o->y0,
              -wall->thickness, 0.08f, paint);
    if (chance(r, 0.6f))
        stage_look_here(stage, wall->place, vec((o->x0 + o->x1) / 2, (o->y0 + o->y1) / 2, 0));
}

void build_door(struct stage *stage, const struct wall *wall, const struct opening *o) {
    struct random *r = &stage->random;
    float rim = uniform(r, 0.02f, 0.05f), t = wall->thickness,
          width = o->x1 - o->x0 - 2 * rim - 0.01f;
    int frame = surface_wood(stage), wood = surface_wood(stage), metal = surface_any(stage);
    frame_around(stage, wall, o, rim, -t - 0.01f, 0.01f, false, frame);
    /* 0: closed. Mostly a little open, sometimes wide. */
    float angle = log_uniform(r, 0.05f, 1.9f), height = o->y1 - o->y0 - rim - 0.015f;
    bool inward = chance(r, 0.5f), left = chance(r, 0.5f);
    float hinge_z = inward ? -0.025f : -t + 0.025f, turn = inward ? -angle : angle;
    float hinge_x = left ? o->x0 + rim + 0.005f : o->x1 - rim - 0.005f;
    struct xform leaf = moved(wall->place, hinge_x, o->y0 + 0.01f, hinge_z, left ? turn : -turn);
    float side = left ? 1 : -1;
    stage_box(stage, leaf, vec(side * width / 2, height / 2, 0), vec(width / 2, height / 2, 0.02f),
              wood);
    if (chance(r, 0.5f))
        for (int i = 0; i < 2; i++)
            stage_box(stage, leaf, vec(side * width / 2, height * (i ? 0.72f : 0.26f), 0),
                      vec(width * 0.33f, height * 0.17f, 0.026f), wood);
    for (int face = -1; face <= 1; face += 2)
        stage_ball(stage, leaf, vec(side * width * 0.92f, height * 0.48f, (float)face * 0.06f),
                   0.03f, metal);
    for (int i = 0; i < 3; i++)
        stage_look_here(stage, wall->place, vec((o->x0 + o->x1) / 2, height * 0.45f, 0));
}

static void neighbour_lights(struct stage *stage, struct xform place, float x0, float x1,
                             float height, float depth, const struct opening *o, float share) {
    struct random *r = &stage->random;
    struct vec3 tint = color_light(r);
    int black = stage_material(stage, vec(0, 0, 0)), light;
    float middle = (x0 + x1) / 2, half_x = (x1 - x0) / 2;
    switch (between(r, 0, 3)) {
    case 0: /* a bright wall opposite the door */
        light = stage_panel(stage, SHAPE_RECTANGLE, place, vec(middle, height / 2, -depth + 0.02f),
                            vec(0, 0, 1), half_x * uniform(r, 0.3f, 0.9f),
                            height * uniform(r, 0.2f, 0.45f), black);
        break;
    case 1:
        light =
            stage_panel(stage, SHAPE_RECTANGLE, place,
                        vec(middle, height - 0.02f, -depth * uniform(r, 0.4f, 0.7f)), vec(0, -1, 0),
                        half_x * uniform(r, 0.2f, 0.6f), depth * uniform(r, 0.05f, 0.25f), black);
        break;
    case 2: { /* a window-like panel at the side, seen at a slant */
        float side = chance(r, 0.5f) ? 1.0f : -1.0f, x = middle + side * (half_x - 0.02f);
        light = stage_panel(stage, SHAPE_RECTANGLE, place, vec(x, height * 0.55f, -depth * 0.55f),
                            vec(-side, 0, 0), depth * uniform(r, 0.1f, 0.3f),
                            height * uniform(r, 0.1f, 0.35f), black);
        break;
    }
    default:
        light = stage_ball(stage, place,
                           vec((o->x0 + o->x1) / 2 + uniform(r, -0.4f, 0.4f),
                               height * uniform(r, 0.5f, 0.85f), -depth * 0.6f),
                           uniform(r, 0.05f, 0.2f), black);
    }
    stage_light(stage, light, tint, share);
}

void build_neighbour(struct stage *stage, const struct wall *wall, const struct opening *o,
                     float share) {
    struct random *r = &stage->random;
    float t = wall->thickness, depth = uniform(r, 1.2f, 5),
          height = fmaxf(o->y1 + 0.1f, uniform(r, 2, 3.2f));
    float x0 = fmaxf(0, o->x0 - uniform(r, 0.1f, 2.5f)),
          x1 = fminf(wall->length, o->x1 + uniform(r, 0.1f, 2.5f));
    height = fminf(height, wall->height);
    struct xform place = xform_multiply(wall->place, xform_translate(0, 0, -t));
    int paint = surface_wall(stage), ground = surface_floor(stage), top = surface_wall(stage);
    block(stage, place, x0 - t, x0, -t, height + t, -depth - t, 0, paint);
    block(stage, place, x1, x1 + t, -t, height + t, -depth - t, 0, paint);
    block(stage, place, x0 - t, x1 + t, -t, height + t, -depth - t, -depth, paint);
    block(stage, place, x0 - t, x1 + t, height, height + t, -depth - t, 0, top);
    block(stage, place, x0 - t, x1 + t, -t, 0, -depth - t, 0, ground);
    neighbour_lights(stage, place, x0, x1, height, depth, o, share);
    if (chance(r, 0.5f))
        build_something(stage, moved(place, uniform(r, x0 + 0.4f, x1 - 0.4f), 0, -depth * 0.75f,
                                     uniform(r, -0.5f, 0.5f)));
}
