/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes where a guide has little to win: objects under an open sky, and closed rooms lit evenly.
 */

#include "guide/train/scenes/builders.h"
#include "guide/train/scenes/furniture.h"
#include "guide/train/scenes/palette.h"

static struct xform random_root(struct random *r, float low, float high, float metres) {
    float scaling = log_uniform(r, low, high) / metres;
    struct xform root =
        moved(xform_translate(uniform(r, -3, 3), uniform(r, -1, 1), uniform(r, -3, 3)), 0, 0, 0,
              uniform(r, 0, 2 * PI_F));
    return xform_multiply(root, xform_scale(scaling, scaling, scaling));
}

static void scatter(struct stage *stage, float radius, int n) {
    struct random *r = &stage->random;
    for (int i = 0; i < n; i++) {
        float away = radius * sqrtf(uniform(r, 0, 1)), azimuth = uniform(r, 0, 2 * PI_F);
        build_something(stage, moved(stage->root, away * cosf(azimuth), 0, away * sinf(azimuth),
                                     uniform(r, 0, 2 * PI_F)));
    }
}

void build_outdoor(struct stage *stage) {
    struct random *r = &stage->random;
    float radius = uniform(r, 1.5f, 5);
    stage->root = random_root(r, 1.5f, 20, 2 * radius);
    build_sky(stage, 1);
    build_surroundings(stage, radius, 0);
    scatter(stage, radius, between(r, 3, 10));
    build_clutter(stage, stage->root, radius, radius, uniform(r, 0.05f, 0.25f), between(r, 4, 40));
    if (chance(r, 0.4f)) { /* a free-standing wall for shadow and colour bleeding */
        struct xform at = moved(stage->root, uniform(r, -1, 1) * radius, 0,
                                uniform(r, -1, 1) * radius, uniform(r, 0, 2 * PI_F));
        float height = uniform(r, 0.8f, 3);
        stage_box(stage, at, vec(0, height / 2, 0),
                  vec(radius * uniform(r, 0.2f, 0.7f), height / 2, 0.08f), surface_wall(stage));
    }
    stage->camera_low = vec(-1.6f * radius, 0.3f, -1.6f * radius);
    stage->camera_high = vec(1.6f * radius, uniform(r, 1, 2.5f), 1.6f * radius);
    stage_look_here(stage, stage->root, vec(0, 0.4f, 0));
}

/* Lights that cover much of the ceiling or of the walls. */
static void large_lights(struct stage *stage, float w, float d, float h) {
    struct random *r = &stage->random;
    int dark = stage_material(stage, vec(0.2f, 0.2f, 0.2f));
    struct vec3 tint = color_light(r);
    if (chance(r, 0.6f)) {
        int light =
            stage_panel(stage, SHAPE_RECTANGLE, stage->root, vec(0, h - 0.01f, 0), vec(0, -1, 0),
                        w * uniform(r, 0.3f, 0.48f), d * uniform(r, 0.3f, 0.48f), dark);
        stage_light(stage, light, tint, 1);
    } else {
        for (int side = 0; side < 4; side++) {
            float away = (side % 2 ? w : d) / 2, along = (side % 2 ? d : w) / 2;
            struct xform at = moved(stage->root, 0, 0, 0, -0.5f * PI_F * (float)side);
            int light = stage_panel(stage, SHAPE_RECTANGLE, at, vec(0, h * 0.5f, -away + 0.01f),
                                    vec(0, 0, 1), along * 0.9f, h * uniform(r, 0.1f, 0.4f), dark);
            stage_light(stage, light, tint, 0.25f);
        }
    }
}

void build_even_room(struct stage *stage) {
    struct random *r = &stage->random;
    float w = uniform(r, 2, 8), d = uniform(r, 2, 8), h = uniform(r, 2.2f, 4), t = 0.1f;
    stage->root = random_root(r, 1.5f, 20, fmaxf(w, d));
    float scaling = length(xform_vector(&stage->root, vec(1, 0, 0)));
    stage->surface = 2 * (w * d + w * h + d * h) * scaling * scaling;
    int paint = surface_wall(stage), open = chance(r, 0.3f);
    for (int side = 0; side < 4; side++) {
        float away = (side % 2 ? w : d) / 2, along = (side % 2 ? d : w) / 2;
        struct xform at = moved(stage->root, 0, 0, 0, -0.5f * PI_F * (float)side);
        stage_box(stage, at, vec(0, h / 2, -away - t), vec(along + t, h / 2, t),
                  chance(r, 0.3f) ? surface_wall(stage) : paint);
    }
    stage_box(stage, stage->root, vec(0, -t, 0), vec(w / 2 + t, t, d / 2 + t),
              surface_floor(stage));
    if (open) { /* no ceiling: light from above */
        stage->sky = (struct sky){
            .kind = SKY_CONSTANT, .strength = 1, .horizon = color_light(r), .sun_cos = 2};
    } else {
        stage_box(stage, stage->root, vec(0, h + t, 0), vec(w / 2 + t, t, d / 2 + t),
                  surface_wall(stage));
        large_lights(stage, w, d, h);
    }
    scatter(stage, fminf(w, d) * 0.42f, between(r, 2, 8));
    build_clutter(stage, stage->root, w * 0.4f, d * 0.4f, uniform(r, 0.05f, 0.2f),
                  between(r, 2, 30));
    stage->camera_low = vec(-w / 2 + 0.2f, 0.3f, -d / 2 + 0.2f);
    stage->camera_high = vec(w / 2 - 0.2f, h - 0.3f, d / 2 - 0.2f);
}
