/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters of a plugin by name and type. */

#include "guide/scene/params.h"

#include <limits.h>
#include <string.h>

#include "guide/scene/number.h"
#include "guide/scene/plugins.h"

/* Equal-energy white in linear sRGB: what Mitsuba's RGB modes make of a flat emission spectrum
 * of 1. */
static const struct vec3 equal_energy = {1.20479f, 0.94829f, 0.908916f};

struct xml_node *param_find(struct xml_node *plugin, const char *name) {
    for (struct xml_node *child = plugin->first_child; child; child = child->next) {
        const char *child_name = xml_attribute(child, "name");
        if (child_name && !strcmp(child_name, name)) {
            child->used = true;
            return child;
        }
    }
    return NULL;
}

void params_ignore(struct xml_node *plugin, const char *const *names) {
    for (int i = 0; names[i]; i++)
        param_find(plugin, names[i]);
}

void params_ignore_all(struct xml_node *plugin) {
    for (struct xml_node *child = plugin->first_child; child; child = child->next)
        child->used = true;
}

static bool has_tag(const struct xml_node *node, const char *tag) {
    return !strcmp(node->tag, tag);
}

static int wrong_type(struct loader *loader, const struct xml_node *node, const char *wanted) {
    return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "%s should be a <%s>, not a <%s>",
                       xml_attribute(node, "name"), wanted, node->tag);
}

static int wrong_value(struct loader *loader, const struct xml_node *node, const char *wanted) {
    const char *name = xml_attribute(node, "name"), *value = xml_attribute(node, "value");
    return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "%s = '%s' is not %s",
                       name ? name : node->tag, value ? value : "", wanted);
}

/* --- values */

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

static bool read_color(const char *text, double rgb[3]) {
    if (text[0] == '#')
        return read_hex_color(text, rgb);
    int count = number_read_list(text, rgb, 3);
    if (count == 1)
        rgb[1] = rgb[2] = rgb[0];
    return count == 1 || count == 3;
}

/* A point as value="1, 2, 3" or x="1" y="2" z="3". */
static bool read_point(const struct xml_node *node, double out[3]) {
    static const char *const axes[] = {"x", "y", "z"};
    const char *value = xml_attribute(node, "value");
    out[0] = out[1] = out[2] = 0;
    if (value)
        return number_read_list(value, out, 3) == 3;
    for (int i = 0; i < 3; i++) {
        const char *text = xml_attribute(node, axes[i]);
        if (text && number_read_list(text, &out[i], 1) != 1)
            return false;
    }
    return true;
}

static bool read_integer(const char *text, int64_t *out) {
    return number_read_integer(&text, out) && !*text;
}

int param_check(struct loader *loader, const struct xml_node *node) {
    double numbers[3];
    int64_t whole;
    const char *value = xml_attribute(node, "value");
    if (has_tag(node, "point") || has_tag(node, "vector"))
        return read_point(node, numbers) ? FEWRAY_OK : wrong_value(loader, node, "three numbers");
    if (has_tag(node, "spectrum") && xml_attribute(node, "filename"))
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, node,
                           "%s: spectrum files are not supported yet", xml_attribute(node, "name"));
    if (!value)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "<%s name=\"%s\"> has no value",
                           node->tag, xml_attribute(node, "name"));
    if (has_tag(node, "float") && number_read_list(value, numbers, 1) != 1)
        return wrong_value(loader, node, "a finite number");
    if (has_tag(node, "integer") && !read_integer(value, &whole))
        return wrong_value(loader, node, "a whole number");
    if (has_tag(node, "boolean") && strcmp(value, "true") && strcmp(value, "false"))
        return wrong_value(loader, node, "true or false");
    if (has_tag(node, "spectrum") && strchr(value, ':'))
        return loader_fail(
            loader, FEWRAY_ERROR_UNSUPPORTED, node,
            "%s: spectra of several wavelengths are not supported yet: give an <rgb>",
            xml_attribute(node, "name"));
    if ((has_tag(node, "rgb") || has_tag(node, "spectrum")) && !read_color(value, numbers))
        return wrong_value(loader, node, "a colour: 1 or 3 finite numbers, or #rrggbb");
    return FEWRAY_OK;
}

/* --- getters; the values were checked by param_check() */

