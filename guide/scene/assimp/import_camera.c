/* SPDX-License-Identifier: Apache-2.0 */
/* The camera of a file, and how the first animation moves it. */

#include <stdlib.h>
#include <string.h>

#include "guide/scene/assimp/import.h"
#include "guide/scene/camera_path.h"

/* Of one camera: hours of a film. */
#define MAX_KEYS 65536

bool import_camera_pose(const struct transform *node_to_world, struct transform *camera) {
    struct vec3 axes[3];
    for (int j = 0; j < 3; j++)
        axes[j] = vec((float)node_to_world->m[0][j], (float)node_to_world->m[1][j],
                      (float)node_to_world->m[2][j]);
    axes[2] = normalize(negate(axes[2]));
    axes[0] = normalize(cross(axes[1], axes[2]));
    axes[1] = cross(axes[2], axes[0]);
    if (!(dot(axes[0], axes[0]) > 0.5f))
        return false;
    for (int j = 0; j < 3; j++) {
        camera->m[0][j] = axes[j].x;
        camera->m[1][j] = axes[j].y;
        camera->m[2][j] = axes[j].z;
    }
    for (int i = 0; i < 3; i++)
        camera->m[i][3] = node_to_world->m[i][3];
    return true;
}

/* The channel that moves a node, or NULL. */
static const struct aiNodeAnim *channel_of(const struct aiAnimation *animation,
                                           const struct aiNode *node) {
    for (unsigned i = 0; i < animation->mNumChannels; i++)
        if (!strcmp(animation->mChannels[i]->mNodeName.data, node->mName.data))
            return animation->mChannels[i];
    return NULL;
}

/* Share of the way from key `*index` to the next; times[i] by a stride of bytes, for assimp's keys
 * begin with their time. */
static double between(const void *keys, size_t stride, unsigned count, double time,
                      unsigned *index) {
    const char *bytes = keys;
    unsigned next = 0;
    double a, b;
    while (next < count && (memcpy(&a, bytes + next * stride, sizeof a), a <= time))
        next++;
    *index = next > 0 ? next - 1 : 0;
    if (next == 0 || next == count)
        return 0;
    memcpy(&a, bytes + (next - 1) * stride, sizeof a);
    memcpy(&b, bytes + next * stride, sizeof b);
    return (time - a) / (b - a);
}

static void vector_at(const struct aiVectorKey *keys, unsigned count, double time, double out[3]) {
    unsigned i;
    const double t = between(keys, sizeof *keys, count, time, &i);
    const struct aiVector3D *a = &keys[i].mValue, *b = &keys[t > 0 ? i + 1 : i].mValue;
    out[0] = a->x + t * ((double)b->x - a->x);
    out[1] = a->y + t * ((double)b->y - a->y);
    out[2] = a->z + t * ((double)b->z - a->z);
}

static struct camera_key rotation_key(const struct aiQuatKey *key) {
    const struct aiQuaternion *q = &key->mValue;
    return (struct camera_key){.time = key->mTime, .rotation = {q->x, q->y, q->z, q->w}};
}

/* Rows of the node's rotation. */
static void rotation_at(const struct aiNodeAnim *channel, double time, float rows[12]) {
    unsigned i;
    between(channel->mRotationKeys, sizeof *channel->mRotationKeys, channel->mNumRotationKeys, time,
            &i);
    const bool last = i + 1 >= channel->mNumRotationKeys;
    const struct camera_key keys[2] = {rotation_key(&channel->mRotationKeys[i]),
                                       rotation_key(&channel->mRotationKeys[last ? i : i + 1])};
    camera_path_at(keys, last ? 1 : 2, time, rows);
}

