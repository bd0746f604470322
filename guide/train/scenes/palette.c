/* SPDX-License-Identifier: Apache-2.0 */
/* Random colours and surfaces, so that pictures look lived in: pale walls, brown floors, colourful
 * things. */

#include "guide/train/scenes/palette.h"

#include "guide/train/scenes/dress.h"

struct vec3 color_hsv(float hue, float saturation, float value) {
    float channel[3];
    for (int i = 0; i < 3; i++) {
        float k = fmodf((float)(5 - 2 * i) + hue * 6, 6);
        channel[i] = value * (1 - saturation * fmaxf(0, fminf(1, fminf(k, 4 - k))));
    }
    return vec(channel[0], channel[1], channel[2]);
}

struct vec3 color_any(struct random *r) {
    float hue = uniform(r, 0, 1), value = log_uniform(r, 0.06f, 0.9f);
    float saturation = chance(r, 0.3f) ? uniform(r, 0, 0.15f) : uniform(r, 0.1f, 0.95f);
    return color_hsv(hue, saturation, value);
}

static struct vec3 wood(struct random *r) {
    float hue = uniform(r, 0.04f, 0.12f), saturation = uniform(r, 0.35f, 0.8f);
    return color_hsv(hue, saturation, log_uniform(r, 0.07f, 0.7f));
}

struct vec3 color_light(struct random *r) {
    struct vec3 tint;
    if (chance(r, 0.1f)) {
        tint = color_hsv(uniform(r, 0, 1), uniform(r, 0.2f, 0.8f), 1);
    } else {
        float warm = uniform(r, -0.4f, 1);
        tint = warm > 0 ? vec(1, 1 - 0.35f * warm, 1 - 0.7f * warm)
                        : vec(1 + 0.5f * warm, 1 + 0.25f * warm, 1);
    }
    return scale(tint, 1 / luminance(tint));
}

static int plain_any(struct stage *stage) {
    struct random *r = &stage->random;
    struct vec3 color = color_any(r);
    if (chance(r, 0.75f))
        return stage_material(stage, color);
    struct vec3 other = color_any(r);
    float u = log_uniform(r, 0.5f, 20);
    float v = chance(r, 0.5f) ? u : log_uniform(r, 0.5f, 20);
    return stage_checkerboard(stage, color, other, u, v);
}

static int plain_wall(struct stage *stage) {
    struct random *r = &stage->random;
    if (chance(r, 0.15f))
        return plain_any(stage);
    float hue = uniform(r, 0, 1),
          saturation = chance(r, 0.6f) ? uniform(r, 0, 0.12f) : uniform(r, 0.1f, 0.5f);
    struct vec3 color = color_hsv(hue, saturation, uniform(r, 0.4f, 0.9f));
    if (!chance(r, 0.15f))
        return stage_material(stage, color);
    float stripes = log_uniform(r, 2, 30);
    float rows = chance(r, 0.5f) ? stripes : 0.5f;
    return stage_checkerboard(stage, color, scale(color, uniform(r, 0.3f, 0.9f)), stripes, rows);
}

static int plain_floor(struct stage *stage) {
    struct random *r = &stage->random;
    struct vec3 color =
        chance(r, 0.5f) ? wood(r)
                        : color_hsv(uniform(r, 0, 1), uniform(r, 0, 0.3f), uniform(r, 0.1f, 0.8f));
    if (chance(r, 0.45f))
        return stage_material(stage, color);
    struct vec3 other = chance(r, 0.7f) ? scale(color, uniform(r, 0.2f, 0.9f)) : color_any(r);
    float u = log_uniform(r, 1.5f, 40);
    float v = chance(r, 0.6f) ? u : log_uniform(r, 1, 40);
    return stage_checkerboard(stage, color, other, u, v);
}

static int plain_wood(struct stage *stage) {
    struct random *r = &stage->random;
    struct vec3 color = wood(r);
    if (chance(r, 0.75f))
        return stage_material(stage, color);
    float u = log_uniform(r, 1, 12), v = log_uniform(r, 0.5f, 4);
    return stage_checkerboard(stage, color, scale(color, uniform(r, 0.5f, 0.9f)), u, v);
}

int surface_wall(struct stage *stage) {
    return dress(stage, plain_wall(stage), ROLE_WALL);
}

int surface_floor(struct stage *stage) {
    return dress(stage, plain_floor(stage), ROLE_FLOOR);
}

int surface_wood(struct stage *stage) {
    return dress(stage, plain_wood(stage), ROLE_WOOD);
}

int surface_any(struct stage *stage) {
    return dress(stage, plain_any(stage), ROLE_ANY);
}
