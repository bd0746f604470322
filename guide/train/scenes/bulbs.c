/* SPDX-License-Identifier: Apache-2.0 */
/* The hard lights of mixed scenes: rooms full of small ones, bare bulbs, tubes, spots, points. */

#include "guide/train/scenes/dress.h"
#include "guide/train/scenes/lights.h"
#include "guide/train/scenes/palette.h"

static int black(struct stage *stage) {
    return stage_material(stage, vec(0, 0, 0));
}

/* 20 to 100 lights: a grid on the ceiling, chains along the walls, or a cloud. */
void light_swarm(struct stage *stage, struct xform place, struct room_size size, float share) {
    struct random *r = &stage->random;
    int n = (int)log_uniform(r, 20, 100), layout = between(r, 0, 2), dark = black(stage),
        columns = (int)ceilf(sqrtf((float)n));
    float radius = log_uniform(r, 0.006f, 0.04f), hang = uniform(r, 0.05f, 0.5f) * size.height;
    struct vec3 tints[3] = {color_light(r), color_light(r), color_light(r)};
    bool coloured = chance(r, 0.35f);
    for (int i = 0; i < n; i++) {
        float u = uniform(r, -0.47f, 0.47f), v = uniform(r, -0.47f, 0.47f),
              y = size.height - uniform(r, 0.05f, 1) * hang;
        if (layout == 0) {
            u = ((float)(i % columns) + 0.5f) / (float)columns - 0.5f;
            v = ((float)(i / columns) + 0.5f) / (float)columns - 0.5f;
            y = size.height - hang * 0.3f;
        } else if (layout == 1) {
            float t = 4 * (float)i / (float)n, along = t - floorf(t) - 0.5f;
            float side = (int)t % 2 ? 0.47f : -0.47f;
            u = t < 2 ? along * 0.94f : side, v = t < 2 ? side : along * 0.94f;
            y = size.height - hang * (0.4f + 0.3f * cosf(along * 25));
        }
        int light = stage_ball(stage, place, vec(u * size.width, y, v * size.depth), radius, dark);
        stage_light(stage, light, tints[coloured ? i % 3 : 0],
                    share / (float)n * log_uniform(r, 0.5f, 2));
    }
}

/* Tiny bright bulbs with a socket and a cord, some within a glass globe. */
void light_bare(struct stage *stage, struct xform place, struct room_size size, float share) {
    struct random *r = &stage->random;
    int n = between(r, 1, 5), dark = black(stage), metal = surface_metal(stage);
    for (int i = 0; i < n; i++) {
        float x = uniform(r, -0.42f, 0.42f) * size.width,
              z = uniform(r, -0.42f, 0.42f) * size.depth,
              y = size.height * uniform(r, 0.55f, 0.92f), radius = log_uniform(r, 0.004f, 0.025f);
        struct vec3 bulb = vec(x, y, z), socket = vec(x, y + radius * 1.1f, z),
                    cord = vec(x, y + radius * 1.1f + 0.05f, z);
        int light = stage_ball(stage, place, bulb, radius, dark);
        stage_light(stage, light, color_light(r), share / (float)n);
        stage_cylinder(stage, place, socket, cord, 0.012f, metal);
        stage_cylinder(stage, place, cord, vec(x, size.height, z), 0.003f, dark);
        if (chance(r, 0.12f))
            stage_ball(stage, place, bulb, radius * uniform(r, 2.5f, 5), surface_glass(stage));
        stage_look_here(stage, place, bulb);
    }
}

/* Fluorescent tubes under the ceiling. */
void light_tubes(struct stage *stage, struct xform place, struct room_size size, float share) {
    struct random *r = &stage->random;
    int n = between(r, 1, 6), dark = black(stage), metal = surface_metal(stage);
    float half = fminf(size.width, size.depth) * uniform(r, 0.1f, 0.4f),
          radius = fmaxf(half / 40, uniform(r, 0.008f, 0.025f)),
          y = size.height - uniform(r, 0.06f, 0.5f);
    struct vec3 tint = color_light(r);
    for (int i = 0; i < n; i++) {
        float z = size.depth * (((float)i + 0.5f) / (float)n - 0.5f);
        int light = stage_cylinder(stage, place, vec(-half, y, z), vec(half, y, z), radius, dark);
        stage_light(stage, light, tint, share / (float)n);
        stage_box(stage, place, vec(0, y + 2.5f * radius, z), vec(half, radius, 2 * radius), metal);
    }
}

/* Spots from the ceiling or points in the room: lights that no path can hit. */
void light_points(struct stage *stage, struct xform place, struct room_size size, float share) {
    struct random *r = &stage->random;
    int n = between(r, 1, STAGE_LAMPS);
    bool spots = chance(r, 0.65f);
    for (int i = 0; i < n && stage->lamp_count < STAGE_LAMPS; i++) {
        struct lamp lamp = {.spot = spots};
        float y = size.height - (spots ? 0.05f : uniform(r, 0.2f, 0.6f) * size.height);
        struct vec3 at = vec(uniform(r, -0.4f, 0.4f) * size.width, y, 0);
        at.z = uniform(r, -0.4f, 0.4f) * size.depth;
        struct vec3 down = vec(uniform(r, -0.7f, 0.7f), -1, 0);
        down.z = uniform(r, -0.7f, 0.7f);
        lamp.cutoff = uniform(r, 15, 60);
        lamp.beam = lamp.cutoff * uniform(r, 0.4f, 0.95f);
        float solid_angle = spots ? 2 * PI_F * (1 - cosf(lamp.cutoff * PI_F / 180)) : 4 * PI_F;
        lamp.position = xform_point(&place, at);
        lamp.direction = normalize(xform_vector(&place, down));
        lamp.intensity = scale(color_light(r), share * stage->surface / solid_angle / (float)n);
        stage->lamps[stage->lamp_count++] = lamp;
    }
}
