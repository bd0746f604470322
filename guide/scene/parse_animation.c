/* SPDX-License-Identifier: Apache-2.0 */
/* The keys of a moving sensor, as Mitsuba 0.6 writes them (Mitsuba 3 has no <animation>):
 *
 *     <animation name="to_world">
 *       <transform time="0"> ... </transform>
 *       <transform time="1.5"> ... </transform>
 *     </animation>
 */

#include <stdlib.h>

#include "guide/scene/camera_path.h"
#include "guide/scene/number.h"
#include "guide/scene/params.h"

/* Beyond this frames of a second can't be told apart. */
#define TIME_MAX 1e6

int check_key_time(struct loader *loader, const struct xml_node *node, double *time) {
    const char *text = xml_attribute(node, "time");
    if (!text)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node,
                           "a <transform> of an <animation> needs a time, in seconds");
    if (number_read_list(text, time, 1) != 1 || !(*time >= -TIME_MAX && *time <= TIME_MAX))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, node,
                           "time = '%s' should be a number of seconds", text);
    return FEWRAY_OK;
}

static int read_key(struct loader *loader, const struct xml_node *node, struct camera_key *key) {
    double time = 0;
    struct transform to_world;
    int status = check_key_time(loader, node, &time);
    if (!status)
        status = transform_parse(loader, node, &to_world);
    if (!status && !camera_key_make(&to_world, time, key))
        status = loader_fail(loader, FEWRAY_ERROR_FORMAT, node,
                             "the sensor's to_world must not scale or shear");
    return status;
}

int parse_camera_animation(struct loader *loader, const struct xml_node *animation) {
    struct fewray_scene *scene = loader->scene;
    size_t count = 0;
    for (const struct xml_node *key = animation->first_child; key; key = key->next)
        count++;
    if (!count)
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, animation,
                           "the animation has no <transform>");
    scene->camera_keys = calloc(count, sizeof(*scene->camera_keys));
    if (!scene->camera_keys)
        return loader_fail_memory(loader);
    for (const struct xml_node *node = animation->first_child; node; node = node->next) {
        struct camera_key *key = &scene->camera_keys[scene->camera_key_count];
        int status = read_key(loader, node, key);
        if (status)
            return status;
        if (scene->camera_key_count > 0 && !(key->time > key[-1].time))
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, node,
                               "the times of an animation must rise: %g follows %g", key->time,
                               key[-1].time);
        if (scene->camera_key_count > 0 && key->mirrored != key[-1].mirrored)
            return loader_fail(loader, FEWRAY_ERROR_FORMAT, node,
                               "one key of the animation mirrors and another doesn't");
        scene->camera_key_count++;
    }
    fewray_scene_set_time(scene, 0);
    return FEWRAY_OK;
}
