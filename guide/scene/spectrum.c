/* SPDX-License-Identifier: Apache-2.0 */
/* Spectra from text, files and Planck's law, and their colour. */

#include "guide/scene/spectrum.h"

#include <math.h>
#include <stdlib.h>

#include "guide/scene/cie.h"
#include "guide/scene/file_bytes.h"
#include "guide/scene/memory.h"
#include "guide/scene/number.h"

/* As many as Mitsuba takes, whose sum this one equals. */
#define STEPS 1000

void spectrum_free(struct spectrum *spectrum) {
    free(spectrum->wavelengths);
    free(spectrum->values);
    *spectrum = (struct spectrum){0};
}

bool spectrum_add(struct spectrum *spectrum, double wavelength, double value) {
    if (!array_reserve((void **)&spectrum->wavelengths, &spectrum->wavelength_capacity,
                       spectrum->count + 1, sizeof(double)) ||
        !array_reserve((void **)&spectrum->values, &spectrum->value_capacity, spectrum->count + 1,
                       sizeof(double)))
        return false;
    spectrum->wavelengths[spectrum->count] = wavelength;
    spectrum->values[spectrum->count++] = value;
    return true;
}

const char *spectrum_fault(const struct spectrum *spectrum) {
    if (spectrum->count < 2)
        return "a spectrum needs at least two wavelengths";
    for (size_t i = 0; i < spectrum->count; i++) {
        if (!(fabs(spectrum->wavelengths[i]) <= 1e30) || !(fabs(spectrum->values[i]) <= 1e30))
            return "a spectrum needs finite numbers";
        if (i && !(spectrum->wavelengths[i] > spectrum->wavelengths[i - 1]))
            return "a spectrum's wavelengths must increase";
    }
    return NULL;
}

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

bool spectrum_read_list(const char *text, struct spectrum *out, const char **fault) {
    *fault = "a spectrum should look like 400:0.1, 500:0.2";
    for (;;) {
        double wavelength, value;
        while (is_blank(*text) || *text == ',')
            text++;
        if (!*text)
            break;
        if (!number_read(&text, &wavelength) || *text++ != ':' || !number_read(&text, &value) ||
            (*text && !is_blank(*text) && *text != ','))
            return false;
        if (!spectrum_add(out, wavelength, value)) {
            *fault = NULL;
            return false;
        }
    }
    *fault = spectrum_fault(out);
    return !*fault;
}

/* Reads one line and moves *text behind it. False where it is neither a point nor nothing. */
static bool read_line(const char **text, struct spectrum *out, bool *no_memory) {
    double wavelength, value;
    const char *c = *text;
    while (*c == ' ' || *c == '\t')
        c++;
    bool point = *c && *c != '#' && *c != '\n' && *c != '\r';
    if (point) {
        if (!number_read(&c, &wavelength) || !(*c == ' ' || *c == '\t'))
            return false;
        while (*c == ' ' || *c == '\t')
            c++;
        if (!number_read(&c, &value) || !(is_blank(*c) || !*c || *c == '#'))
            return false;
        *no_memory = !spectrum_add(out, wavelength, value);
    }
    while (*c && *c != '\n')
        if (point && *c == '#')
            point = false;
        else if (point && !is_blank(*c))
            return false;
        else
            c++;
    *text = *c ? c + 1 : c;
    return !*no_memory;
}

int spectrum_read_file(const char *path, struct spectrum *out, struct fewray_error *error) {
    struct file_bytes file;
    bool no_memory = false;
    int line = 1, status = file_read(path, &file, error);
    if (status)
        return status;
    for (const char *text = file.data; *text && !status; line++)
        if (!read_line(&text, out, &no_memory))
            status = no_memory ? fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory")
                               : fewray_fail(error, FEWRAY_ERROR_FORMAT, path, line,
                                             "a spectrum's line needs a wavelength and a value");
    const char *fault = status ? NULL : spectrum_fault(out);
    if (fault)
        status = fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0, "%s", fault);
    file_free(&file);
    return status;
}

bool spectrum_blackbody(double kelvin, struct spectrum *out) {
    const double planck = 6.62607015e-34, light = 2.99792458e8, boltzmann = 1.380649e-23;
    for (int i = 0; i < CIE_COUNT; i++) {
        double nm = CIE_FIRST + CIE_STEP * i, m = nm * 1e-9;
        double per_meter = 2 * planck * light * light / (m * m * m * m * m) /
                           expm1(planck * light / (m * boltzmann * kelvin));
        if (!spectrum_add(out, nm, per_meter * 1e-9))
            return false;
    }
    return true;
}

/* The CIE's curves and D65 at a wavelength between the first and the last. */
static void look_up(double wavelength, double out[4]) {
    double at = (wavelength - CIE_FIRST) / CIE_STEP;
    int i = at < CIE_COUNT - 1 ? (int)at : CIE_COUNT - 2;
    double share = at - i;
    for (int c = 0; c < 4; c++)
        out[c] = cie_curves[i][c] * (1 - share) + cie_curves[i + 1][c] * share;
}

struct vec3 spectrum_to_rgb(const struct spectrum *spectrum, bool under_d65) {
    /* So that a flat spectrum of 1 has luminance 1: 1 / integral of y, and that of y times D65. */
    const double y_scale = 0.009367658735689113, d65_scale = 0.010101273599490354;
    const double range = CIE_STEP * (CIE_COUNT - 1);
    double x = 0, y = 0, z = 0, curves[4];
    size_t k = 0;
    for (int i = 0; i < STEPS; i++) {
        double wavelength = CIE_FIRST + range * i / (STEPS - 1);
        if (wavelength < spectrum->wavelengths[0] ||
            wavelength > spectrum->wavelengths[spectrum->count - 1])
            continue;
        while (k + 2 < spectrum->count && spectrum->wavelengths[k + 1] < wavelength)
            k++;
        double from = spectrum->wavelengths[k], to = spectrum->wavelengths[k + 1];
        double share = (wavelength - from) / (to - from);
        double value = spectrum->values[k] * (1 - share) + spectrum->values[k + 1] * share;
        look_up(wavelength, curves);
        if (under_d65)
            value *= curves[3] * d65_scale;
        x += curves[0] * value;
        y += curves[1] * value;
        z += curves[2] * value;
    }
    double scale = y_scale * range / STEPS;
    /* IEC 61966-2-1. */
    double rgb[3] = {3.240479 * x - 1.537150 * y - 0.498535 * z,
                     -0.969256 * x + 1.875991 * y + 0.041556 * z,
                     0.055648 * x - 0.204043 * y + 1.057311 * z};
    for (int c = 0; c < 3; c++)
        rgb[c] = fmax(0, fmin(rgb[c] * scale, 1e30));
    return vec((float)rgb[0], (float)rgb[1], (float)rgb[2]);
}
