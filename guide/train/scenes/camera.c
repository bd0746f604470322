/* SPDX-License-Identifier: Apache-2.0 */
/* Where to stand and where to look: random tries, judged by what they see. */

#include "guide/train/scenes/camera.h"

#include "guide/train/scenes/preview.h"

#define TRIES 60

static struct camera_pose random_pose(struct stage *stage) {
    struct random *r = &stage->random;
    struct vec3 low = stage->camera_low, high = stage->camera_high;
    float x = uniform(r, low.x, high.x), z = uniform(r, low.z, high.z);
    float y = chance(r, 0.8f) ? fminf(high.y, fmaxf(low.y, uniform(r, 0.9f, 1.8f)))
                              : uniform(r, low.y, high.y);
    struct camera_pose pose = {.eye = xform_point(&stage->root, vec(x, y, z)), .up = vec(0, 1, 0)};
    if (stage->interest_count > 0 && chance(r, 0.75f)) {
        pose.target = stage->interest[between(r, 0, stage->interest_count - 1)];
    } else {
        float tx = uniform(r, low.x, high.x), tz = uniform(r, low.z, high.z),
              ty = uniform(r, 0, high.y);
        pose.target = xform_point(&stage->root, vec(tx, ty, tz));
    }
    if (chance(r, 0.2f))
        pose.up = normalize(vec(uniform(r, -0.15f, 0.15f), 1, uniform(r, -0.15f, 0.15f)));
    pose.fov = uniform(r, 35, 80);
    return pose;
}

/* How good a view is; negative: unusable. metre: world units of one. */
static float judge(const struct stage *stage, const struct camera_pose *pose, float aspect,
                   float metre) {
    struct vec3 to = sub(pose->target, pose->eye);
    float away = length(to);
    if (away < 0.6f * metre || fabsf(to.y) > 0.75f * away)
        return -1;
    struct view view = preview_view(stage, pose, aspect);
    if (view.nearest < 0.12f * metre || view.near_depth < 0.5f * metre ||
        view.median_depth < 1.5f * metre)
        return -1;
    if (view.shapes < 5 || view.largest_share > 0.6f || view.sky_share > 0.6f)
        return -1;
    return (float)view.shapes;
}

static bool set_exposure(struct stage *stage, float aspect) {
    struct random *r = &stage->random;
    struct exposure exposure = preview_exposure(stage, &stage->camera, aspect, r);
    if (!(exposure.reflected > 1e-9f) || exposure.lit_share < 0.12f)
        return false;
    /* As a photographer would: for the room, but with an eye on its bright windows. */
    float gain = log_uniform(r, 0.08f, 0.45f) / (exposure.reflected + 0.35f * exposure.emitted);
    for (int i = 0; i < stage->shape_count; i++)
        stage->shapes[i].radiance = scale(stage->shapes[i].radiance, gain);
    for (int i = 0; i < stage->lamp_count; i++)
        stage->lamps[i].intensity = scale(stage->lamps[i].intensity, gain);
    stage->sky.strength *= gain;
    return true;
}

bool choose_camera(struct stage *stage, float aspect) {
    float metre = length(xform_vector(&stage->root, vec(1, 0, 0))), best = 0;
    int good = 0;
    for (int i = 0; i < TRIES && good < 5; i++) {
        struct camera_pose pose = random_pose(stage);
        float score = judge(stage, &pose, aspect, metre);
        if (score < 0)
            continue;
        good++;
        if (score > best) {
            best = score;
            stage->camera = pose;
        }
    }
    return good > 0 && set_exposure(stage, aspect);
}
