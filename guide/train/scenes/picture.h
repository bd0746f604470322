/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_PICTURE_H
#define FEWRAY_TRAIN_PICTURE_H

/* Textures as tileable pictures: a few numbers while a scene is built, a PNG when it is written. */

#include "fewray/features.h"
#include "guide/train/scenes/random.h"
#include "guide/vec.h"

#define PICTURE_SIZE   256 /* pixels along either side */
#define PICTURE_COLORS 4

enum picture_kind {
    PICTURE_CLOUDS, /* fractal noise: plaster, stone, stains */
    PICTURE_GRAIN,  /* noise of the pixels' own size: carpet, sand */
    PICTURE_WOOD,   /* planks with rings */
    PICTURE_BRICKS, /* bonds with joints, each brick of its own shade */
    PICTURE_TILES,  /* a grid with joints */
    PICTURE_STRIPES,
    PICTURE_PLAID, /* stripes both ways: cloth */
    PICTURE_DOTS,
    PICTURE_MARBLE,
    PICTURE_TEXT, /* lines of small strokes */
    PICTURE_KINDS
};

struct picture {
    enum picture_kind kind;
    uint32_t seed;
    struct vec3 colors[PICTURE_COLORS]; /* linear reflectances */
    int cells_u, cells_v;               /* of noise, bricks, stripes ... over the picture */
    float sharpness;                    /* 0..1: of the noise's contrast, or the joints' width */
};

/* A picture of this kind out of two colours and mixtures of them. */
struct picture picture_random(struct random *r, enum picture_kind kind, struct vec3 color,
                              struct vec3 other);
int picture_write(const struct picture *picture, const char *path, struct fewray_error *error);

#endif
