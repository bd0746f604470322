/* SPDX-License-Identifier: Apache-2.0 */
/* Colours of a plugin: RGB, sRGB codes, and spectra. */

#include <stdlib.h>
#include <string.h>

#include "guide/scene/number.h"
#include "guide/scene/params.h"
#include "guide/scene/spectrum.h"

/* Equal-energy white in linear sRGB: what Mitsuba's RGB modes make of a flat emission spectrum
 * of 1. */
static const struct vec3 equal_energy = {1.20479f, 0.94829f, 0.908916f};

static bool has_tag(const struct xml_node *node, const char *tag) {
    return !strcmp(node->tag, tag);
}

static const char *name_of(const struct xml_node *node) {
    const char *name = xml_attribute(node, "name");
    return name ? name : node->tag;
}

/* --- texts */

static int hex_digit(char c) {
    const char *digits = "0123456789abcdef", *found = c ? strchr(digits, c | 0x20) : NULL;
    return found ? (int)(found - digits) : -1;
}

/* "#rrggbb" is an sRGB colour as web pages write it. */
static bool read_hex_color(const char *text, double rgb[3]) {
    if (strlen(text) != 7)
        return false;
    for (int i = 0; i < 3; i++) {
        int high = hex_digit(text[1 + 2 * i]), low = hex_digit(text[2 + 2 * i]);
        if (high < 0 || low < 0)
            return false;
        double encoded = (16 * high + low) / 255.0;
        rgb[i] = encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
    }
    return true;
}

static bool read_rgb(const char *text, double rgb[3]) {
    if (text[0] == '#')
        return read_hex_color(text, rgb);
    int count = number_read_list(text, rgb, 3);
    if (count == 1)
        rgb[1] = rgb[2] = rgb[0];
    return count == 1 || count == 3;
}

static int read_list(struct loader *loader, const struct xml_node *node, const char *text,
                     struct spectrum *spectrum) {
    const char *fault;
    if (spectrum_read_list(text, spectrum, &fault))
        return FEWRAY_OK;
    return fault ? loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "%s: %s", name_of(node), fault)
                 : loader_fail_memory(loader);
}

int param_check_color(struct loader *loader, const struct xml_node *node) {
    const char *value = xml_attribute(node, "value");
    double rgb[3];
    bool spectrum = has_tag(node, "spectrum");
    if (spectrum && !value && xml_attribute(node, "filename"))
        return FEWRAY_OK;
    if (!value)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "<%s name=\"%s\"> has no value",
                           node->tag, name_of(node));
    if (spectrum && strchr(value, ':')) {
        struct spectrum points = {0};
        int status = read_list(loader, node, value, &points);
        spectrum_free(&points);
        return status;
    }
    return read_rgb(value, rgb)
               ? FEWRAY_OK
               : param_wrong_value(loader, node, "a colour: 1 or 3 finite numbers, or #rrggbb");
}

/* --- spectra */

static int read_file(struct loader *loader, const struct xml_node *node,
                     struct spectrum *spectrum) {
    struct fewray_error error = {0};
    char *path = loader_find_file(loader, xml_attribute(node, "filename"));
    if (!path)
        return loader_fail_memory(loader);
    int status = spectrum_read_file(path, spectrum, &error);
    if (status)
        status =
            loader_fail(loader, status, node, "%.160s:%d: %.300s", path, error.line, error.what);
    free(path);
    return status;
}

/* regular: values over wavelength_min..wavelength_max; irregular: two lists. */
static int read_points(struct loader *loader, struct xml_node *node, struct spectrum *spectrum) {
    enum { MOST = 4096 };
    bool regular = !strcmp(xml_attribute(node, "type"), "regular");
    const char *values = NULL, *wavelengths = NULL;
    double *numbers = malloc(2 * MOST * sizeof(double)), first = 0, last = 0;
    int status = numbers ? FEWRAY_OK : loader_fail_memory(loader);
    if (!status)
        status = param_string(loader, node, "values", &values);
    if (!status && regular)
        status = param_float(loader, node, "wavelength_min", &first);
    if (!status && regular)
        status = param_float(loader, node, "wavelength_max", &last);
    if (!status && !regular)
        status = param_string(loader, node, "wavelengths", &wavelengths);
    int count = !status && values ? number_read_list(values, numbers, MOST) : 0;
    if (!status && !regular &&
        (!wavelengths || number_read_list(wavelengths, numbers + MOST, MOST) != count))
        count = 0;
    for (int i = 0; i < count && !status; i++) {
        double at =
            regular ? first + (last - first) * i / (count > 1 ? count - 1 : 1) : numbers[MOST + i];
        if (!spectrum_add(spectrum, at, numbers[i]))
            status = loader_fail_memory(loader);
    }
    const char *fault = status ? NULL : spectrum_fault(spectrum);
    if (fault)
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "%s: %s", name_of(node), fault);
    free(numbers);
    return status;
}

