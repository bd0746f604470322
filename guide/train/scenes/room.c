/* SPDX-License-Identifier: Apache-2.0 */
/* Furnished rooms: proportions, openings, furniture and how they are lit. */

#include "guide/train/scenes/builders.h"
#include "guide/train/scenes/furniture.h"
#include "guide/train/scenes/lights.h"
#include "guide/train/scenes/palette.h"
#include "guide/train/scenes/walls.h"

enum fill { FILL_NOTHING, FILL_WINDOW, FILL_DOOR, FILL_ARCH };

struct room {
    struct room_size size;
    float thickness;
    struct wall walls[4], ceiling;
    enum fill fills[4];
    float window_area;
    int places;            /* taken floor places */
    struct vec3 taken[40]; /* x, radius, z */
};

static void choose_size(struct stage *stage, struct room *room) {
    struct random *r = &stage->random;
    if (chance(r, 0.12f)) { /* a corridor */
        room->size.width = uniform(r, 1.3f, 2.4f);
        room->size.depth = uniform(r, 5, 14);
    } else {
        room->size.width = log_uniform(r, 2.4f, 9);
        room->size.depth = room->size.width * log_uniform(r, 0.6f, 1.8f);
    }
    room->size.height = uniform(r, 2.3f, 3.3f);
    if (chance(r, 0.2f))
        room->size.height = uniform(r, 3, 6);
    room->thickness = uniform(r, 0.08f, 0.4f);
    float longest = fmaxf(room->size.width, room->size.depth),
          scaling = log_uniform(r, 1.5f, 20) / longest;
    float yaw = chance(r, 0.6f) ? uniform(r, 0, 2 * PI_F) : 0.5f * PI_F * (float)between(r, 0, 3);
    struct xform root = moved(
        xform_translate(uniform(r, -3, 3), uniform(r, -1, 1), uniform(r, -3, 3)), 0, 0, 0, yaw);
    stage->root = xform_multiply(root, xform_scale(scaling, scaling, scaling));
    float w = room->size.width, d = room->size.depth, h = room->size.height;
    stage->surface = 2 * (w * d + w * h + d * h) * scaling * scaling;
    stage->camera_low = vec(-w / 2 + 0.15f, 0.25f, -d / 2 + 0.15f);
    stage->camera_high = vec(w / 2 - 0.15f, fminf(h - 0.25f, 2.4f), d / 2 - 0.15f);
}

static void place_walls(struct stage *stage, struct room *room) {
    struct random *r = &stage->random;
    float w = room->size.width, d = room->size.depth, h = room->size.height;
    int paint = surface_wall(stage);
    for (int i = 0; i < 4; i++) {
        struct wall *wall = &room->walls[i];
        *wall = (struct wall){
            .length = i % 2 ? d : w, .height = h, .thickness = room->thickness, .material = paint};
        if (chance(r, 0.2f))
            wall->material = surface_wall(stage);
        struct xform turned = moved(stage->root, 0, 0, 0, -0.5f * PI_F * (float)i);
        wall->place =
            xform_multiply(turned, xform_translate(-wall->length / 2, 0, -(i % 2 ? w : d) / 2));
    }
    /* The ceiling is a wall whose z points down and whose y runs along the room's depth. */
    struct xform at = xform_multiply(stage->root, xform_translate(-w / 2, h, -d / 2));
    room->ceiling = (struct wall){.length = w, .height = d, .thickness = room->thickness};
    room->ceiling.place = xform_multiply(at, xform_rotate(vec(1, 0, 0), PI_F / 2));
    room->ceiling.material =
        chance(r, 0.7f) ? stage_material(stage, scale(vec(1, 1, 1), uniform(r, 0.5f, 0.9f)))
                        : surface_wall(stage);
}

static void add_window_row(struct random *r, struct room *room, int side) {
    struct wall *wall = &room->walls[side];
    int n = wall->length < 2 ? 1 : between(r, 1, wall->length > 4 ? WALL_OPENINGS : 2);
    float cell = wall->length / (float)n, width = cell * uniform(r, 0.12f, 0.9f), h = wall->height;
    float low = chance(r, 0.25f) ? 0.02f : uniform(r, 0.3f, 1.2f),
          high = uniform(r, low + 0.3f, h - 0.1f);
    if (chance(r, 0.12f)) { /* a strip under the ceiling */
        low = h - uniform(r, 0.3f, 0.6f);
        high = h - 0.1f;
    }
    for (int i = 0; i < n; i++) {
        float x = cell * ((float)i + 0.5f);
        wall->openings[i] = (struct opening){x - width / 2, x + width / 2, low, high};
    }
    wall->opening_count = n;
    room->fills[side] = FILL_WINDOW;
    room->window_area += (float)n * width * (high - low);
}

