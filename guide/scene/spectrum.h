/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_SPECTRUM_H
#define FEWRAY_GUIDE_SCENE_SPECTRUM_H

/* Spectra over the wavelength, and the linear RGB that Mitsuba's RGB variants make of them. */

#include <stdbool.h>
#include <stddef.h>

#include "fewray/features.h"
#include "guide/vec.h"

/* Straight lines between the points, 0 outside. */
struct spectrum {
    double *wavelengths; /* nm, increasing */
    double *values;
    size_t count, wavelength_capacity, value_capacity;
};

void spectrum_free(struct spectrum *spectrum);
/* False without memory. */
bool spectrum_add(struct spectrum *spectrum, double wavelength, double value);
/* Why it can't be used, or NULL: at least two finite points, in increasing order. */
const char *spectrum_fault(const struct spectrum *spectrum);

/* Reads "400:0.1, 500:0.5 600:0.9". Of a failure *fault says why; NULL: out of memory. */
bool spectrum_read_list(const char *text, struct spectrum *out, const char **fault);
/* Reads a .spd file: lines of a wavelength and a value, or empty, or after a '#'. The caller frees
 * *out in any case. */
int spectrum_read_file(const char *path, struct spectrum *out, struct fewray_error *error);
/* A black body's radiance, W/(m2 sr nm), by Planck's law. False without memory. */
bool spectrum_blackbody(double kelvin, struct spectrum *out);

/* Linear RGB with sRGB's primaries, negative components cut. Under D65 (of what reflects it) a flat
 * spectrum of 1 is white (1, 1, 1); else (of what emits it) it is equal-energy white of
 * luminance 1. */
struct vec3 spectrum_to_rgb(const struct spectrum *spectrum, bool under_d65);

#endif
