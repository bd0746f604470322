/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters of a plugin by name and type. */

#include "guide/scene/params.h"

#include <limits.h>
#include <string.h>

#include "guide/scene/number.h"
#include "guide/scene/plugins.h"

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

int param_wrong_type(struct loader *loader, const struct xml_node *node, const char *wanted) {
    return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "%s should be a <%s>, not a <%s>",
                       xml_attribute(node, "name"), wanted, node->tag);
}

int param_wrong_value(struct loader *loader, const struct xml_node *node, const char *wanted) {
    const char *name = xml_attribute(node, "name"), *value = xml_attribute(node, "value");
    return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "%s = '%s' is not %s",
                       name ? name : node->tag, value ? value : "", wanted);
}

/* --- values */

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
        return read_point(node, numbers) ? FEWRAY_OK
                                         : param_wrong_value(loader, node, "three numbers");
    if (has_tag(node, "rgb") || has_tag(node, "spectrum"))
        return param_check_color(loader, node);
    if (!value)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "<%s name=\"%s\"> has no value",
                           node->tag, xml_attribute(node, "name"));
    if (has_tag(node, "float") && number_read_list(value, numbers, 1) != 1)
        return param_wrong_value(loader, node, "a finite number");
    if (has_tag(node, "integer") && !read_integer(value, &whole))
        return param_wrong_value(loader, node, "a whole number");
    if (has_tag(node, "boolean") && strcmp(value, "true") && strcmp(value, "false"))
        return param_wrong_value(loader, node, "true or false");
    return FEWRAY_OK;
}

/* --- getters; the values were checked by param_check() */

int param_float(struct loader *loader, struct xml_node *plugin, const char *name, double *out) {
    struct xml_node *node = param_find(plugin, name);
    if (!node)
        return FEWRAY_OK;
    if (!has_tag(node, "float") && !has_tag(node, "integer"))
        return param_wrong_type(loader, node, "float");
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
        return param_wrong_type(loader, node, "integer");
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
        return param_wrong_type(loader, node, "boolean");
    *out = !strcmp(xml_attribute(node, "value"), "true");
    return FEWRAY_OK;
}

int param_string(struct loader *loader, struct xml_node *plugin, const char *name,
                 const char **out) {
    struct xml_node *node = param_find(plugin, name);
    if (!node)
        return FEWRAY_OK;
    if (!has_tag(node, "string"))
        return param_wrong_type(loader, node, "string");
    *out = xml_attribute(node, "value");
    return FEWRAY_OK;
}

int param_number(struct loader *loader, struct xml_node *plugin, const char *name, double minimum,
                 double maximum, double *out) {
    double value = *out;
    int status = param_float(loader, plugin, name, &value);
    if (!status && param_find(plugin, name) && !(value >= minimum && value <= maximum))
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, param_find(plugin, name),
                             "%s = %g must lie in %g..%g", name, value, minimum, maximum);
    if (!status)
        *out = value;
    return status;
}

int param_point(struct loader *loader, struct xml_node *plugin, const char *name, double out[3]) {
    struct xml_node *node = param_find(plugin, name);
    if (!node)
        return FEWRAY_OK;
    if (!has_tag(node, "point") && !has_tag(node, "vector"))
        return param_wrong_type(loader, node, "point");
    read_point(node, out);
    return FEWRAY_OK;
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
