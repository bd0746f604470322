/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_TRANSFORM_H
#define FEWRAY_GUIDE_SCENE_TRANSFORM_H

/* Affine transforms, in double so that chains of them lose nothing. */

#include "guide/vec.h"

struct loader;
struct xml_node;

struct transform {
    double m[3][4]; /* rows; a point p becomes m (p, 1) */
};

struct transform transform_identity(void);
/* First b, then a. */
struct transform transform_multiply(const struct transform *a, const struct transform *b);
double transform_determinant(const struct transform *t);
/* The matrix that normals transform by, up to a positive factor: the inverse transpose. Finite for
 * a singular t as well. */
void transform_normal_matrix(const struct transform *t, double out[3][3]);

/* Reads a <transform>: its operations in their order, each applied after those before it. */
int transform_parse(struct loader *loader, const struct xml_node *node, struct transform *out);
/* The <transform> parameter of a plugin; the identity where it has none. */
int param_transform(struct loader *loader, struct xml_node *plugin, const char *name,
                    struct transform *out);

#endif