int param_float(struct loader *loader, struct xml_node *plugin, const char *name, double *out) {
    struct xml_node *node = param_find(plugin, name);
    if (!node)
        return FEWRAY_OK;
    if (!has_tag(node, "float") && !has_tag(node, "integer"))
        return wrong_type(loader, node, "float");
    number_read_list(xml_attribute(node, "value"), out, 1);
    return FEWRAY_OK;
}

int param_integer(struct loader *loader, struct xml_node *plugin, const char *name, int minimum,
                  int *out) {
    struct xml_node *node = param_find(plugin, name);
    int64_t value = 0;
    if (!node)
        return FEWRAY_OK;
    if (!has_tag(node, "integer"))
        return wrong_type(loader, node, "integer");
    read_integer(xml_attribute(node, "value"), &value);
    if (value < minimum || value > INT_MAX)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "%s = %lld must be %d to %d", name,
                           (long long)value, minimum, INT_MAX);
    *out = (int)value;
    return FEWRAY_OK;
}

int param_boolean(struct loader *loader, struct xml_node *plugin, const char *name, bool *out) {
    struct xml_node *node = param_find(plugin, name);
    if (!node)
        return FEWRAY_OK;
    if (!has_tag(node, "boolean"))
        return wrong_type(loader, node, "boolean");
    *out = !strcmp(xml_attribute(node, "value"), "true");
    return FEWRAY_OK;
}

int param_string(struct loader *loader, struct xml_node *plugin, const char *name,
                 const char **out) {
    struct xml_node *node = param_find(plugin, name);
    if (!node)
        return FEWRAY_OK;
    if (!has_tag(node, "string"))
        return wrong_type(loader, node, "string");
    *out = xml_attribute(node, "value");
    return FEWRAY_OK;
}

int param_point(struct loader *loader, struct xml_node *plugin, const char *name, double out[3]) {
    struct xml_node *node = param_find(plugin, name);
    if (!node)
        return FEWRAY_OK;
    if (!has_tag(node, "point") && !has_tag(node, "vector"))
        return wrong_type(loader, node, "point");
    read_point(node, out);
    return FEWRAY_OK;
}

/* Reads a colour that is >= 0 and <= maximum. */
static int read_checked_color(struct loader *loader, const struct xml_node *node, double maximum,
                              struct vec3 *out) {
    double rgb[3] = {0, 0, 0};
    if (xml_attribute(node, "type"))
        return loader_fail(loader, FEWRAY_ERROR_UNSUPPORTED, node,
                           "%s: <%s type=\"%s\"> is not supported here yet: give an <rgb>",
                           xml_attribute(node, "name"), node->tag, xml_attribute(node, "type"));
    if (!has_tag(node, "rgb") && !has_tag(node, "spectrum") && !has_tag(node, "float"))
        return wrong_type(loader, node, "rgb");
    read_color(xml_attribute(node, "value"), rgb);
    for (int i = 0; i < 3; i++)
        if (!(rgb[i] >= 0 && rgb[i] <= maximum))
            return wrong_value(loader, node, maximum > 1 ? "a colour >= 0" : "a colour in 0..1");
    *out = vec((float)rgb[0], (float)rgb[1], (float)rgb[2]);
    return FEWRAY_OK;
}

int param_radiance(struct loader *loader, struct xml_node *plugin, const char *name,
                   struct vec3 *out) {
    struct xml_node *node = param_find(plugin, name);
    if (!node)
        return FEWRAY_OK;
    int status = read_checked_color(loader, node, 1e30, out);
    if (!status && has_tag(node, "spectrum"))
        *out = mul(*out, equal_energy);
    return status;
}

int param_reflectance(struct loader *loader, struct xml_node *node, struct vec3 *out) {
    return read_checked_color(loader, node, 1, out);
}

int params_finish(struct loader *loader, struct xml_node *plugin) {
    char text[128];
    for (struct xml_node *child = plugin->first_child; child; child = child->next) {
        if (child->used || element_kind(child->tag) == ELEMENT_DEFAULT)
            continue;
        const char *name = xml_attribute(child, "name");
        int status =
            loader_warn(loader, child, "%s %s of %s is not used", name ? "parameter" : "element",
                        name ? name : child->tag, loader_describe(plugin, text));
        if (status)
            return status;
    }
    return FEWRAY_OK;
}
