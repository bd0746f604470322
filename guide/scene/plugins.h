/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_PLUGINS_H
#define FEWRAY_GUIDE_SCENE_PLUGINS_H

/* The elements and plugin types of Mitsuba 3 (3.9), so that a mistyped one can be told from one
 * that fewray lacks. */

#include <stdbool.h>

enum element_kind {
    ELEMENT_UNKNOWN,
    ELEMENT_OBJECT,    /* has a plugin type: <bsdf type="diffuse"> */
    ELEMENT_REFERENCE, /* <ref id="..."/> */
    ELEMENT_PROPERTY,  /* a value with a name: <float name="fov" value="40"/> */
    ELEMENT_TRANSFORM, /* <transform name="to_world"> */
    ELEMENT_ANIMATION, /* <animation name="to_world">, transforms at times; of Mitsuba 0.6 */
    ELEMENT_OPERATION, /* <translate x="1"/>, within a transform */
    ELEMENT_DEFAULT    /* <default name="spp" value="16"/> */
};

enum element_kind element_kind(const char *tag);

/* Whether Mitsuba has a plugin of this type for the element ("bsdf", "diffuse"). */
bool plugin_is_known(const char *tag, const char *type);

#endif
