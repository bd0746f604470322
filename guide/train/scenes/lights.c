/* SPDX-License-Identifier: Apache-2.0 */
/* Electric lights: panels, coves, hidden panels, bulbs, glowing things, lamps with shades. */

#include "guide/train/scenes/lights.h"

#include "guide/train/scenes/palette.h"

static int black(struct stage *stage) {
    return stage_material(stage, vec(0, 0, 0));
}

void light_ceiling(struct stage *stage, struct xform place, struct room_size size, float share) {
    struct random *r = &stage->random;
    int nx = between(r, 1, 3), nz = between(r, 1, 3), dark = black(stage);
    bool round = chance(r, 0.3f), hanging = chance(r, 0.3f);
    float y = size.height - (hanging ? uniform(r, 0.1f, 0.6f) : 0.01f),
          fill = uniform(r, 0.05f, 0.6f);
    struct vec3 tint = color_light(r);
    for (int i = 0; i < nx * nz; i++) {
        float x = size.width * (((float)(i % nx) + 0.5f) / (float)nx - 0.5f);
        float z = size.depth * (((float)(i / nx) + 0.5f) / (float)nz - 0.5f);
        float half_x = size.width / (float)nx * 0.5f * fill,
              half_z = size.depth / (float)nz * 0.5f * fill;
        if (round)
            half_x = half_z = fminf(half_x, half_z);
        int light = stage_panel(stage, round ? SHAPE_DISK : SHAPE_RECTANGLE, place, vec(x, y, z),
                                vec(0, -1, 0), half_x, half_z, dark);
        stage_light(stage, light, tint, share / (float)(nx * nz));
        if (hanging)
            stage_box(stage, place, vec(x, y + 0.03f, z),
                      vec(half_x * 1.05f, 0.02f, half_z * 1.05f), surface_any(stage));
    }
}

void light_cove(struct stage *stage, struct xform place, struct room_size size, float share) {
    struct random *r = &stage->random;
    int sides = between(r, 1, 4), first = between(r, 0, 3), dark = black(stage),
        plaster = surface_wall(stage);
    float y = size.height - uniform(r, 0.12f, 0.35f), reach = uniform(r, 0.08f, 0.25f);
    struct vec3 tint = color_light(r);
    for (int i = 0; i < sides; i++) {
        int side = (first + i) % 4;
        float along = (side % 2 ? size.depth : size.width) / 2,
              away = (side % 2 ? size.width : size.depth) / 2;
        struct xform at = moved(place, 0, 0, 0, -0.5f * PI_F * (float)side);
        stage_box(stage, at, vec(0, y, -away + reach / 2), vec(along, 0.015f, reach / 2), plaster);
        stage_box(stage, at, vec(0, y + 0.03f, -away + reach), vec(along, 0.045f, 0.01f), plaster);
        int light = stage_panel(stage, SHAPE_RECTANGLE, at, vec(0, y + 0.02f, -away + reach * 0.5f),
                                vec(0, 1, 0), along * 0.95f, reach * 0.2f, dark);
        stage_light(stage, light, tint, share / (float)sides);
    }
}

void light_hidden(struct stage *stage, struct xform place, struct room_size size, float share) {
    struct random *r = &stage->random;
    int side = between(r, 0, 3), dark = black(stage);
    float along = (side % 2 ? size.depth : size.width) / 2,
          away = (side % 2 ? size.width : size.depth) / 2;
    float half = along * uniform(r, 0.15f, 0.5f), tall = uniform(r, 0.2f, 0.7f),
          gap = uniform(r, 0.08f, 0.4f);
    float y = chance(r, 0.5f) ? tall : uniform(r, tall, fmaxf(tall, size.height - tall));
    struct xform at = moved(place, 0, 0, 0, -0.5f * PI_F * (float)side);
    float x = uniform(r, -1, 1) * (along - half);
    stage_box(stage, at, vec(x, y, -away + gap), vec(half, tall, 0.02f), surface_any(stage));
    int light =
        stage_panel(stage, SHAPE_RECTANGLE, at, vec(x, y, -away + gap - 0.025f), vec(0, 0, -1),
                    half * uniform(r, 0.4f, 0.95f), tall * uniform(r, 0.2f, 0.9f), dark);
    stage_light(stage, light, color_light(r), share);
    stage_look_here(stage, at, vec(x, y, -away + gap));
}

