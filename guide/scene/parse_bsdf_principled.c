/* SPDX-License-Identifier: Apache-2.0 */
/* Mitsuba's `principled`, after Burley's BSDF (2012, 2015). */

#include <string.h>

#include "guide/scene/parse_bsdf.h"

static const char *const names[PRINCIPLED_COUNT] = {
    [PRINCIPLED_METALLIC] = "metallic",
    [PRINCIPLED_ROUGHNESS] = "roughness",
    [PRINCIPLED_ANISOTROPIC] = "anisotropic",
    [PRINCIPLED_SPEC_TRANS] = "spec_trans",
    [PRINCIPLED_SPEC_TINT] = "spec_tint",
    [PRINCIPLED_SHEEN] = "sheen",
    [PRINCIPLED_SHEEN_TINT] = "sheen_tint",
    [PRINCIPLED_CLEARCOAT] = "clearcoat",
    [PRINCIPLED_CLEARCOAT_GLOSS] = "clearcoat_gloss",
    [PRINCIPLED_FLATNESS] = "flatness",
};

/* A part is off where its parameter is missing or 0. */
static int parse_parts(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    for (int i = 0; i < PRINCIPLED_COUNT; i++) {
        if (i != PRINCIPLED_ROUGHNESS && !param_find(node, names[i]))
            continue;
        int status = parse_grey(loader, node, names[i], 0.5f, &out->principled[i]);
        if (status)
            return status;
        const struct texture *texture = &loader->scene->textures[out->principled[i]];
        if (i != PRINCIPLED_ROUGHNESS && texture->kind == TEXTURE_CONSTANT &&
            !(max_component(texture->color0) > 0))
            out->principled[i] = -1;
    }
    return FEWRAY_OK;
}

/* The index of refraction, or what `specular` makes of it: a normal reflectance of 0.08 specular.
 * With a transmission they may not be those of nothing: Mitsuba's least values. */
static int parse_eta(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    bool transmits = out->principled[PRINCIPLED_SPEC_TRANS] >= 0;
    struct xml_node *given = param_find(node, "eta");
    double eta = 1.5, specular = 0.5;
    if (given && param_find(node, "specular"))
        return loader_fail(loader, FEWRAY_ERROR_FORMAT, given, "both eta and specular are given");
    if (given) {
        int status = param_number(loader, node, "eta", 1e-3, 1e3, &eta);
        out->eta = (float)(transmits && eta == 1 ? 1.001 : eta);
        return status;
    }
    int status = param_number(loader, node, "specular", 0, 10, &specular);
    if (transmits && specular == 0)
        specular = 1e-3;
    out->eta = (float)(2 / (1 - sqrt(0.08 * specular)) - 1);
    return status;
}

int parse_principled(struct loader *loader, struct xml_node *node, struct bsdf *out) {
    /* They steer how Mitsuba samples, not what is sampled. */
    static const char *const ignored[] = {"main_specular_sampling_rate", "clearcoat_sampling_rate",
                                          "diffuse_reflectance_sampling_rate", NULL};
    params_ignore(node, ignored);
    int status =
        parse_reflectance(loader, node, "base_color", vec(0.5f, 0.5f, 0.5f), &out->reflectance);
    if (!status)
        status = parse_parts(loader, node, out);
    if (!status)
        status = parse_eta(loader, node, out);
    out->tangents = out->principled[PRINCIPLED_ANISOTROPIC] >= 0;
    return status;
}