static void add_doorway(struct random *r, struct room *room, int side, bool arch) {
    struct wall *wall = &room->walls[side];
    float width = arch ? uniform(r, 0.6f, fminf(2.5f, wall->length * 0.7f)) : uniform(r, 0.7f, 1);
    if (width + 0.2f > wall->length)
        return;
    float x = uniform(r, 0.1f, wall->length - width - 0.1f),
          top = fminf(wall->height - 0.1f, uniform(r, 1.9f, 2.3f));
    wall->openings[0] = (struct opening){x, x + width, 0, top};
    wall->opening_count = 1;
    room->fills[side] = arch ? FILL_ARCH : FILL_DOOR;
}

static void add_skylight(struct random *r, struct room *room) {
    struct wall *wall = &room->ceiling;
    float half_x = wall->length * uniform(r, 0.04f, 0.4f),
          half_y = wall->height * uniform(r, 0.04f, 0.4f);
    float x = uniform(r, half_x + 0.05f, wall->length - half_x - 0.05f);
    float y = uniform(r, half_y + 0.05f, wall->height - half_y - 0.05f);
    wall->openings[0] = (struct opening){x - half_x, x + half_x, y - half_y, y + half_y};
    wall->opening_count = 1;
    room->window_area += 4 * half_x * half_y;
}

static bool claim(struct room *room, float x, float z, float radius) {
    for (int i = 0; i < room->places; i++) {
        float dx = x - room->taken[i].x, dz = z - room->taken[i].z,
              apart = radius + room->taken[i].y;
        if (dx * dx + dz * dz < apart * apart)
            return false;
    }
    if (room->places >= (int)(sizeof room->taken / sizeof *room->taken))
        return false;
    room->taken[room->places++] = vec(x, radius, z);
    return true;
}

static void furnish(struct stage *stage, struct room *room) {
    struct random *r = &stage->random;
    float w = room->size.width, d = room->size.depth;
    int wanted = (int)(w * d * uniform(r, 0.1f, 0.5f)) + 2, limit = 13;
    for (int tries = 0; tries < 60 && wanted > 0 && limit > 0; tries++) {
        bool at_wall = chance(r, 0.55f);
        int side = between(r, 0, 3);
        float along = (side % 2 ? d : w) / 2 - 0.6f,
              away = (side % 2 ? w : d) / 2 - uniform(r, 0.3f, 0.6f);
        float yaw = -0.5f * PI_F * (float)side + uniform(r, -0.1f, 0.1f), x, z;
        if (at_wall) {
            float u = uniform(r, -1, 1) * fmaxf(0, along);
            float c = cosf(-0.5f * PI_F * (float)side), s = sinf(-0.5f * PI_F * (float)side);
            x = c * u - s * away, z = -s * u - c * away;
        } else {
            x = uniform(r, -1, 1) * fmaxf(0, w / 2 - 0.7f),
            z = uniform(r, -1, 1) * fmaxf(0, d / 2 - 0.7f);
            yaw = uniform(r, 0, 2 * PI_F);
        }
        if (!claim(room, x, z, uniform(r, 0.35f, 0.6f)))
            continue;
        build_something(stage, moved(stage->root, x, 0, z, yaw));
        wanted--, limit--;
    }
    if (chance(r, 0.5f))
        build_rug(stage, moved(stage->root, uniform(r, -0.2f, 0.2f) * w, 0,
                               uniform(r, -0.2f, 0.2f) * d, uniform(r, -0.3f, 0.3f)));
    if (chance(r, 0.6f))
        build_clutter(stage, stage->root, w * 0.4f, d * 0.4f, uniform(r, 0.04f, 0.16f),
                      between(r, 2, 24));
}