void light_many(struct stage *stage, struct xform place, struct room_size size, float share) {
    struct random *r = &stage->random;
    int n = between(r, 5, 24), dark = black(stage);
    bool spots = chance(r, 0.4f), coloured = chance(r, 0.4f);
    float radius = log_uniform(r, 0.01f, 0.07f);
    struct vec3 tint = color_light(r);
    for (int i = 0; i < n; i++) {
        float x = uniform(r, -0.46f, 0.46f) * size.width,
              z = uniform(r, -0.46f, 0.46f) * size.depth;
        int light;
        if (spots) {
            light = stage_panel(stage, SHAPE_DISK, place, vec(x, size.height - 0.01f, z),
                                vec(0, -1, 0), radius * 1.5f, radius * 1.5f, dark);
        } else {
            float y = uniform(r, 0.4f, 0.95f) * size.height;
            light = stage_ball(stage, place, vec(x, y, z), radius, dark);
            stage_box(stage, place, vec(x, (y + radius + size.height) / 2, z),
                      vec(0.003f, (size.height - y - radius) / 2, 0.003f), dark);
        }
        stage_light(stage, light, coloured ? color_light(r) : tint,
                    share / (float)n * log_uniform(r, 0.4f, 2));
    }
}

void light_glow(struct stage *stage, struct xform place, struct room_size size, float share) {
    struct random *r = &stage->random;
    int side = between(r, 0, 3);
    float along = (side % 2 ? size.depth : size.width) / 2,
          away = (side % 2 ? size.width : size.depth) / 2;
    float half_x = fminf(along * 0.4f, uniform(r, 0.15f, 0.9f)), half_y = uniform(r, 0.1f, 0.4f);
    float x = uniform(r, -0.5f, 0.5f) * along,
          y = half_y + uniform(r, 0.1f, size.height - 2 * half_y - 0.1f);
    struct xform at = moved(place, 0, 0, 0, -0.5f * PI_F * (float)side);
    stage_box(stage, at, vec(x, y, -away + 0.03f), vec(half_x + 0.03f, half_y + 0.03f, 0.02f),
              surface_any(stage));
    int light = stage_panel(stage, SHAPE_RECTANGLE, at, vec(x, y, -away + 0.055f), vec(0, 0, 1),
                            half_x, half_y, black(stage));
    stage_light(stage, light, color_light(r), share);
}

void light_lamp(struct stage *stage, struct xform place, struct room_size size, float share) {
    struct random *r = &stage->random;
    float radius = uniform(r, 0.08f, 0.3f), tall = uniform(r, 0.1f, 0.35f),
          bulb = uniform(r, 0.02f, 0.06f);
    float x = uniform(r, -0.4f, 0.4f) * size.width, z = uniform(r, -0.4f, 0.4f) * size.depth;
    bool hanging = chance(r, 0.5f);
    float y = hanging ? size.height * uniform(r, 0.45f, 0.8f) : uniform(r, 0.6f, 1.6f);
    int cloth = surface_any(stage), metal = surface_any(stage);
    struct xform at = moved(place, x, 0, z, uniform(r, 0, 2));
    stage_tube(stage, at, vec(0, y, 0), radius, tall, 10, cloth);
    if (hanging) {
        stage_box(stage, at, vec(0, (y + tall + size.height) / 2, 0),
                  vec(0.005f, (size.height - y - tall) / 2, 0.005f), metal);
        if (chance(r, 0.6f))
            stage_panel(stage, SHAPE_DISK, at, vec(0, y + tall, 0), vec(0, -1, 0), radius, radius,
                        cloth);
    } else {
        stage_box(stage, at, vec(0, y / 2, 0), vec(0.012f, y / 2, 0.012f), metal);
        stage_box(stage, at, vec(0, 0.015f, 0), vec(0.14f, 0.015f, 0.14f), metal);
    }
    int light =
        stage_ball(stage, at, vec(0, y + tall * uniform(r, 0.4f, 0.7f), 0), bulb, black(stage));
    stage_light(stage, light, color_light(r), share);
    stage_look_here(stage, at, vec(0, y * 0.7f, 0));
}
