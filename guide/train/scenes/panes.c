/* SPDX-License-Identifier: Apache-2.0 */
/* Glass and fine grids in the windows of mixed scenes. */

#include "guide/train/scenes/dress.h"
#include "guide/train/scenes/palette.h"
#include "guide/train/scenes/walls.h"

/* A single thin sheet across the opening. */
static void sheet(struct stage *stage, const struct wall *wall, const struct opening *o) {
    float half_x = (o->x1 - o->x0) / 2, half_y = (o->y1 - o->y0) / 2;
    struct vec3 middle = vec((o->x0 + o->x1) / 2, (o->y0 + o->y1) / 2, -wall->thickness * 0.5f);
    stage_panel(stage, SHAPE_RECTANGLE, wall->place, middle, vec(0, 0, 1), half_x, half_y,
                surface_pane(stage));
}

/* A square bar between two points of a wall's plane. */
static void bar(struct stage *stage, const struct wall *wall, struct vec3 from, struct vec3 to,
                float thin, int material) {
    struct vec3 axis = sub(to, from), middle = scale(add(from, to), 0.5f);
    struct xform at = xform_multiply(wall->place, xform_translate(middle.x, middle.y, middle.z));
    at = xform_multiply(at, xform_rotate(vec(0, 0, 1), atan2f(axis.y, axis.x)));
    stage_box(stage, at, vec(0, 0, 0), vec(length(axis) / 2, thin, thin), material);
}

/* Thin bars both ways, the upright ones round or, at a slant, square: Mitsuba takes the rounding
 * of some slanted cylinders for a shear. */
static void lattice(struct stage *stage, const struct wall *wall, const struct opening *o) {
    struct random *r = &stage->random;
    float z = -wall->thickness * 0.85f, width = o->x1 - o->x0, height = o->y1 - o->y0,
          pitch = fmaxf(uniform(r, 0.06f, 0.2f), fmaxf(width, height) / 24),
          thin = log_uniform(r, 0.002f, 0.009f), lean = chance(r, 0.4f) ? height * 0.5f : 0;
    int metal = chance(r, 0.5f) ? surface_metal(stage) : surface_any(stage);
    for (float x = o->x0 + pitch / 2; x < o->x1; x += pitch) {
        float top = fminf(o->x1, x + lean), share = lean > 0 ? (top - x) / lean : 1;
        struct vec3 from = vec(x, o->y0, z), to = vec(top, o->y0 + share * height, z);
        if (lean > 0 || wall->place.m[5] < 0.99f * length(xform_vector(&wall->place, vec(0, 1, 0))))
            bar(stage, wall, from, to, thin, metal);
        else
            stage_cylinder(stage, wall->place, from, to, thin, metal);
    }
    for (float y = o->y0 + pitch / 2; y < o->y1; y += pitch)
        bar(stage, wall, vec(o->x0, y, z), vec(o->x1, y, z), thin, metal);
}

void build_glazing(struct stage *stage, const struct wall *wall, const struct opening *o) {
    struct random *r = &stage->random;
    if (stage->panes && chance(r, 0.8f))
        sheet(stage, wall, o);
    if (chance(r, 0.18f))
        lattice(stage, wall, o);
}
