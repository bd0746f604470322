/* SPDX-License-Identifier: Apache-2.0 */
/* The world outside: sky, sun, ground, houses and trees. */

#include "guide/train/scenes/builders.h"
#include "guide/train/scenes/palette.h"

/* A disk so far away that its light is nearly parallel: a sun for scenes without a sky picture. */
static void distant_sun(struct stage *stage, float strength) {
    struct random *r = &stage->random;
    float y = uniform(r, 0.15f, 0.9f), azimuth = uniform(r, 0, 2 * PI_F), rho = sqrtf(1 - y * y);
    struct vec3 dir = vec(rho * cosf(azimuth), y, rho * sinf(azimuth));
    float distance = 150, radius = distance * log_uniform(r, 0.006f, 0.05f);
    if (stage->mixed && chance(r, 0.4f))
        radius = distance * 0.00465f; /* the sun's own */
    float irradiance = strength * PI_F * log_uniform(r, 0.3f, 10);
    int disk = stage_panel(stage, SHAPE_DISK, stage->root, scale(dir, distance), negate(dir),
                           radius, radius, stage_material(stage, vec(0, 0, 0)));
    if (disk < stage->shape_count) {
        float radiance = irradiance * distance * distance / (PI_F * radius * radius);
        stage->shapes[disk].radiance = scale(vec(1, 0.93f, 0.82f), radiance);
    }
}

void build_sky(struct stage *stage, float strength) {
    struct random *r = &stage->random;
    float kind = uniform(r, 0, 1);
    if (kind < 0.6f) {
        sky_random(&stage->sky, r);
    } else {
        stage->sky = (struct sky){.kind = SKY_CONSTANT, .horizon = color_light(r), .sun_cos = 2};
        if (kind < 0.85f && !stage->panes)
            distant_sun(stage, strength);
    }
    if (stage->panes) /* connections to a sun behind glass are blocked: it would only be noise */
        stage->sky.sun = vec(0, 0, 0);
    stage->sky.strength = strength;
}

static void tree(struct stage *stage, struct xform place, float height) {
    struct random *r = &stage->random;
    int green = stage_material(
        stage, color_hsv(uniform(r, 0.15f, 0.4f), uniform(r, 0.3f, 0.8f), uniform(r, 0.08f, 0.5f)));
    int bark = surface_wood(stage);
    stage_box(stage, place, vec(0, height / 2, 0), vec(height * 0.03f, height / 2, height * 0.03f),
              bark);
    for (int i = between(r, 1, 4); i > 0; i--) {
        float size = height * uniform(r, 0.15f, 0.3f);
        struct vec3 at = vec(uniform(r, -0.2f, 0.2f) * height, height * uniform(r, 0.6f, 1),
                             uniform(r, -0.2f, 0.2f) * height);
        stage_ball(stage, place, at, size, green);
    }
}

static void house(struct stage *stage, struct xform place, float size) {
    struct random *r = &stage->random;
    float half_x = size * uniform(r, 0.4f, 1), half_z = size * uniform(r, 0.4f, 1),
          height = size * uniform(r, 0.5f, 2.5f);
    int paint = surface_wall(stage), glass = stage_material(stage, vec(0.08f, 0.1f, 0.12f));
    stage_box(stage, place, vec(0, height / 2, 0), vec(half_x, height / 2, half_z), paint);
    int columns = between(r, 1, 4), rows = between(r, 1, 4);
    for (int i = 0; i < columns * rows; i++) {
        float x = half_x * (2 * ((float)(i % columns) + 0.5f) / (float)columns - 1);
        float y = height * ((float)(i / columns) + 0.6f) / ((float)rows + 0.2f);
        stage_box(stage, place, vec(x, y, half_z),
                  vec(half_x / (float)columns * 0.4f, height / (float)rows * 0.25f, 0.03f), glass);
    }
}

void build_surroundings(struct stage *stage, float radius, float ground_y) {
    struct random *r = &stage->random;
    int earth = surface_floor(stage);
    stage_panel(stage, SHAPE_RECTANGLE, stage->root, vec(0, ground_y, 0), vec(0, 1, 0), radius * 8,
                radius * 8, earth);
    for (int i = between(r, 0, 10); i > 0; i--) {
        float azimuth = uniform(r, 0, 2 * PI_F), away = radius * uniform(r, 2, 6);
        struct xform place = moved(stage->root, away * cosf(azimuth), ground_y,
                                   away * sinf(azimuth), uniform(r, 0, 6));
        if (chance(r, 0.5f))
            tree(stage, place, uniform(r, 2, 7));
        else
            house(stage, place, fminf(away * 0.3f, uniform(r, 2, 6)));
    }
}
