/* SPDX-License-Identifier: Apache-2.0 */
/* Affine transforms and the <transform> element. */

#include "guide/scene/transform.h"

#include <float.h>
#include <string.h>

#include "guide/scene/number.h"
#include "guide/scene/params.h"

struct transform transform_identity(void) {
    return (struct transform){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

struct transform transform_multiply(const struct transform *a, const struct transform *b) {
    struct transform out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            out.m[i][j] = a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] +
                          a->m[i][2] * b->m[2][j] + (j == 3 ? a->m[i][3] : 0);
    return out;
}

/* The cofactors: inverse transpose times determinant. */
static void cofactors(const struct transform *t, double out[3][3]) {
    for (int i = 0; i < 3; i++) {
        int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
        for (int j = 0; j < 3; j++) {
            int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            out[i][j] = t->m[i1][j1] * t->m[i2][j2] - t->m[i1][j2] * t->m[i2][j1];
        }
    }
}

double transform_determinant(const struct transform *t) {
    double c[3][3];
    cofactors(t, c);
    return t->m[0][0] * c[0][0] + t->m[0][1] * c[0][1] + t->m[0][2] * c[0][2];
}

void transform_normal_matrix(const struct transform *t, double out[3][3]) {
    cofactors(t, out);
    if (transform_determinant(t) < 0)
        for (int i = 0; i < 9; i++)
            out[i / 3][i % 3] = -out[i / 3][i % 3];
}

/* --- operations */

static int bad_operation(struct loader *loader, const struct xml_node *node, const char *why) {
    return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "<%s>: %s", node->tag, why);
}

/* value="2" (all axes, for scale only), value="1, 2, 3", or x, y, z, each with a default. */
static int read_axes(struct loader *loader, const struct xml_node *node, double fallback,
                     double out[3]) {
    static const char *const axes[] = {"x", "y", "z"};
    const char *value = xml_attribute(node, "value");
    out[0] = out[1] = out[2] = fallback;
    if (value) {
        int count = number_read_list(value, out, 3);
        if (count == 1 && !strcmp(node->tag, "scale"))
            out[1] = out[2] = out[0];
        else if (count != 3)
            return bad_operation(loader, node, "value should be three finite numbers");
        return FEWRAY_OK;
    }
    for (int i = 0; i < 3; i++) {
        const char *text = xml_attribute(node, axes[i]);
        if (text && number_read_list(text, &out[i], 1) != 1)
            return bad_operation(loader, node, "x, y and z should be finite numbers");
    }
    return FEWRAY_OK;
}

static int parse_translate(struct loader *loader, const struct xml_node *node,
                           struct transform *out) {
    double by[3];
    int status = read_axes(loader, node, 0, by);
    for (int i = 0; i < 3 && !status; i++)
        out->m[i][3] = by[i];
    return status;
}

static int parse_scale(struct loader *loader, const struct xml_node *node, struct transform *out) {
    double by[3];
    int status = read_axes(loader, node, 1, by);
    for (int i = 0; i < 3 && !status; i++)
        out->m[i][i] = by[i];
    return status;
}

/* Rodrigues' formula. */
static int parse_rotate(struct loader *loader, const struct xml_node *node, struct transform *out) {
    double a[3], degrees;
    const char *angle = xml_attribute(node, "angle");
    int status = read_axes(loader, node, 0, a);
    if (status)
        return status;
    if (!angle || number_read_list(angle, &degrees, 1) != 1)
        return bad_operation(loader, node, "angle should be a finite number of degrees");
    double length_a = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    if (!(length_a > 0 && length_a < DBL_MAX))
        return bad_operation(loader, node, "the axis is zero");
    for (int i = 0; i < 3; i++)
        a[i] /= length_a;
    double radians = degrees * (3.14159265358979323846 / 180), s = sin(radians), c = cos(radians);
    const double skew[3][3] = {{0, -a[2], a[1]}, {a[2], 0, -a[0]}, {-a[1], a[0], 0}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out->m[i][j] = (i == j ? c : 0) + (1 - c) * a[i] * a[j] + s * skew[i][j];
    return FEWRAY_OK;
}

static bool normalize_double(double v[3]) {
    double l = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(l > 0 && l < DBL_MAX))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] /= l;
    return true;
}

