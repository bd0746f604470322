/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_WRITE_MATERIAL_H
#define FEWRAY_TRAIN_WRITE_MATERIAL_H

#include <stdio.h>

#include "guide/train/scenes/material.h"

void write_rgb(FILE *file, const char *name, struct vec3 c);
/* A <bsdf> with the id m<index>; its picture k is textures/<prefix>-<k>.png. */
void write_material(FILE *file, const struct material *material, int index, const char *prefix);

#endif