static int read_blackbody(struct loader *loader, struct xml_node *node, struct spectrum *spectrum) {
    double kelvin = 0;
    int status = param_number(loader, node, "temperature", 1, 1e6, &kelvin);
    if (!status && !(kelvin > 0))
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "%s: blackbody has no temperature",
                             name_of(node));
    if (!status && !spectrum_blackbody(kelvin, spectrum))
        status = loader_fail_memory(loader);
    return status;
}

/* d65 and srgb: a colour as it is; uniform and rawconstant: a value as it is. */
static int read_plain_plugin(struct loader *loader, struct xml_node *node, double rgb[3]) {
    const char *type = xml_attribute(node, "type");
    bool white = !strcmp(type, "d65");
    struct xml_node *color = param_find(node, white || !strcmp(type, "srgb") ? "color" : "value");
    double factor = 1;
    struct vec3 value = vec(1, 1, 1);
    int status = white ? param_number(loader, node, "scale", 0, 1e30, &factor) : FEWRAY_OK;
    if (status)
        return status;
    if (!color && !white)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "%s: %s has no value", name_of(node),
                           type);
    if (color)
        status = param_color(loader, color, COLOR_UNBOUNDED, &value);
    rgb[0] = value.x * factor;
    rgb[1] = value.y * factor;
    rgb[2] = value.z * factor;
    return status;
}

/* Ends a reader: the colour of what it read, if it did. */
static int finish(struct spectrum *spectrum, enum color_use use, int status, double rgb[3]) {
    if (!status) {
        struct vec3 color = spectrum_to_rgb(spectrum, use != COLOR_EMISSION);
        double most = use == COLOR_REFLECTANCE ? 1 : 1e30;
        rgb[0] = fmin(color.x, most);
        rgb[1] = fmin(color.y, most);
        rgb[2] = fmin(color.z, most);
    }
    spectrum_free(spectrum);
    return status;
}

static int read_plugin(struct loader *loader, struct xml_node *node, enum color_use use,
                       double rgb[3]) {
    const char *type = xml_attribute(node, "type");
    struct spectrum spectrum = {0};
    int status;
    if (!strcmp(type, "regular") || !strcmp(type, "irregular"))
        status = finish(&spectrum, use, read_points(loader, node, &spectrum), rgb);
    else if (!strcmp(type, "blackbody"))
        status = finish(&spectrum, use, read_blackbody(loader, node, &spectrum), rgb);
    else
        status = read_plain_plugin(loader, node, rgb);
    return status ? status : params_finish(loader, node);
}

static int read_spectrum(struct loader *loader, struct xml_node *node, enum color_use use,
                         double rgb[3]) {
    const char *value = xml_attribute(node, "value");
    struct spectrum spectrum = {0};
    if (!value)
        return finish(&spectrum, use, read_file(loader, node, &spectrum), rgb);
    if (strchr(value, ':'))
        return finish(&spectrum, use, read_list(loader, node, value, &spectrum), rgb);
    read_rgb(value, rgb);
    if (use == COLOR_EMISSION) {
        rgb[0] *= (double)equal_energy.x;
        rgb[1] *= (double)equal_energy.y;
        rgb[2] *= (double)equal_energy.z;
    }
    return FEWRAY_OK;
}

/* --- getters */

int param_color(struct loader *loader, struct xml_node *node, enum color_use use,
                struct vec3 *out) {
    double rgb[3] = {0, 0, 0}, maximum = use == COLOR_REFLECTANCE ? 1 : 1e30;
    double minimum = use == COLOR_SIGNED ? -1e30 : 0;
    const char *type = xml_attribute(node, "type");
    int status = FEWRAY_OK;
    if (!has_tag(node, "rgb") && !has_tag(node, "spectrum") && !has_tag(node, "float") &&
        !has_tag(node, "integer"))
        return type ? loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, node,
                                  "%s: <%s type=\"%s\"> is not supported here yet: give an <rgb>",
                                  name_of(node), node->tag, type)
                    : param_wrong_type(loader, node, "rgb");
    if (has_tag(node, "spectrum") && type)
        status = read_plugin(loader, node, use, rgb);
    else if (has_tag(node, "spectrum"))
        status = read_spectrum(loader, node, use, rgb);
    else
        read_rgb(xml_attribute(node, "value"), rgb);
    for (int i = 0; i < 3 && !status; i++)
        if (!(rgb[i] >= minimum && rgb[i] <= maximum))
            status =
                param_wrong_value(loader, node, maximum > 1 ? "a colour >= 0" : "a colour in 0..1");
    if (!status)
        *out = vec((float)rgb[0], (float)rgb[1], (float)rgb[2]);
    return status;
}

int param_radiance(struct loader *loader, struct xml_node *plugin, const char *name,
                   struct vec3 *out) {
    struct xml_node *node = param_find(plugin, name);
    return node ? param_color(loader, node, COLOR_EMISSION, out) : FEWRAY_OK;
}