static void cross_double(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* +z towards the target, +x to the left of it, +y up. */
static int parse_lookat(struct loader *loader, const struct xml_node *node, struct transform *out) {
    static const char *const names[] = {"origin", "target", "up"};
    double v[3][3], forward[3], left[3], up[3];
    for (int i = 0; i < 3; i++) {
        const char *text = xml_attribute(node, names[i]);
        if (!text || number_read_list(text, v[i], 3) != 3)
            return bad_operation(loader, node,
                                 "origin, target and up should be three finite numbers each");
    }
    for (int i = 0; i < 3; i++)
        forward[i] = v[1][i] - v[0][i];
    if (!normalize_double(forward))
        return bad_operation(loader, node, "origin and target are the same point");
    cross_double(v[2], forward, left);
    if (!normalize_double(left))
        return bad_operation(loader, node, "up points along the view");
    cross_double(forward, left, up);
    for (int i = 0; i < 3; i++) {
        out->m[i][0] = left[i];
        out->m[i][1] = up[i];
        out->m[i][2] = forward[i];
        out->m[i][3] = v[0][i];
    }
    return FEWRAY_OK;
}

/* 16 numbers, or the 9 of a linear map; row by row. */
static int parse_matrix(struct loader *loader, const struct xml_node *node, struct transform *out) {
    double v[16];
    const char *value = xml_attribute(node, "value");
    int count = value ? number_read_list(value, v, 16) : -1;
    if (count != 16 && count != 9)
        return bad_operation(loader, node, "value should be 16 or 9 finite numbers");
    int columns = count == 16 ? 4 : 3;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < columns; j++)
            out->m[i][j] = v[i * columns + j];
    if (count == 16 && (v[12] != 0 || v[13] != 0 || v[14] != 0 || v[15] != 1))
        return bad_operation(loader, node, "the last row must be 0 0 0 1");
    return FEWRAY_OK;
}

static int parse_operation(struct loader *loader, const struct xml_node *node,
                           struct transform *out) {
    *out = transform_identity();
    if (!strcmp(node->tag, "translate"))
        return parse_translate(loader, node, out);
    if (!strcmp(node->tag, "scale"))
        return parse_scale(loader, node, out);
    if (!strcmp(node->tag, "rotate"))
        return parse_rotate(loader, node, out);
    if (!strcmp(node->tag, "lookat"))
        return parse_lookat(loader, node, out);
    if (!strcmp(node->tag, "matrix"))
        return parse_matrix(loader, node, out);
    return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "<%s> is not a transform", node->tag);
}

int transform_parse(struct loader *loader, const struct xml_node *node, struct transform *out) {
    *out = transform_identity();
    for (const struct xml_node *child = node->first_child; child; child = child->next) {
        struct transform operation;
        if (!strcmp(child->tag, "default"))
            continue;
        int status = parse_operation(loader, child, &operation);
        if (status)
            return status;
        *out = transform_multiply(&operation, out);
    }
    for (int i = 0; i < 12; i++)
        if (!(fabs(out->m[i / 4][i % 4]) <= FLT_MAX))
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, node, "the transform is not finite");
    return FEWRAY_OK;
}

int param_transform(struct loader *loader, struct xml_node *plugin, const char *name,
                    struct transform *out) {
    struct xml_node *node = param_find(plugin, name);
    *out = transform_identity();
    if (!node)
        return FEWRAY_OK;
    if (strcmp(node->tag, "transform"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node,
                           "%s should be a <transform>, not a <%s>", name, node->tag);
    return transform_parse(loader, node, out);
}
