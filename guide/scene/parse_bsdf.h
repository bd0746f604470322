/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_PARSE_BSDF_H
#define FEWRAY_GUIDE_SCENE_PARSE_BSDF_H

/* What the parts of the BSDF parser share. Each parse_...() fills *out, whose textures and nested
 * BSDFs are -1 before. Parameters and their defaults are those of Mitsuba's plugins. */

#include "guide/scene/params.h"

/* plain ones, of microfacets or smooth */
int parse_conductor(struct loader *loader, struct xml_node *node, struct bsdf *out);
int parse_dielectric(struct loader *loader, struct xml_node *node, struct bsdf *out);
int parse_plastic(struct loader *loader, struct xml_node *node, struct bsdf *out);
int parse_principled(struct loader *loader, struct xml_node *node, struct bsdf *out);

/* those that change or join others */
int parse_twosided(struct loader *loader, struct xml_node *node, struct bsdf *out);
int parse_mask(struct loader *loader, struct xml_node *node, struct bsdf *out);
int parse_blend(struct loader *loader, struct xml_node *node, struct bsdf *out);
int parse_bump_map(struct loader *loader, struct xml_node *node, struct bsdf *out);
int parse_normal_map(struct loader *loader, struct xml_node *node, struct bsdf *out);

/* The first BSDF among the children that no one has used yet, or NULL. */
int next_nested_bsdf(struct loader *loader, struct xml_node *node, struct xml_node **nested);
/* *index of a BSDF that no element stands for. */
int add_bsdf(struct loader *loader, struct bsdf bsdf, int *index);

#endif
