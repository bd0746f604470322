/* SPDX-License-Identifier: Apache-2.0 */
/* How a camera moves: poses at some times, and those between them. */

#include "guide/scene/camera_path.h"

#include <string.h>

/* Rotations closer than this are mixed linearly: the sine of their angle tells nothing. */
#define ALMOST_EQUAL 0.9995

static bool is_rigid(const struct transform *t) {
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++) {
            double product = 0;
            for (int k = 0; k < 3; k++)
                product += t->m[k][i] * t->m[k][j];
            if (!(fabs(product - (i == j)) <= 1e-3))
                return false;
        }
    return true;
}

static void normalize4(double q[4]) {
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++)
        q[i] /= length;
}

/* The quaternion (x, y, z, w) of a rotation, by its largest component (Shepperd 1978, "Quaternion
 * from rotation matrix"). */
static void to_quaternion(double m[3][3], double q[4]) {
    const double trace = m[0][0] + m[1][1] + m[2][2];
    int largest = 3;
    double most = trace;
    for (int i = 0; i < 3; i++)
        if (m[i][i] > most) {
            largest = i;
            most = m[i][i];
        }
    if (largest == 3) {
        q[3] = 1 + trace;
        for (int i = 0; i < 3; i++)
            q[i] = m[(i + 2) % 3][(i + 1) % 3] - m[(i + 1) % 3][(i + 2) % 3];
    } else {
        const int i = largest, j = (i + 1) % 3, k = (i + 2) % 3;
        q[i] = 1 + 2 * m[i][i] - trace;
        q[j] = m[i][j] + m[j][i];
        q[k] = m[i][k] + m[k][i];
        q[3] = m[k][j] - m[j][k];
    }
    normalize4(q);
}

static void to_matrix(const double q[4], double m[3][3]) {
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double rows[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
        {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
        {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)},
    };
    memcpy(m, rows, sizeof rows);
}

bool camera_key_make(const struct transform *to_world, double time, struct camera_key *out) {
    if (!is_rigid(to_world))
        return false;
    double m[3][3];
    out->time = time;
    out->mirrored = transform_determinant(to_world) < 0;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            m[i][j] = out->mirrored && j == 0 ? -to_world->m[i][j] : to_world->m[i][j];
        out->position[i] = to_world->m[i][3];
    }
    to_quaternion(m, out->rotation);
    return true;
}

static void slerp(const double a[4], const double b[4], double t, double out[4]) {
    double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const double sign = cosine < 0 ? -1 : 1; /* q and -q are the same rotation */
    double from = 1 - t, to = t;
    cosine *= sign;
    if (cosine < ALMOST_EQUAL) {
        const double angle = acos(cosine);
        from = sin((1 - t) * angle) / sin(angle);
        to = sin(t * angle) / sin(angle);
    }
    for (int i = 0; i < 4; i++)
        out[i] = from * a[i] + to * sign * b[i];
    normalize4(out);
}

void camera_path_at(const struct camera_key *keys, int count, double time, float to_world[12]) {
    int next = 0;
    while (next < count && keys[next].time <= time)
        next++;
    const struct camera_key *a = &keys[next > 0 ? next - 1 : 0];
    const struct camera_key *b = &keys[next < count ? next : count - 1];
    const double t = a == b ? 0 : (time - a->time) / (b->time - a->time);
    double rotation[4], m[3][3];
    slerp(a->rotation, b->rotation, t, rotation);
    to_matrix(rotation, m);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            to_world[4 * i + j] = (float)(a->mirrored && j == 0 ? -m[i][j] : m[i][j]);
        to_world[4 * i + 3] = (float)(a->position[i] + t * (b->position[i] - a->position[i]));
    }
}