static void decorate(struct stage *stage, struct room *room) {
    struct random *r = &stage->random;
    bool skirting = chance(r, 0.4f);
    int board = skirting ? surface_wall(stage) : 0;
    for (int i = 0; i < 4; i++) {
        struct wall *wall = &room->walls[i];
        if (skirting && room->fills[i] == FILL_NOTHING)
            stage_box(stage, wall->place, vec(wall->length / 2, 0.05f, 0.008f),
                      vec(wall->length / 2, 0.05f, 0.008f), board);
        if (wall->opening_count > 0 || wall->length < 1.6f)
            continue;
        for (int n = between(r, 0, 3); n > 0; n--) {
            float x = uniform(r, 0.7f, wall->length - 0.7f), y = uniform(r, 1.1f, 1.8f);
            build_picture(stage,
                          xform_multiply(wall->place, xform_translate(x, y, 0.002f * (float)n)));
        }
    }
    float w = room->size.width, d = room->size.depth, h = room->size.height;
    if (chance(r, 0.15f)) { /* beams */
        int n = between(r, 2, 7), wood = surface_wood(stage);
        for (int i = 0; i < n; i++)
            stage_box(stage, stage->root,
                      vec(0, h - 0.08f, d * (((float)i + 0.5f) / (float)n - 0.5f)),
                      vec(w / 2, 0.08f, 0.05f), wood);
    }
    if (chance(r, 0.12f) && w > 3.5f) { /* columns */
        int paint = surface_wall(stage);
        for (int i = 0; i < 4; i++) {
            float x = (i & 1 ? 0.28f : -0.28f) * w, z = (i & 2 ? 0.28f : -0.28f) * d;
            stage_box(stage, stage->root, vec(x, h / 2, z), vec(0.12f, h / 2, 0.12f), paint);
        }
    }
}

typedef void light_builder(struct stage *, struct xform, struct room_size, float);

static void add_lamps(struct stage *stage, const struct room *room, float share) {
    static light_builder *const builders[] = {light_ceiling, light_cove, light_hidden, light_hidden,
                                              light_many,    light_glow, light_lamp,   light_lamp};
    struct random *r = &stage->random;
    static light_builder *const hard[] = {light_swarm, light_swarm, light_bare,
                                          light_bare,  light_tubes, light_points};
    light_builder *build = builders[between(r, 0, 7)];
    if (stage->mixed && chance(r, 0.45f))
        build = hard[between(r, 0, 5)];
    int n = build == light_lamp ? between(r, 1, 3) : 1;
    for (int i = 0; i < n; i++)
        build(stage, stage->root, room->size, share / (float)n);
}

static void build_shell(struct stage *stage, struct room *room, float door_share) {
    float w = room->size.width, d = room->size.depth, t = room->thickness;
    for (int i = 0; i < 4; i++)
        build_wall(stage, &room->walls[i]);
    build_wall(stage, &room->ceiling);
    stage_box(stage, stage->root, vec(0, -t / 2, 0), vec(w / 2 + t, t / 2, d / 2 + t),
              surface_floor(stage));
    for (int i = 0; i < 4; i++) {
        const struct wall *wall = &room->walls[i];
        for (int o = 0; o < wall->opening_count; o++) {
            if (room->fills[i] == FILL_WINDOW) {
                build_window(stage, wall, &wall->openings[o]);
                continue;
            }
            if (room->fills[i] == FILL_DOOR)
                build_door(stage, wall, &wall->openings[o]);
            build_neighbour(stage, wall, &wall->openings[o], door_share);
        }
    }
    for (int o = 0; o < room->ceiling.opening_count; o++)
        build_window(stage, &room->ceiling, &room->ceiling.openings[o]);
}

void build_room(struct stage *stage) {
    struct random *r = &stage->random;
    struct room room = {0};
    choose_size(stage, &room);
    place_walls(stage, &room);
    float plan = stage->plan / ROOMS;
    bool doors = plan < 0.3f, windows = plan >= 0.3f && plan < 0.66f,
         skylight = plan >= 0.66f && plan < 0.74f;
    bool lamps = plan >= 0.74f || chance(r, doors ? 0.1f : 0.25f);
    int side = between(r, 0, 3);
    for (int n = windows ? between(r, 1, 3) : 0, i = 0; i < n; i++)
        add_window_row(r, &room, (side + i) % 4);
    if (skylight)
        add_skylight(r, &room);
    if (doors || chance(r, 0.1f))
        add_doorway(r, &room, (side + 3) % 4, chance(r, 0.25f));
    stage->panes = stage->mixed && !lamps && chance(r, 0.2f);
    build_shell(stage, &room, log_uniform(r, 2, 60));
    decorate(stage, &room);
    furnish(stage, &room);
    if (room.window_area > 0) {
        float inner = 2 * (room.size.width * room.size.depth + room.size.width * room.size.height +
                           room.size.depth * room.size.height);
        build_sky(stage, fminf(40, inner / (PI_F * room.window_area)));
        if (chance(r, 0.6f))
            build_surroundings(stage, fmaxf(room.size.width, room.size.depth),
                               -room.thickness - (chance(r, 0.5f) ? 0.05f : uniform(r, 1, 5)));
    }
    if (lamps)
        add_lamps(stage, &room, log_uniform(r, 0.1f, 2));
}