/* The node's transform at a time, in assimp's ticks. */
static struct transform node_at(const struct aiAnimation *animation, const struct aiNode *node,
                                double time) {
    const struct aiMatrix4x4 *m = &node->mTransformation;
    struct transform own = {
        {{m->a1, m->a2, m->a3, m->a4}, {m->b1, m->b2, m->b3, m->b4}, {m->c1, m->c2, m->c3, m->c4}}};
    const struct aiNodeAnim *channel = channel_of(animation, node);
    if (!channel || !channel->mNumPositionKeys || !channel->mNumRotationKeys ||
        !channel->mNumScalingKeys)
        return own;
    double position[3], scales[3];
    float rotation[12];
    vector_at(channel->mPositionKeys, channel->mNumPositionKeys, time, position);
    vector_at(channel->mScalingKeys, channel->mNumScalingKeys, time, scales);
    rotation_at(channel, time, rotation);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            own.m[i][j] = rotation[4 * i + j] * scales[j];
        own.m[i][3] = position[i];
    }
    return own;
}

static struct transform world_at(const struct aiAnimation *animation, const struct aiNode *node,
                                 double time) {
    struct transform to_world = node_at(animation, node, time);
    for (const struct aiNode *up = node->mParent; up; up = up->mParent) {
        const struct transform parent = node_at(animation, up, time);
        to_world = transform_multiply(&parent, &to_world);
    }
    return to_world;
}

static int compare_times(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Adds the times of a channel's keys, ticks; all that stand in `times` from *count on. */
static void add_times(const struct aiNodeAnim *channel, double *times, size_t *count) {
    for (unsigned i = 0; i < channel->mNumPositionKeys && *count < MAX_KEYS; i++)
        times[(*count)++] = channel->mPositionKeys[i].mTime;
    for (unsigned i = 0; i < channel->mNumRotationKeys && *count < MAX_KEYS; i++)
        times[(*count)++] = channel->mRotationKeys[i].mTime;
}

static int make_keys(struct import *import, const struct aiAnimation *animation,
                     const struct aiNode *node, const double *times, size_t count) {
    struct fewray_scene *scene = import->scene;
    const double ticks = animation->mTicksPerSecond > 0 ? animation->mTicksPerSecond : 1000;
    scene->camera_keys = calloc(count, sizeof *scene->camera_keys);
    if (!scene->camera_keys)
        return import_fail_memory(import);
    for (size_t i = 0; i < count; i++) {
        struct camera_key *key = &scene->camera_keys[scene->camera_key_count];
        const struct transform to_world = world_at(animation, node, times[i]);
        struct transform pose;
        if (!isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1])))
            continue;
        if (!import_camera_pose(&to_world, &pose) || !camera_key_make(&pose, times[i] / ticks, key))
            return import_fail(import, FEWRAY_ERROR_FORMAT,
                               "the camera's animation scales it to nothing");
        scene->camera_key_count++;
    }
    fewray_scene_set_time(scene, 0);
    return FEWRAY_OK;
}

int import_camera_keys(struct import *import, const struct aiNode *node) {
    if (import->source->mNumAnimations == 0)
        return FEWRAY_OK;
    const struct aiAnimation *animation = import->source->mAnimations[0];
    double *times = calloc(MAX_KEYS, sizeof *times);
    if (!times)
        return import_fail_memory(import);
    size_t count = 0;
    for (const struct aiNode *up = node; up; up = up->mParent) {
        const struct aiNodeAnim *channel = channel_of(animation, up);
        if (channel) {
            add_times(channel, times, &count);
            import->camera_channels++;
        }
    }
    int status = FEWRAY_OK;
    if (count > 0) {
        qsort(times, count, sizeof *times, compare_times);
        status = make_keys(import, animation, node, times, count);
    }
    free(times);
    return status;
}

bool import_moves_more(const struct import *import) {
    unsigned channels = 0;
    for (unsigned i = 0; i < import->source->mNumAnimations; i++)
        channels += import->source->mAnimations[i]->mNumChannels +
                    import->source->mAnimations[i]->mNumMorphMeshChannels;
    return channels > (unsigned)import->camera_channels || gltf_deforms(import->gltf);
}
