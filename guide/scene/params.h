/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_PARAMS_H
#define FEWRAY_GUIDE_SCENE_PARAMS_H

/* Parameters of a plugin by name and type. A parameter that is missing leaves *out as it is; one of
 * a wrong type or range is an error. Each look marks the parameter as used; params_finish() warns
 * of the rest. */

#include "guide/scene/loader.h"

/* The child element (a value, a texture, a reference) of this name, or NULL. */
struct xml_node *param_find(struct xml_node *plugin, const char *name);
/* For parameters that make no difference here. */
void params_ignore(struct xml_node *plugin, const char *const *names);
void params_ignore_all(struct xml_node *plugin);

int param_float(struct loader *loader, struct xml_node *plugin, const char *name, double *out);
/* The same, within limits. */
int param_number(struct loader *loader, struct xml_node *plugin, const char *name, double minimum,
                 double maximum, double *out);
int param_integer(struct loader *loader, struct xml_node *plugin, const char *name, int minimum,
                  int *out);
int param_boolean(struct loader *loader, struct xml_node *plugin, const char *name, bool *out);
int param_string(struct loader *loader, struct xml_node *plugin, const char *name,
                 const char **out);
int param_point(struct loader *loader, struct xml_node *plugin, const char *name, double out[3]);

/* --- colours (param_color.c) */

enum color_use {
    COLOR_REFLECTANCE, /* 0..1, as seen under D65 */
    COLOR_UNBOUNDED,   /* >= 0: a roughness, a radiance in a texture */
    COLOR_SIGNED,      /* any: an index of refraction, whose RGB may leave the gamut */
    COLOR_EMISSION     /* >= 0; a spectrum's value is that of each wavelength */
};

/* The colour of an <rgb>, <spectrum> (a value, a list, a file, a plugin) or <float>. */
int param_color(struct loader *loader, struct xml_node *node, enum color_use use, struct vec3 *out);
/* The same by its name, if it is there. */
int param_radiance(struct loader *loader, struct xml_node *plugin, const char *name,
                   struct vec3 *out);
/* Whether the value of an <rgb> or <spectrum> can be read. */
int param_check_color(struct loader *loader, const struct xml_node *node);

/* Warns, once each, of parameters that nobody asked for. */
int params_finish(struct loader *loader, struct xml_node *plugin);

/* Whether the value of a property can be read as its type says; the getters rely on it. */
int param_check(struct loader *loader, const struct xml_node *node);

/* "radiance should be a <rgb>, not a <string>"; "radiance = 'x' is not a colour" */
int param_wrong_type(struct loader *loader, const struct xml_node *node, const char *wanted);
int param_wrong_value(struct loader *loader, const struct xml_node *node, const char *wanted);

#endif
