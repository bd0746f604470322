/* SPDX-License-Identifier: Apache-2.0 */
/* The elements and plugin types of Mitsuba 3. */

#include "guide/scene/plugins.h"

#include <stddef.h>
#include <string.h>

#define MAX_PLUGINS 32

static const struct {
    const char *tag;
    const char *types[MAX_PLUGINS];
} plugins[] = {
    {"integrator",
     {"aov", "depth", "direct", "direct_projective", "moment", "path", "prb", "prb_basic",
      "prb_projective", "prbvolpath", "ptracer", "stokes", "volpath", "volpathmis",
      "volprim_rf_basic"}},
    {"sensor",
     {"batch", "distant", "irradiancemeter", "orthographic", "perspective", "radiancemeter",
      "thinlens"}},
    {"film", {"hdrfilm", "specfilm"}},
    {"sampler", {"independent", "ldsampler", "multijitter", "orthogonal", "stratified"}},
    {"rfilter", {"box", "catmullrom", "gaussian", "lanczos", "mitchell", "tent"}},
    {"shape",
     {"blender", "bsplinecurve", "cube", "cylinder", "disk", "ellipsoids", "ellipsoidsmesh",
      "instance", "linearcurve", "merge", "obj", "ply", "rectangle", "sdfgrid", "serialized",
      "shapegroup", "sphere"}},
    {"bsdf", {"blendbsdf",    "bumpmap",        "circular", "conductor",      "dielectric",
              "diffuse",      "hair",           "mask",     "measured",       "measured_polarized",
              "normalmap",    "null",           "plastic",  "polarizer",      "pplastic",
              "principled",   "principledthin", "retarder", "roughconductor", "roughdielectric",
              "roughplastic", "thindielectric", "twosided"}},
    {"texture", {"bitmap", "checkerboard", "mesh_attribute", "volume"}},
    {"emitter",
     {"area", "constant", "directional", "directionalarea", "envmap", "point", "projector", "spot",
      "sunsky", "timed_sunsky"}},
    {"spectrum", {"blackbody", "d65", "irregular", "rawconstant", "regular", "srgb", "uniform"}},
    {"medium", {"heterogeneous", "homogeneous"}},
    {"phase", {"blendphase", "hg", "isotropic", "rayleigh", "sggx", "tabphase"}},
    {"volume", {"constvolume", "gridvolume"}},
};

static const struct {
    const char *tag;
    enum element_kind kind;
} elements[] = {
    {"ref", ELEMENT_REFERENCE},       {"default", ELEMENT_DEFAULT},
    {"boolean", ELEMENT_PROPERTY},    {"integer", ELEMENT_PROPERTY},
    {"float", ELEMENT_PROPERTY},      {"string", ELEMENT_PROPERTY},
    {"point", ELEMENT_PROPERTY},      {"vector", ELEMENT_PROPERTY},
    {"rgb", ELEMENT_PROPERTY},        {"spectrum", ELEMENT_PROPERTY},
    {"transform", ELEMENT_TRANSFORM}, {"translate", ELEMENT_OPERATION},
    {"rotate", ELEMENT_OPERATION},    {"scale", ELEMENT_OPERATION},
    {"lookat", ELEMENT_OPERATION},    {"matrix", ELEMENT_OPERATION},
    {"animation", ELEMENT_ANIMATION},
};

enum element_kind element_kind(const char *tag) {
    for (size_t i = 0; i < sizeof(elements) / sizeof(*elements); i++)
        if (!strcmp(tag, elements[i].tag))
            return elements[i].kind;
    for (size_t i = 0; i < sizeof(plugins) / sizeof(*plugins); i++)
        if (!strcmp(tag, plugins[i].tag))
            return ELEMENT_OBJECT;
    return ELEMENT_UNKNOWN;
}

bool plugin_is_known(const char *tag, const char *type) {
    for (size_t i = 0; i < sizeof(plugins) / sizeof(*plugins); i++) {
        if (strcmp(tag, plugins[i].tag))
            continue;
        for (int j = 0; j < MAX_PLUGINS && plugins[i].types[j]; j++)
            if (!strcmp(type, plugins[i].types[j]))
                return true;
    }
    return false;
}
