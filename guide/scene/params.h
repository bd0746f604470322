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
int param_integer(struct loader *loader, struct xml_node *plugin, const char *name, int minimum,
                  int *out);
int param_boolean(struct loader *loader, struct xml_node *plugin, const char *name, bool *out);
int param_string(struct loader *loader, struct xml_node *plugin, const char *name,
                 const char **out);
int param_point(struct loader *loader, struct xml_node *plugin, const char *name, double out[3]);

/* A colour that is >= 0, and <= maximum. */
int param_radiance(struct loader *loader, struct xml_node *plugin, const char *name,
                   struct vec3 *out);
int param_reflectance(struct loader *loader, struct xml_node *node, struct vec3 *out);

/* Warns, once each, of parameters that nobody asked for. */
int params_finish(struct loader *loader, struct xml_node *plugin);

/* Whether the value of a property can be read as its type says; the getters rely on it. */
int param_check(struct loader *loader, const struct xml_node *node);

#endif
