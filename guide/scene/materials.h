/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_MATERIALS_H
#define FEWRAY_GUIDE_SCENE_MATERIALS_H

/* Named materials of Mitsuba 3. */

#include <stdbool.h>

#include "guide/vec.h"

/* The complex index of refraction eta + i k of a metal, in linear RGB; false: no such name. Case
 * matters: they are chemical symbols. */
bool metal_find(const char *name, struct vec3 *eta, struct vec3 *k);

/* The index of refraction of a dielectric ("bk7", "water"), in any case; false: no such name. */
bool dielectric_find(const char *name, double *ior);

#endif
